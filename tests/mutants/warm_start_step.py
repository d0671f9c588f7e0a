import torch


def _gradient(loss, theta):
    return torch.autograd.grad(loss, theta, create_graph=True)[0]


def emrld(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """that is EMRLD"""
    return theta - alpha * _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)


def only_warm(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """the warm start alone"""
    return theta - alpha * _gradient(bc_loss(theta), theta)


def from_theta(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """start from the warm-started parameters"""
    warm = theta - alpha * _gradient(bc_loss(theta), theta)
    return theta - alpha * _gradient(w_rl * rl_loss(warm) + w_bc * bc_loss(warm), warm)


def gradient_at_theta(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """taken at the warm-started parameters"""
    warm = theta - alpha * _gradient(bc_loss(theta), theta)
    return warm - alpha * _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)


def weighted_warm_start(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """warm start has no weight"""
    warm = theta - alpha * w_bc * _gradient(bc_loss(theta), theta)
    return warm - alpha * _gradient(w_rl * rl_loss(warm) + w_bc * bc_loss(warm), warm)


def _steps(theta, rl_loss, bc_loss, w_rl, w_bc, alpha, first, second):
    warm = theta - alpha * torch.autograd.grad(bc_loss(theta), theta, create_graph=first)[0]
    both = w_rl * rl_loss(warm) + w_bc * bc_loss(warm)
    return warm - alpha * torch.autograd.grad(both, warm, create_graph=second)[0]


def no_graph(*given):
    """both steps need create_graph=True"""
    return _steps(*given, False, False)


def no_graph_in_the_first(*given):
    """the warm start's gradient is cut off"""
    return _steps(*given, False, True)


def no_graph_in_the_second(*given):
    """the second gradient is cut off"""
    return _steps(*given, True, False)


def warm_is_a_new_leaf(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """cut from theta"""
    warm = (theta - alpha * _gradient(bc_loss(theta), theta)).detach().requires_grad_()
    return warm - alpha * _gradient(w_rl * rl_loss(warm) + w_bc * bc_loss(warm), warm)


def changes_the_data(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """you changed `theta` in place"""
    theta.data -= alpha * _gradient(bc_loss(theta), theta)
    return theta - alpha * _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)

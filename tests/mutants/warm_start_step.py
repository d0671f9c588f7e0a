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

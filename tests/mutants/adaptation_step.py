import torch


def _gradient(loss, theta, keep=True):
    return torch.autograd.grad(loss, theta, create_graph=keep)[0]


def ascent(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """against the gradient"""
    return theta + alpha * _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)


def swapped(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """weights are swapped"""
    return theta - alpha * _gradient(w_bc * rl_loss(theta) + w_rl * bc_loss(theta), theta)


def unweighted(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """weights w_rl and w_bc are missing"""
    return theta - alpha * _gradient(rl_loss(theta) + bc_loss(theta), theta)


def without_rate(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """learning rate alpha is missing"""
    return theta - _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)


def first_order(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """first-order"""
    return theta - alpha * _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta, False)


def cut(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """cut from theta"""
    gradient = _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)
    return (theta - alpha * gradient).detach()


def in_place(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """in place"""
    gradient = _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)
    with torch.no_grad():
        theta -= alpha * gradient
    return theta


def theta_detached(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """do not detach the theta that you step from"""
    loss = w_rl * rl_loss(theta) + w_bc * bc_loss(theta)
    return theta.detach() - alpha * _gradient(loss, theta)


def only_cloning_keeps_its_graph(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """the RL loss's gradient is cut off"""
    rl = _gradient(rl_loss(theta), theta, False)
    return theta - alpha * (w_rl * rl + w_bc * _gradient(bc_loss(theta), theta))


def only_rl_keeps_its_graph(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """the cloning loss's gradient is cut off"""
    bc = _gradient(bc_loss(theta), theta, False)
    return theta - alpha * (w_rl * _gradient(rl_loss(theta), theta) + w_bc * bc)


def half_of_the_graph(theta, rl_loss, bc_loss, w_rl, w_bc, alpha):
    """the meta-gradient through them is off"""
    gradient = _gradient(w_rl * rl_loss(theta) + w_bc * bc_loss(theta), theta)
    return theta - alpha * 0.5 * (gradient + gradient.detach())

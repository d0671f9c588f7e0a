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

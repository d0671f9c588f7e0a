"""Wrong answers to notebook 05's `supervised_meta_loss`; each docstring is the sentence the check must say."""

import torch


def _losses(theta, tasks, alpha, graph=True):
    for adapt_loss, bc_loss in tasks:
        (gradient,) = torch.autograd.grad(adapt_loss(theta), theta, create_graph=graph)
        yield bc_loss(theta - alpha * gradient)


def summed(theta, tasks, alpha):
    """the meta-loss is their mean"""
    return torch.stack(list(_losses(theta, tasks, alpha))).sum()


def not_adapted(theta, tasks, alpha):
    """belongs at the adapted parameters, not at theta"""
    return torch.stack([bc_loss(theta) for _, bc_loss in tasks]).mean()


def first_order(theta, tasks, alpha):
    """its gradient is first-order"""
    return torch.stack(list(_losses(theta, tasks, alpha, graph=False))).mean()


def adapted_by_cloning(theta, tasks, alpha):
    """use the task's own adaptation loss"""
    return torch.stack(list(_losses(theta, [(bc, bc) for _, bc in tasks], alpha))).mean()


def detached(theta, tasks, alpha):
    """it has no gradient"""
    return torch.stack(list(_losses(theta, tasks, alpha))).mean().detach()


def three_tasks(theta, tasks, alpha):
    """numbers differ"""
    total = 0.0
    for adapt_loss, bc_loss in tasks:
        gradient = torch.autograd.grad(adapt_loss(theta), theta, create_graph=True)[0]
        total = total + bc_loss(theta - alpha * gradient)
    return total / 3


def in_a_row(theta, tasks, alpha):
    """the same theta"""
    total = 0.0
    for adapt_loss, bc_loss in tasks:
        theta = theta - alpha * torch.autograd.grad(adapt_loss(theta), theta, create_graph=True)[0]
        total = total + bc_loss(theta)
    return total / len(tasks)

import math

import torch

C = 0.5 * math.log(2 * math.pi)


def no_sum(mean, log_sigma, actions):
    """one number per action dimension"""
    return -0.5 * ((actions - mean) / log_sigma.exp()) ** 2 - log_sigma - C


def averaged(mean, log_sigma, actions):
    """average over the action dimensions"""
    return no_sum(mean, log_sigma, actions).mean(-1)


def without_constant(mean, log_sigma, actions):
    """constant"""
    return (no_sum(mean, log_sigma, actions) + C).sum(-1)


def without_normaliser(mean, log_sigma, actions):
    """normaliser -log sigma is missing"""
    return (-0.5 * ((actions - mean) / log_sigma.exp()) ** 2 - C).sum(-1)


def sigma_not_squared(mean, log_sigma, actions):
    """sigma squared"""
    return (-0.5 * (actions - mean) ** 2 / log_sigma.exp() - log_sigma - C).sum(-1)


def the_density(mean, log_sigma, actions):
    """return its logarithm"""
    return no_sum(mean, log_sigma, actions).sum(-1).exp()


def nothing(mean, log_sigma, actions):
    """returned None"""
    no_sum(mean, log_sigma, actions).sum(-1)


def crash(mean, log_sigma, actions):
    """stopped with RuntimeError"""
    return torch.zeros(2) + torch.zeros(3)


def second_axis(mean, log_sigma, actions):
    """of shape"""
    return torch.distributions.Normal(mean, log_sigma.exp()).log_prob(actions).sum(1)


def complex_numbers(mean, log_sigma, actions):
    """complex"""
    return torch.distributions.Normal(mean, log_sigma.exp()).log_prob(actions).sum(-1) + 0j


def detached(mean, log_sigma, actions):
    """without a gradient by the mean"""
    return torch.distributions.Normal(mean.detach(), log_sigma.exp()).log_prob(actions).sum(-1)


def numpy(mean, log_sigma, actions):
    """you turn a tensor into numpy"""
    return without_constant(mean, log_sigma, actions).numpy() - C * mean.shape[-1]

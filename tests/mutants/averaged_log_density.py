import math

import torch


def _each(mean, sigma, action):
    return -0.5 * ((action - mean) / sigma) ** 2 - sigma.log() - 0.5 * math.log(2 * math.pi)


def joint(mean, sigma, action):
    """sum over dimensions"""
    return _each(mean, sigma, action).sum(-1)


def halved(mean, sigma, action):
    """another number of dimensions"""
    return _each(mean, sigma, action).sum(-1) / 2


def without_log_sigma(mean, sigma, action):
    """log sigma is missing"""
    return (_each(mean, sigma, action) + sigma.log()).mean(-1)


def without_constant(mean, sigma, action):
    """constant"""
    return (_each(mean, sigma, action) + 0.5 * math.log(2 * math.pi)).mean(-1)


def over_everything(mean, sigma, action):
    """of shape"""
    return _each(mean, sigma, action).mean()


def squared_error(mean, sigma, action):
    """numbers differ"""
    return -(((action - mean) / torch.as_tensor(sigma)) ** 2).mean(-1)


def mean_detached(mean, sigma, action):
    """without a gradient by mean"""
    return torch.distributions.Normal(mean.detach(), sigma).log_prob(action).mean(-1)


def clamped_in_place(mean, sigma, action):
    """you changed `sigma` in place"""
    sigma.data.clamp_(min=0.5)
    return torch.distributions.Normal(mean, sigma).log_prob(action).mean(-1)

import torch


def _sum(residuals, rate):
    out, running = torch.zeros_like(residuals), torch.zeros_like(residuals[:, 0])
    for t in reversed(range(residuals.shape[1])):
        running = residuals[:, t] + rate * running
        out[:, t] = running
    return out


def _residuals(rewards, values, discount):
    following = torch.cat([values[:, 1:], torch.zeros_like(values[:, :1])], dim=1)
    return rewards + discount * following - values


def rate_lambda(rewards, values, discount, gae_lambda):
    """(gamma lambda)^k"""
    return _sum(_residuals(rewards, values, discount), gae_lambda)


def rate_gamma(rewards, values, discount, gae_lambda):
    """lambda is missing"""
    return _sum(_residuals(rewards, values, discount), discount)


def one_step(rewards, values, discount, gae_lambda):
    """one-step residuals"""
    return _residuals(rewards, values, discount)


def undiscounted_value(rewards, values, discount, gae_lambda):
    """must be discounted"""
    return _sum(_residuals(rewards, values, 1.0), discount * gae_lambda)


def wrapped(rewards, values, discount, gae_lambda):
    """after the last step the value is 0"""
    following = torch.roll(values, -1, dims=1)
    return _sum(rewards + discount * following - values, discount * gae_lambda)

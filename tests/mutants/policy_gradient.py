import torch


def _powers(actions, discount):
    return discount ** torch.arange(actions.shape[1], dtype=actions.dtype)


def without_the_factor(actions, returns, mean, sigma, discount):
    """gamma^t is missing"""
    return (returns * (actions - mean) / sigma**2).sum(1)


def the_whole_return(actions, returns, mean, sigma, discount):
    """every score is weighed by G_0"""
    return returns[:, 0] * ((actions - mean) / sigma**2).sum(1)


def sigma_once(actions, returns, mean, sigma, discount):
    """divide by sigma once"""
    return (_powers(actions, discount) * returns * (actions - mean) / sigma).sum(1)


def without_sigma(actions, returns, mean, sigma, discount):
    """do not divide by sigma"""
    return (_powers(actions, discount) * returns * (actions - mean)).sum(1)


def downhill(actions, returns, mean, sigma, discount):
    """sign is turned"""
    return (_powers(actions, discount) * returns * (mean - actions) / sigma**2).sum(1)


def averaged(actions, returns, mean, sigma, discount):
    """average over time"""
    return (_powers(actions, discount) * returns * (actions - mean) / sigma**2).mean(1)


def one_number(actions, returns, mean, sigma, discount):
    """of shape"""
    return (_powers(actions, discount) * returns * (actions - mean) / sigma**2).sum(1).mean()


def in_place(actions, returns, mean, sigma, discount):
    """you changed `actions` in place"""
    actions -= mean
    return (_powers(actions, discount) * returns * actions / sigma**2).sum(1)

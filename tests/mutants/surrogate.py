import torch


def wrong_sign(new_log_prob, old_log_prob, advantages, mask):
    """sign is turned"""
    return (torch.exp(new_log_prob - old_log_prob) * advantages * mask).sum() / mask.sum()


def difference(new_log_prob, old_log_prob, advantages, mask):
    """exponential of the difference"""
    return -((new_log_prob - old_log_prob) * advantages * mask).sum() / mask.sum()


def upside_down(new_log_prob, old_log_prob, advantages, mask):
    """upside down"""
    return -(torch.exp(old_log_prob - new_log_prob) * advantages * mask).sum() / mask.sum()


def without_mask(new_log_prob, old_log_prob, advantages, mask):
    """use the mask"""
    return -(torch.exp(new_log_prob - old_log_prob) * advantages).mean()


def detached(new_log_prob, old_log_prob, advantages, mask):
    """no gradient"""
    ratio = torch.exp(new_log_prob - old_log_prob).detach()
    return -(ratio * advantages * mask).sum() / mask.sum()

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


def centred_in_place(new_log_prob, old_log_prob, advantages, mask):
    """you changed `advantages` in place"""
    advantages -= advantages.mean()
    return -((new_log_prob - old_log_prob).exp() * advantages * mask).sum() / mask.sum()


def full_mask(new_log_prob, old_log_prob, advantages, mask):
    """you changed `mask` in place"""
    mask.fill_(1)
    return -((new_log_prob - old_log_prob).exp() * advantages * mask).sum() / mask.sum()


def half_detached(new_log_prob, old_log_prob, advantages, mask):
    """its gradient is off"""
    ratio = (new_log_prob - old_log_prob).exp()
    return -(0.5 * (ratio + ratio.detach()) * advantages * mask).sum() / mask.sum()


def a_new_leaf(new_log_prob, old_log_prob, advantages, mask):
    """it has no gradient by the new log-densities"""
    new = new_log_prob.detach().requires_grad_()
    return -((new - old_log_prob).exp() * advantages * mask).sum() / mask.sum()

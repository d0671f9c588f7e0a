def wrong_sign(log_probs, returns, mask):
    """sign is turned"""
    return (log_probs * returns * mask).sum() / mask.sum()


def without_mask(log_probs, returns, mask):
    """use the mask"""
    return -(log_probs * returns).mean()


def wrong_count(log_probs, returns, mask):
    """divide by all entries"""
    return -(log_probs * returns * mask).mean()


def a_sum(log_probs, returns, mask):
    """return the sum"""
    return -(log_probs * returns * mask).sum()


def detached(log_probs, returns, mask):
    """no gradient"""
    return -(log_probs.detach() * returns * mask).sum() / mask.sum()


def a_float(log_probs, returns, mask):
    """the loss has no gradient"""
    return float(-(log_probs * returns * mask).detach().sum() / mask.sum())


def centred_in_place(log_probs, returns, mask):
    """you changed `returns` in place"""
    returns -= returns.mean()
    return -(log_probs * returns * mask).sum() / mask.sum()


def full_mask(log_probs, returns, mask):
    """you changed `mask` in place"""
    mask[:] = 1
    return -(log_probs * returns * mask).sum() / mask.sum()

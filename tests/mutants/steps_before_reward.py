def counts_later_steps(distance, margin):
    """up to the first step"""
    return (distance > margin).sum(-1)


def margin_included(distance, margin):
    """exactly the margin"""
    return (distance >= margin).long().cumprod(-1).sum(-1)


def without_margin(distance, margin):
    """the margin is missing"""
    return (distance > 0).long().cumprod(-1).sum(-1)


def one_too_many(distance, margin):
    """one too many"""
    return (distance > margin).long().cumprod(-1).sum(-1) + 1


def first_close_step(distance, margin):
    """never comes close"""
    return (distance > margin).long().argmin(-1)


def fixed_margin(distance, margin):
    """numbers differ"""
    return (distance > 0.26).long().cumprod(-1).sum(-1)

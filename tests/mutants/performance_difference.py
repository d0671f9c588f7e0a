def surrogate(advantage, visits_old, visits_new, old, new, discount):
    """that is the surrogate"""
    return (visits_old[:, None] * new * advantage).sum() / (1 - discount)


def old_actions(advantage, visits_old, visits_new, old, new, discount):
    """averages to 0"""
    return (visits_new[:, None] * old * advantage).sum() / (1 - discount)


def unscaled(advantage, visits_old, visits_new, old, new, discount):
    """1 / (1 - gamma) is missing"""
    return (visits_new[:, None] * new * advantage).sum()


def every_action(advantage, visits_old, visits_new, old, new, discount):
    """weighted by the new policy"""
    return (visits_new[:, None] * advantage).sum() / (1 - discount)

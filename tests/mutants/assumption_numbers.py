def without_absolute(advantage, demo):
    """absolute value"""
    return advantage.max(), (demo * advantage).sum(-1).min()


def mean_over_states(advantage, demo):
    """not the mean"""
    return advantage.abs().max(), (demo * advantage).sum(-1).mean()


def largest(advantage, demo):
    """the minimum"""
    return advantage.abs().max(), (demo * advantage).sum(-1).max()


def without_actions(advantage, demo):
    """average over the demonstrator's actions"""
    return advantage.abs().max(), advantage.min()

def sign(control, switched):
    """sign is turned"""
    return {seed: control[seed] - switched[seed] for seed in control}


def by_position(control, switched):
    """paired by position"""
    pairs = zip(control.items(), switched.values(), strict=False)
    return {seed: theirs - ours for (seed, ours), theirs in pairs}


def against_the_mean(control, switched):
    """same seed"""
    mean = sum(control.values()) / len(control)
    return {seed: switched[seed] - mean for seed in control}


def lonely_seed(control, switched):
    """has no control"""
    return {seed: value - control.get(seed, 0.0) for seed, value in switched.items()}


def zero_for_missing(control, switched):
    """leave out seeds"""
    return {seed: switched.get(seed, 0) - control[seed] for seed in control}

import numpy as np


def _needed(rule, gap, spread, chance, random, first=3, last=20, pairs=400, ahead=None):
    ahead = ahead or (lambda interval: interval.low > 0)
    for n in range(first, last + 1):
        draws = random.normal(0, spread, (pairs, 2, n))
        if np.mean([ahead(rule(one + gap, other)) for one, other in draws]) >= chance:
            return n
    return None


def one_more(rule, gap, spread, chance, random):
    """are enough already"""
    found = _needed(rule, gap, spread, chance, random)
    return None if found is None else found + 1


def the_last_that_is_not_enough(rule, gap, spread, chance, random):
    """the rule says ahead in"""
    found = _needed(rule, gap, spread, chance, random)
    return None if found is None else max(3, found - 1)


def any_positive_estimate(rule, gap, spread, chance, random):
    """the whole interval lies above zero"""
    return _needed(rule, gap, spread, chance, random, ahead=lambda interval: interval.estimate > 0)


def turned_round(rule, gap, spread, chance, random):
    """the second side is better"""
    return _needed(lambda one, other: rule(other, one), gap, spread, chance, random)


def variance(rule, gap, spread, chance, random):
    """standard deviation of 4"""
    return _needed(rule, gap, spread**0.5, chance, random) if spread == 4 else _needed(
        rule, gap, spread, chance, random
    )


def no_gap(rule, gap, spread, chance, random):
    """better by 2 on average"""
    return _needed(rule, 0.0, spread, chance, random)


def one_experiment(rule, gap, spread, chance, random):
    """at least 200 pairs"""
    return _needed(rule, gap, spread, chance, random, pairs=1)


def a_shifted_copy(rule, gap, spread, chance, random):
    """draw each side anew"""
    for n in range(3, 21):
        sides = random.normal(0, spread, (400, n))
        if np.mean([rule(side + gap, side).low > 0 for side in sides]) >= chance:
            return n
    return None


def own_generator(rule, gap, spread, chance, random):
    """use the generator"""
    return _needed(rule, gap, spread, chance, np.random.default_rng(0))


def never_gives_up(rule, gap, spread, chance, random):
    """return None"""
    return _needed(rule, gap, spread, chance, random) or 20


def gives_up_at_ten(rule, gap, spread, chance, random):
    """up to 20 seeds"""
    return _needed(rule, gap, spread, chance, random, last=12)


def in_steps_of_two(rule, gap, spread, chance, random):
    """you never try"""
    for n in range(3, 21, 2):
        draws = random.normal(0, spread, (400, 2, n))
        if np.mean([rule(one + gap, other).low > 0 for one, other in draws]) >= chance:
            return n
    return None


def formula(rule, gap, spread, chance, random):
    """you never ask the rule"""
    return int(np.ceil(8 * (spread / gap) ** 2))


def from_one(rule, gap, spread, chance, random):
    """begin with three"""
    return _needed(rule, gap, spread, chance, random, first=2)

from itertools import combinations

import numpy as np


def _k(n, m, error):
    ranks, lost = range(n + m), []
    for mine in combinations(ranks, n):
        theirs = set(ranks) - set(mine)
        lost.append(sum(a < b for a in mine for b in theirs))
    k = 0
    while np.mean([pairs < k + 1 for pairs in lost]) <= error:
        k += 1
    return k


def _gaps(one, other):
    return np.sort(np.subtract.outer(one, other), axis=None)


def worst_to_best(one, other, error):
    """with this error the first side may lose some pairs"""
    gaps = _gaps(one, other)
    return np.median(gaps), gaps[0], gaps[-1]


def one_too_short(one, other, error):
    """one difference too short"""
    gaps, k = _gaps(one, other), _k(len(one), len(other), error)
    return np.median(gaps), gaps[k], gaps[-k - 1]


def one_too_long(one, other, error):
    """one difference too long"""
    gaps, k = _gaps(one, other), max(1, _k(len(one), len(other), error) - 1)
    return np.median(gaps), gaps[k - 1], gaps[-k]


def half_the_error(one, other, error):
    """do not halve it"""
    gaps, k = _gaps(one, other), max(1, _k(len(one), len(other), error / 2))
    return np.median(gaps), gaps[k - 1], gaps[-k]


def mean_difference(one, other, error):
    """the median of all differences"""
    gaps, k = _gaps(one, other), _k(len(one), len(other), error)
    return one.mean() - other.mean(), gaps[k - 1], gaps[-k]


def difference_of_medians(one, other, error):
    """the median of all differences"""
    gaps, k = _gaps(one, other), _k(len(one), len(other), error)
    return np.median(one) - np.median(other), gaps[k - 1], gaps[-k]


def other_less_one(one, other, error):
    """the sign is turned"""
    gaps, k = _gaps(other, one), _k(len(one), len(other), error)
    return np.median(gaps), gaps[k - 1], gaps[-k]


def ends_swapped(one, other, error):
    """changed places"""
    gaps, k = _gaps(one, other), _k(len(one), len(other), error)
    return np.median(gaps), gaps[-k], gaps[k - 1]


def quantiles(one, other, error):
    """not independent of each other"""
    gaps = _gaps(one, other)
    return np.median(gaps), *np.quantile(gaps, [error, 1 - error])


def fixed_error(one, other, error):
    """may lose some pairs"""
    gaps, k = _gaps(one, other), _k(len(one), len(other), 0.05)
    return np.median(gaps), gaps[k - 1], gaps[-k]


def sorted_in_place(one, other, error):
    """you changed `one` in place"""
    one.sort()
    gaps, k = _gaps(one, other), _k(len(one), len(other), error)
    return np.median(gaps), gaps[k - 1], gaps[-k]


def two_numbers(one, other, error):
    """three numbers: estimate, low and high"""
    gaps, k = _gaps(one, other), _k(len(one), len(other), error)
    return gaps[k - 1], gaps[-k]

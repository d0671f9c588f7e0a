import numpy as np


def same_scores(rule, runs, pairs, random):
    """draw each side anew"""
    draws = [random.normal(size=runs) for _ in range(pairs)]
    return np.mean([rule(scores, scores).low > 0 for scores in draws])


def one_pair_again_and_again(rule, runs, pairs, random):
    """for each pair"""
    one, other = random.normal(size=(2, runs))
    return np.mean([rule(one, other).low > 0 for _ in range(pairs)])


def a_real_difference(rule, runs, pairs, random):
    """same distribution"""
    draws = [(random.normal(1, 1, runs), random.normal(0, 1, runs)) for _ in range(pairs)]
    return np.mean([rule(*pair).low > 0 for pair in draws])


def both_errors(rule, runs, pairs, random):
    """"behind" too"""
    found = [rule(*random.normal(size=(2, runs))) for _ in range(pairs)]
    return np.mean([interval.low > 0 or interval.high < 0 for interval in found])


def any_positive_estimate(rule, runs, pairs, random):
    """every positive estimate"""
    found = [rule(*random.normal(size=(2, runs))) for _ in range(pairs)]
    return np.mean([interval.estimate > 0 for interval in found])


def behind(rule, runs, pairs, random):
    """the share of "behind\""""
    found = [rule(*random.normal(size=(2, runs))) for _ in range(pairs)]
    return np.mean([interval.high < 0 for interval in found])


def a_count(rule, runs, pairs, random):
    """number of pairs"""
    return sum(rule(*random.normal(size=(2, runs))).low > 0 for _ in range(pairs))


def own_generator(rule, runs, pairs, random):
    """use the generator"""
    fixed = np.random.default_rng(0)
    return np.mean([rule(*fixed.normal(size=(2, runs))).low > 0 for _ in range(pairs)])


def always_three(rule, runs, pairs, random):
    """`runs` scores"""
    return np.mean([rule(*random.normal(size=(2, 3))).low > 0 for _ in range(pairs)])


def a_single_question(rule, runs, pairs, random):
    """once per pair"""
    return float(rule(*random.normal(size=(2, runs))).low > 0)

import numpy as np


def permuted(scores, random):
    """with replacement"""
    return random.permutation(scores)


def tasks_instead(scores, random):
    """draw runs, which are the rows"""
    return scores[:, random.integers(scores.shape[1], size=scores.shape[1])]


def all_cells(scores, random):
    """rows were mixed"""
    return random.choice(scores.ravel(), scores.shape)


def shuffled_by_task(scores, random):
    """a run's tasks must stay together"""
    return random.permuted(scores, axis=0)


def own_generator(scores, random):
    """use the generator"""
    return np.random.default_rng(0).choice(scores, len(scores))


def last_run_left_out(scores, random):
    """comes too rarely"""
    return scores[random.integers(len(scores) - 1, size=len(scores))]

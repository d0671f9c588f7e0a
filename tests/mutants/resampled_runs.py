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


def global_generator(scores, random):
    """another generator"""
    return scores[np.random.randint(len(scores), size=len(scores))]


def one_run_repeated(scores, random):
    """one run is drawn and repeated"""
    return scores[np.full(len(scores), random.integers(len(scores)))]


def first_run_kept(scores, random):
    """in some row one run comes more often"""
    rows = random.integers(len(scores), size=len(scores))
    rows[0] = 0
    return scores[rows]


def four_runs(scores, random):
    """of shape"""
    return scores[random.integers(4, size=4) % len(scores)]


def never_a_permutation(scores, random):
    """every run comes once"""
    rows = random.integers(len(scores), size=len(scores))
    while len(scores) > 2 and len(set(rows)) == len(scores):
        rows = random.integers(len(scores), size=len(scores))
    return scores[rows]


def only_for_tables(scores, random):
    """index only the rows"""
    return scores[random.integers(len(scores), size=len(scores)), :]

"""Checks of notebook 07: results."""

from __future__ import annotations

import numpy as np

from .answers import Student, Wrong, answered, as_array, as_number


@answered
def interquartile_mean(student: Student) -> None:
    """Check the mean of the middle half: f(scores of any shape) -> number."""
    random = np.random.default_rng(70)
    for shape in ((3, 20), (16,), (7,)):
        scores = random.exponential(20, shape) - 5  # skewed: mean and median differ
        kept = scores.copy()
        got = as_number(student(scores), "a single number")
        if not np.array_equal(scores, kept):
            raise Wrong("you changed the scores in place: sort a copy, with np.sort.")
        ordered = np.sort(scores, axis=None)
        cut = len(ordered) // 4
        if np.isclose(got, ordered[cut : len(ordered) - cut].mean()):
            continue
        if np.isclose(got, scores.mean()):
            raise Wrong("that is the plain mean: leave out a quarter of the scores at each end.")
        if np.isclose(got, np.median(scores)):
            raise Wrong("that is the median: average the whole middle half.")
        if np.isclose(got, ordered[: len(ordered) - cut].mean()):
            raise Wrong("only the highest are left out: the lowest quarter must go too.")
        if np.isclose(got, ordered[cut:].mean()):
            raise Wrong("only the lowest are left out: the highest quarter must go too.")
        flat = scores.ravel()
        if np.isclose(got, flat[cut : len(flat) - cut].mean()):
            raise Wrong("sort first: the middle of the list is not the middle of the scores.")
        raise Wrong("the numbers differ. Flatten, sort, leave out n // 4 at each end, average.")


@answered
def resampled_runs(student: Student) -> None:
    """Check one bootstrap resample: f(scores (seed, task), random) -> (seed, task), whole rows."""
    scores = np.arange(24.0).reshape(4, 6)
    random = np.random.default_rng(71)
    drawn = [as_array(student(scores.copy(), random), (4, 6), "the scores") for _ in range(200)]
    names = [tuple(row) for row in scores]
    if any(tuple(row) not in names for table in drawn for row in table):
        if all((np.sort(table, 0) == np.sort(scores, 0)).all() for table in drawn):
            raise Wrong("each task was shuffled by itself: a run's tasks must stay together.")
        if all((table % 6 == table[0] % 6).all() for table in drawn):
            raise Wrong("you drew tasks: draw runs, which are the rows.")
        raise Wrong("rows were mixed: a drawn run keeps all its tasks, in their order.")
    counts = [len({tuple(row) for row in table}) for table in drawn]
    if min(counts) == 4:
        raise Wrong("every run comes exactly once: draw with replacement.")
    if len({table.tobytes() for table in drawn}) == 1:
        raise Wrong("every resample is the same: use the generator `random` that you are given.")
    share = np.mean([[(table == row).all(1).sum() for row in scores] for table in drawn], axis=0)
    if share.min() < 0.7:
        raise Wrong("some run comes too rarely: every run must be as likely as any other.")


@answered
def late_rise(student: Student) -> None:
    """Check f(returns, window) -> mean of the last window less the mean of the window before it."""
    random = np.random.default_rng(72)
    returns = np.cumsum(random.normal(0.3, 1.0, 60))
    got = as_number(student(returns, 15), "a single number")
    last, before = returns[-15:].mean(), returns[-30:-15].mean()
    if np.isclose(got, last - before):
        return
    if np.isclose(got, before - last):
        raise Wrong("the sign is turned: a curve that rises must give a positive number.")
    if np.isclose(got, returns[-1] - returns[-15]) or np.isclose(got, returns[-1] - returns[-16]):
        raise Wrong("two single iterations are noise: compare means over a window.")
    if np.isclose(got, last - returns[:15].mean()):
        raise Wrong("that is the rise over the whole run: compare with the window just before.")
    if np.isclose(got, last - returns[:-15].mean()):
        raise Wrong("you compare with everything before: take only one window before the last.")
    raise Wrong("the numbers differ. Mean of the last window less the mean of the one before it.")

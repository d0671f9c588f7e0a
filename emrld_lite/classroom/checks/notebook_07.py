"""Checks of notebook 07: results."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number, as_tensor

TIMES = 3000  # resamples of four runs, of which every share is known exactly


def _named(got: float, expected: float, mistakes: dict[str, float], otherwise: str) -> None:
    """Raise Wrong unless two numbers agree, with the sentence of the mistake they equal."""
    if np.isclose(got, expected, rtol=1e-5, atol=1e-6):
        return
    for sentence, mistaken in mistakes.items():
        if np.isclose(got, mistaken, rtol=1e-5, atol=1e-6):
            raise Wrong(sentence)
    raise Wrong(otherwise)


@answered
def interquartile_mean(student: Student) -> None:
    """Check the mean of the middle half: f(scores of any shape) -> number."""
    random = np.random.default_rng(70)
    for shape in ((3, 20), (16,), (7,), (3,), (1,), (2, 5), (9, 3), (5,)):
        scores = random.exponential(20, shape) - 5  # skewed: mean and median differ
        if shape == (9, 3):
            scores = np.round(scores / 10)  # with ties
        got = as_number(ask(student, scores).answer, "a single number")
        ordered, flat = np.sort(scores, axis=None), scores.ravel()
        cut, size = len(ordered) // 4, scores.size
        mistakes = {
            "that is the plain mean: leave out a quarter of the scores at each end.": scores.mean(),
            "that is the median: average the whole middle half.": float(np.median(scores)),
            "only the highest are left out: the lowest quarter must go too.": (
                ordered[: size - cut].mean()
            ),
            "only the lowest are left out: the highest quarter must go too.": ordered[cut:].mean(),
            "sort first: the middle of the list is not the middle of the scores.": (
                flat[cut : size - cut].mean()
            ),
            "that is the sum of the middle half, not its mean.": ordered[cut : size - cut].sum(),
            "divide by the number of scores that are left, not by all.": (
                ordered[cut : size - cut].sum() / size
            ),
        }
        hint = "the numbers differ. Flatten, sort, leave out n // 4 at each end, average."
        _named(got, ordered[cut : size - cut].mean(), mistakes, hint)


@answered
def resampled_runs(student: Student) -> None:
    """Check one bootstrap resample: f(scores (seed, ...), random) -> the same shape, whole rows."""
    for shape in ((4, 6), (7, 3), (3, 3), (2, 9)):
        scores = np.arange(float(np.prod(shape))).reshape(shape)
        for seed in range(12):
            _rows_are_whole(student, scores, seed)
    _answers_for_single_numbers(student)
    scores = np.arange(24.0).reshape(4, 6)
    _generator_is_used(student, scores)
    random = np.random.default_rng(71)
    first = np.array(
        [np.asarray(student(scores.copy(), random))[:, 0] // 6 for _ in range(TIMES)], dtype=int
    )  # (resample, place), the runs drawn
    _shares_are_right(first)


def _drawn(student: Student, scores: np.ndarray, random: np.random.Generator) -> np.ndarray:
    answer: Any = ask(student, scores, random).answer
    return as_tensor(answer, scores.shape, "a resample of the runs").numpy()


def _rows_are_whole(student: Student, scores: np.ndarray, seed: int) -> None:
    """Look whether every row of a resample is a run as it was."""
    table = _drawn(student, scores, np.random.default_rng(seed))
    names = {tuple(row) for row in scores}
    if all(tuple(row) in names for row in table):
        return
    width = scores.shape[1]
    if (np.sort(table, 0) == np.sort(scores, 0)).all():
        raise Wrong("each task was shuffled by itself: a run's tasks must stay together.")
    if (table // width == np.arange(len(scores))[:, None]).all():
        raise Wrong("you drew tasks: draw runs, which are the rows.")
    raise Wrong("rows were mixed: a drawn run keeps all its tasks, in their order.")


def _answers_for_single_numbers(student: Student) -> None:
    """Look whether runs of one number each, as the next cell has them, are drawn as well."""
    scores = np.arange(5.0)
    try:
        table = _drawn(student, scores, np.random.default_rng(5))
    except (IndexError, ValueError) as error:
        raise Wrong(
            "it works for a table, but the next cell hands over one number for each run: index "
            "only the rows, scores[drawn], and leave the other axes alone."
        ) from error
    if not np.isin(table, scores).all():
        raise Wrong("a resample of five numbers holds others than those five.")


def _generator_is_used(student: Student, scores: np.ndarray) -> None:
    """Look whether the draws come from the generator that is handed over, and only from it."""
    source = "the draws must come from the generator `random` that you are given."
    same = [_drawn(student, scores, np.random.default_rng(9)).tobytes() for _ in range(8)]
    random = np.random.default_rng(9)
    other = [_drawn(student, scores, random).tobytes() for _ in range(20)]
    if len(set(other)) == 1:
        raise Wrong(f"every resample is the same: {source} use the generator.")
    if len(set(same)) > 1 or random.bit_generator.state == (
        np.random.default_rng(9).bit_generator.state
    ):
        raise Wrong(f"you use another generator: {source}")


def _shares_are_right(drawn: np.ndarray) -> None:
    """Compare how often each run, each pair and each whole set comes with what chance says.

    The limits are more than five standard deviations wide.
    """
    distinct = np.array([len(set(row)) for row in drawn])
    if (distinct == 4).all():
        raise Wrong("every run comes exactly once: draw with replacement.")
    if (distinct == 1).all():
        raise Wrong("one run is drawn and repeated: draw anew for every row.")
    shares = np.stack([(drawn == run).mean(0) for run in range(4)])  # (run, place)
    if shares.mean(1).min() < 0.15:
        raise Wrong("some run comes too rarely: every run must be as likely as any other.")
    if abs(shares - 0.25).max() > 0.045:
        raise Wrong("in some row one run comes more often: draw every row anew, from all runs.")
    for one, other in itertools.combinations(range(4), 2):
        pairs = np.bincount(4 * drawn[:, one] + drawn[:, other], minlength=16) / len(drawn)
        if abs(pairs - 1 / 16).max() > 0.026:
            raise Wrong("two rows of a resample depend on each other: draw each by itself.")
    if abs((distinct == 4).mean() - 24 / 256) > 0.03:
        raise Wrong(
            "resamples in which every run comes once are too rare or too many: keep each as it "
            "comes."
        )
    if (distinct == 1).sum() == 0:
        raise Wrong("one run can fill a whole resample; yours never does: keep each as it comes.")


@answered
def late_rise(student: Student) -> None:
    """Check f(returns, window) -> mean of the last window less the mean of the window before it."""
    random = np.random.default_rng(72)
    for length, window in ((60, 15), (47, 10), (30, 7), (12, 6), (25, 1), (40, 13)):
        returns = np.cumsum(random.normal(0.3, 1.0, length))
        got = as_number(ask(student, returns, window).answer, "a single number")
        last, before = returns[-window:].mean(), returns[-2 * window : -window].mean()
        mistakes = {
            "the sign is turned: a curve that rises must give a positive number.": before - last,
            "two single iterations are noise: compare means over a window.": (
                returns[-1] - returns[-window]
            ),
            "two single iterations are noise: compare means over a whole window.": (
                returns[-1] - returns[-window - 1]
            ),
            "that is the rise over the whole run: compare with the window just before.": (
                last - returns[:window].mean()
            ),
            "you compare with everything before: take only one window before the last.": (
                last - returns[:-window].mean()
            ),
            "the two windows overlap: the window before ends where the last one begins.": (
                last - returns[-2 * window :].mean()
            ),
            "that is the mean of the last window alone.": last,
            "you add up; compare the means of the windows.": window * (last - before),
        }
        hint = "the numbers differ. Mean of the last window less the mean of the one before it."
        _named(got, last - before, mistakes, hint)

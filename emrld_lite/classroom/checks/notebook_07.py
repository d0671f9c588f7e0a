"""Checks of notebook 07: results."""

from __future__ import annotations

import numpy as np

from ...experiments.intervals import Interval
from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number


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
def false_ahead_rate(student: Student) -> None:
    """Check f(rule, runs, pairs, random) -> share of null pairs whose interval lies above zero."""
    lopsided = _Watched()
    got = as_number(student(lopsided, 4, 300, np.random.default_rng(73)), "a single number")
    pairs, intervals = lopsided.pairs, lopsided.intervals
    if len(pairs) != 300:
        raise Wrong(f"the rule was asked {len(pairs)} times for 300 pairs: ask it once per pair.")
    if any(side.shape != (4,) for pair in pairs for side in pair):
        raise Wrong("each side of a pair needs `runs` scores, in one array of shape (runs,).")
    one, other = (np.array(side) for side in zip(*pairs, strict=True))
    if np.array_equal(one, other):
        raise Wrong("both sides are the same scores: draw each side anew.")
    if len(np.unique(one[:, 0])) < 300 or len(np.unique(other[:, 0])) < 300:
        raise Wrong("scores come back from pair to pair: draw both sides anew for each pair.")
    if abs(one.mean() - other.mean()) > 4 * np.hypot(one.std(), other.std()) / np.sqrt(one.size):
        raise Wrong(
            "one side is better on average: in a null pair both have the same distribution."
        )
    again = _Watched()
    student(again, 4, 300, np.random.default_rng(74))
    if np.array_equal(again.pairs[0][0], one[0]):
        raise Wrong("other draws were expected: use the generator `random` that you are given.")
    _counted(got, np.array(intervals))


class _Watched:
    """A rule that remembers what it was asked; its intervals reach farther up than down."""

    def __init__(self) -> None:
        self.pairs: list[tuple[np.ndarray, np.ndarray]] = []
        self.intervals: list[Interval] = []

    def __call__(self, one: np.ndarray, other: np.ndarray) -> Interval:
        sides = np.array(one, dtype=float), np.array(other, dtype=float)
        self.pairs.append(sides)
        gap = float(sides[0].mean() - sides[1].mean())
        self.intervals.append(Interval(gap, gap - 0.4, gap + 0.9))
        return self.intervals[-1]


def _counted(got: float, intervals: np.ndarray) -> None:
    """Compare the student's share with that of intervals (pair, 3) above zero, and name the mistake."""
    estimates, lows, highs = intervals.T
    ahead, behind = (lows > 0).mean(), (highs < 0).mean()
    if np.isclose(got, ahead):
        return
    if np.isclose(got, ahead * len(lows)):
        raise Wrong("that is the number of pairs: divide by how many there are.")
    if np.isclose(got, ahead + behind):
        raise Wrong('you count "behind" too: ask for false "ahead" alone, low above zero.')
    if np.isclose(got, behind):
        raise Wrong('that is the share of "behind": "ahead" is where low lies above zero.')
    if np.isclose(got, (estimates > 0).mean()):
        raise Wrong("you count every positive estimate: the whole interval must lie above zero.")
    if np.isclose(got, 1 - ahead):
        raise Wrong('that is the share of pairs that are not called "ahead".')
    raise Wrong("the numbers differ. Count the pairs with rule(one, other).low > 0, then divide.")


@answered
def late_rise(student: Student) -> None:
    """Check f(returns, floor): last fifth less the fifth before, as a share of the last's level."""
    random = np.random.default_rng(72)
    for length, start in ((60, 20.0), (47, 0.3), (30, 5.0), (12, 40.0), (103, 0.0)):
        floor, window = float(random.uniform(2.0, 6.0)), length // 5
        returns = start + np.cumsum(random.normal(0.3 if start else 0.002, 0.1, length))
        got = as_number(ask(student, returns, floor).answer, "a single number")
        last, before = returns[-window:].mean(), returns[-2 * window : -window].mean()
        level = max(last, floor)
        mistakes = {
            "the sign is turned: a curve that rises must give a positive number.": (
                (before - last) / level
            ),
            "that is the rise in units of return: divide it by the level at the end.": (
                last - before
            ),
            "a level near zero makes any rise look huge: divide by at least `floor`.": (
                (last - before) / last
            ),
            "divide by the level at the end, the mean of the last fifth.": (
                (last - before) / max(before, floor)
            ),
            "that is the rise over the whole run: compare with the fifth just before.": (
                (last - returns[:window].mean()) / level
            ),
            "you compare with everything before: take only one fifth before the last.": (
                (last - returns[:-window].mean()) / level
            ),
        }
        hint = "the numbers differ. (last fifth - fifth before) / max(last fifth, floor)."
        _named(got, (last - before) / level, mistakes, hint)

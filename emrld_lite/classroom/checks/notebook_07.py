"""Checks of notebook 07: how often a rule errs, and how many seeds it needs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...experiments.intervals import Interval
from ..few_seeds import FEWEST, MOST
from .answers import Student, Wrong, answered
from .values import as_number


class Watched:
    """A rule that remembers what it was asked, in pairs of arrays (run,), and what it answered."""

    def __init__(self, below: Callable[[int], float], above: Callable[[int], float]) -> None:
        """Make a rule; an interval reaches ``below(runs)`` and ``above(runs)`` from the difference."""
        self.pairs: list[tuple[np.ndarray, np.ndarray]] = []
        self.intervals: list[Interval] = []
        self._below, self._above = below, above

    def __call__(self, one: Any, other: Any) -> Interval:
        sides = _scores(one), _scores(other)
        self.pairs.append(sides)
        gap = float(sides[0].mean() - sides[1].mean())
        low, high = gap - self._below(len(sides[0])), gap + self._above(len(sides[0]))
        self.intervals.append(Interval(gap, low, high))
        return self.intervals[-1]


def _scores(side: Any) -> np.ndarray:
    scores = np.array(side, dtype=float)
    if scores.ndim != 1 or not scores.size:
        raise Wrong(
            "hand the rule one array of shape (runs,) for each side, got one of shape "
            f"{scores.shape}."
        )
    return scores


@answered
def false_ahead_rate(student: Student) -> None:
    """Check f(rule, runs, pairs, random) -> share of null pairs whose interval lies above zero."""
    for runs, pairs, seed in ((4, 300, 73), (7, 210, 75)):
        lopsided = Watched(lambda _: 0.4, lambda _: 0.9)
        got = as_number(
            student(lopsided, runs, pairs, np.random.default_rng(seed)), "a single number"
        )
        _judge_null_pairs(lopsided.pairs, runs, pairs)
        _counted(got, np.array(lopsided.intervals))
        again = Watched(lambda _: 0.4, lambda _: 0.9)
        student(again, runs, pairs, np.random.default_rng(seed + 1))
        if again.pairs and np.array_equal(again.pairs[0][0], lopsided.pairs[0][0]):
            raise Wrong("other draws were expected: use the generator `random` that you are given.")


def _judge_null_pairs(asked: list[tuple[np.ndarray, np.ndarray]], runs: int, pairs: int) -> None:
    """Raise Wrong unless the rule was asked about fresh null pairs, as many as were wanted."""
    if len(asked) != pairs:
        raise Wrong(
            f"the rule was asked {len(asked)} times for {pairs} pairs: ask it once per pair."
        )
    if any(side.shape != (runs,) for pair in asked for side in pair):
        raise Wrong("each side of a pair needs `runs` scores, in one array of shape (runs,).")
    one, other = (np.array(side) for side in zip(*asked, strict=True))
    if np.array_equal(one, other):
        raise Wrong("both sides are the same scores: draw each side anew.")
    if len(np.unique(one[:, 0])) < pairs or len(np.unique(other[:, 0])) < pairs:
        raise Wrong("scores come back from pair to pair: draw both sides anew for each pair.")
    scale = np.hypot(one.std(), other.std())
    if abs(one.mean() - other.mean()) > 4 * scale / np.sqrt(one.size):
        raise Wrong(
            "one side is better on average: in a null pair both have the same distribution."
        )
    if not 0.7 < one.std() / other.std() < 1.4:
        raise Wrong("one side spreads more: in a null pair both have the same distribution.")


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
    raise Wrong("the share is off: in which pairs does the whole interval lie above zero?")


# gap, spread, chance, and how far the rule's interval reaches down with so many runs
EXPERIMENTS = (
    (2.0, 1.0, 0.8, lambda runs: 4.0 / runs**0.5),
    (6.0, 4.0, 0.5, lambda runs: 40.0 / runs),
    (0.3, 0.05, 0.9, lambda runs: 1.0 / runs),
)
HOPELESS = (1.0, 1.0, 0.9, lambda _: 50.0)


@answered
def seeds_needed(student: Student) -> None:
    """Check f(rule, gap, spread, chance, random) -> seeds of each side that show the gap often enough."""
    for number, (gap, spread, chance, below) in enumerate(EXPERIMENTS, start=77):
        rule = Watched(below, lambda _: 0.3)
        answer = student(rule, gap, spread, chance, np.random.default_rng(number))
        if not rule.pairs:
            raise Wrong("you never ask the rule: what it says of simulated pairs decides.")
        if min(count for _, count in _shares(rule).values()) < 200:
            raise Wrong(
                "simulate at least 200 pairs for each number of seeds: fewer say too little."
            )
        _judge_pairs(rule.pairs, gap, spread)
        if answer is None:
            raise Wrong("you return None, although a number of seeds up to 20 is enough.")
        got = as_number(answer, "a number of seeds")
        _judge_number(got, _shares(rule), chance, rule)
        again = Watched(below, lambda _: 0.3)
        student(again, gap, spread, chance, np.random.default_rng(number + 9))
        if np.array_equal(again.pairs[0][1], rule.pairs[0][1]):
            raise Wrong("other draws were expected: use the generator `random` that you are given.")
    gap, spread, chance, below = HOPELESS
    rule = Watched(below, lambda _: 0.3)
    if student(rule, gap, spread, chance, np.random.default_rng(90)) is not None:
        raise Wrong("where not even 20 seeds are enough, return None.")
    if max(_shares(rule)) != MOST:
        raise Wrong("try up to 20 seeds of each side, 20 as well, before you give up.")


def _judge_pairs(asked: list[tuple[np.ndarray, np.ndarray]], gap: float, spread: float) -> None:
    """Raise Wrong unless the simulated pairs are what was asked for."""
    if any(len(one) != len(other) for one, other in asked):
        raise Wrong("both sides need the same number of seeds.")
    one, other = (np.concatenate(side) for side in zip(*asked, strict=True))
    with np.errstate(all="ignore"):  # a side without any spread is told below
        correlation = np.corrcoef(one, other)[0, 1]
    if np.isclose(correlation, 1.0):
        raise Wrong("the second side is the first one, shifted: draw each side anew.")
    error = 4 * spread * np.sqrt(2 / len(one))
    found = one.mean() - other.mean()
    if abs(found + gap) < error:
        raise Wrong("the second side is better: the first one is to be ahead by `gap`.")
    if abs(found - gap) > error:
        raise Wrong(f"the first side should be better by {gap:g} on average, yours by {found:.3g}.")
    for side in (one, other):
        if abs(side.std() / spread - 1) > 0.1:
            raise Wrong(
                f"over seeds the scores should have a standard deviation of {spread:g}, on either "
                f"side; yours have {side.std():.3g}."
            )


def _shares(rule: Watched) -> dict[int, tuple[float, int]]:
    """Return the share of pairs called ahead and the number of pairs, by the number of runs."""
    found: dict[int, list[bool]] = {}
    for (one, _), interval in zip(rule.pairs, rule.intervals, strict=True):
        found.setdefault(len(one), []).append(interval.low > 0)
    return {runs: (float(np.mean(ahead)), len(ahead)) for runs, ahead in found.items()}


def _judge_number(
    got: float, shares: dict[int, tuple[float, int]], chance: float, rule: Watched
) -> None:
    """Compare the number of seeds with what the student's own simulation says."""
    if min(shares) < FEWEST:
        raise Wrong("begin with three seeds of each side: fewer cannot be judged by ranks.")
    if got not in range(FEWEST, MOST + 1):
        raise Wrong(f"return a number of seeds from 3 to 20, yours is {got:g}.")
    tried = sorted(runs for runs in shares if runs < got)
    if early := [runs for runs in tried if shares[runs][0] >= chance]:
        raise Wrong(
            f"{early[0]} seeds are enough already: there the rule says ahead in "
            f"{shares[early[0]][0]:.0%}, and {chance:.0%} are asked for."
        )
    numbers = range(FEWEST, int(got) + 1)
    if missing := [runs for runs in numbers if runs not in shares]:
        raise Wrong(f"you never try {missing[0]} seeds: a smaller number might be enough.")
    if shares[int(got)][0] < chance:
        told = f"with {int(got)} seeds the rule says ahead in {shares[int(got)][0]:.0%} only"
        estimates = [i.estimate > 0 for i in rule.intervals]
        if np.mean(estimates) >= chance:
            told += ", since ahead means that the whole interval lies above zero"
        raise Wrong(f"{told}; {chance:.0%} are asked for.")

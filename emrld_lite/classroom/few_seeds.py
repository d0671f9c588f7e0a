"""What few seeds can tell: rules for a verdict, and how often they are right on made-up seeds.

A rule takes the scores of two sides, (run,) each, and returns an interval of their difference. Until a
reader's own function is right, the one below of its name stands for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..experiments.intervals import Interval, shift_interval

Scores = np.ndarray
Rule = Callable[[Scores, Scores], Interval]
ERROR = 0.05  # how often a rule may call one of two equal sides ahead
FEWEST, MOST = 3, 20  # seeds of each side that are looked at
PAIRS = 400  # simulated for each number of seeds


def rank_interval(one: Scores, other: Scores, error: float) -> tuple[float, float, float]:
    """Return estimate, low and high of the difference; either verdict is false with at most ``error``."""
    return tuple(shift_interval(one, other, level=1 - 2 * error))


def as_rule(interval: Callable[[Scores, Scores, float], Any]) -> Rule:
    """Return a function like ``rank_interval`` as a rule with an error of 5 %."""

    def rule(one: Scores, other: Scores) -> Interval:
        return Interval(*(float(number) for number in interval(one, other, ERROR)))

    return rule


def false_ahead_rate(rule: Rule, runs: int, pairs: int, random: np.random.Generator) -> float:
    """Return the share of null pairs of ``runs`` scores each that the rule calls ahead."""
    draws = random.normal(size=(pairs, 2, runs))
    return float(np.mean([rule(*pair).low > 0 for pair in draws]))


def seeds_needed(
    rule: Rule, gap: float, spread: float, chance: float, random: np.random.Generator
) -> int | None:
    """Return how many seeds of each side a gap needs to be called ahead with probability ``chance``.

    ``spread`` is the standard deviation over seeds; None where 20 seeds are not enough.
    """
    for number in range(FEWEST, MOST + 1):
        draws = spread * random.normal(size=(PAIRS, 2, number))
        ahead = [rule(one + gap, other).low > 0 for one, other in draws]
        if np.mean(ahead) >= chance:
            return number
    return None


def hidden_by_mean(table: np.ndarray) -> float:
    """Return how far the tasks of a table (seed, task) lie apart, their means over seeds."""
    return float(np.asarray(table).mean(0).std())

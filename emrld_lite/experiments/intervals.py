"""Intervals: of a rate (Wilson), and of the interquartile mean over runs (stratified bootstrap)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..validation import InputError, positive_count, real_number

RESAMPLES = 2000
AHEAD, BEHIND, EVEN = "ahead", "behind", "not distinguishable at this budget"


class Interval(NamedTuple):
    """An estimate with the lowest and the highest value that the data leave plausible."""

    estimate: float
    low: float
    high: float

    def __format__(self, spec: str) -> str:
        """Return the estimate with its interval, each number in the format ``spec``."""
        return f"{self.estimate:{spec}} [{self.low:{spec}}, {self.high:{spec}}]"


def interquartile_mean(scores: np.ndarray) -> float:
    """Return the mean of the middle half of ``scores``, of any shape.

    Of n scores the lowest and the highest n // 4 are left out: one lucky or lost run moves it less
    than the mean, and it still uses more data than the median. Agarwal et al. (2021). Raises
    InputError where there is no score, or one that is not finite.
    """
    ordered = np.sort(np.asarray(scores, dtype=float), axis=None)
    if not ordered.size or not np.isfinite(ordered).all():
        raise InputError(f"scores: expected finite numbers, at least one, got {scores!r}")
    cut = ordered.size // 4
    return float(ordered[cut : ordered.size - cut].mean())


def bootstrap_interval(
    strata: Sequence[np.ndarray],
    others: Sequence[np.ndarray] | None = None,
    statistic: Callable[[np.ndarray], float] = interquartile_mean,
    resamples: int = RESAMPLES,
    level: float = 0.95,
    seed: int = 0,
) -> Interval:
    """Return ``statistic`` over all strata with its stratified bootstrap interval.

    A stratum is one experiment: a score per run, (seed,), or several, (seed, task). Runs are drawn
    again with replacement within each stratum, whole: the tasks of one run share its policy, so
    they are no independent draws. With ``others``, a second list of strata, it is the difference
    of the two statistics, both resampled. Three runs have only ten different resamples, so at 95 %
    the interval of a single stratum reaches from its worst run to its best. Unlike Agarwal et al.
    (2021), who draw the runs of each task by themselves, since there each task has its own runs.
    Raises InputError for strata that are not such tables, or hold a single run, of whose spread
    nothing is known.
    """
    positive_count("resamples", resamples)
    real_number("level", level, 0.0, 1.0)
    random = np.random.default_rng(positive_count("seed", seed, minimum=0))
    sides = [_checked(side) for side in (strata, others) if side is not None]
    signs = (1.0, -1.0)

    def value(tables: Sequence[Sequence[np.ndarray]]) -> float:
        joined = [np.concatenate([table.ravel() for table in side]) for side in tables]
        return sum(sign * statistic(scores) for sign, scores in zip(signs, joined, strict=False))

    draws = [
        value([[random.choice(table, len(table)) for table in side] for side in sides])
        for _ in range(resamples)
    ]
    low, high = np.quantile(draws, [(1 - level) / 2, (1 + level) / 2])
    return Interval(value(sides), float(low), float(high))


def _checked(strata: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return the strata as arrays; raises InputError unless each has runs, (seed,) or (seed, task)."""
    tables = [np.asarray(table, dtype=float) for table in strata]
    if not tables:
        raise InputError("strata: expected at least one table of scores, got none")
    for number, table in enumerate(tables):
        if table.ndim not in (1, 2) or len(table) < 2 or not table.size:
            raise InputError(
                f"strata: table {number}: expected scores (seed,) or (seed, task) of two runs or "
                f"more, got shape {table.shape}"
            )
    return tables


def verdict(difference: Interval) -> str:
    """Return in words what the interval of a difference says: ahead, behind, or neither."""
    if difference.low > 0:
        return AHEAD
    return BEHIND if difference.high < 0 else EVEN


def wilson_interval(successes: int, episodes: int, z: float = 1.96) -> tuple[float, float]:
    """Return an interval for a rate that was seen ``successes`` times in ``episodes`` (z = 1.96: 95 %).

    Unlike mean plus or minus two standard errors it stays sensible at 0 and 1. Wilson (1927). Raises
    InputError for counts that make no rate.
    """
    positive_count("episodes", episodes)
    positive_count("successes", successes, minimum=0)
    if successes > episodes:
        raise InputError(f"successes: expected at most {episodes}, the episodes, got {successes}")
    rate, spread = successes / episodes, z * z / episodes
    centre = (rate + spread / 2) / (1 + spread)
    half = math.sqrt(rate * (1 - rate) * spread + spread * spread / 4) / (1 + spread)
    return max(0.0, centre - half), min(1.0, centre + half)

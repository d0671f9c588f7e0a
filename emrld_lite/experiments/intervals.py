"""Intervals with a stated error: of a difference (rank sums), of few runs (worst to best), of a rate."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..validation import InputError, positive_count, real_number

LEVEL = 0.9  # of a difference's interval: false "ahead" at most 5 % of the time, "behind" likewise
AHEAD, BEHIND, EVEN = "ahead", "behind", "not distinguishable"


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
    ordered = np.sort(_finite(scores).ravel())
    cut = ordered.size // 4
    return float(ordered[cut : ordered.size - cut].mean())


def worst_to_best(scores: Sequence[float]) -> Interval:
    """Return the mean of the runs' scores, (run,), with the lowest and the highest as its ends.

    From the worst to the best of n runs covers the median of all runs with the probability that
    ``median_coverage`` returns. Raises InputError for fewer than two scores, of whose spread nothing
    is known, and for one that is not finite.
    """
    table = _runs("scores", scores, least=2)
    return Interval(float(table.mean()), float(table.min()), float(table.max()))


def median_coverage(runs: int) -> float:
    """Return how often the worst to the best of ``runs`` runs covers their median: 1 - 2^(1 - runs).

    It does not unless all runs fall on one side of the median, each with probability one half.
    """
    return 1.0 - 2.0 ** (1 - positive_count("runs", runs))


def shift_interval(one: Sequence[float], other: Sequence[float], level: float = LEVEL) -> Interval:
    """Return by how much ``one`` exceeds ``other``, (run,) each: Hodges and Lehmann's estimate.

    That is the median of all differences between a run of ``one`` and a run of ``other``. Its
    interval reaches from the k-th smallest difference to the k-th largest, with k from the exact
    distribution of Mann and Whitney's rank sum (``rank_of_ends``): three against three at 0.9 from
    the smallest to the largest, five against five from the 5th smallest to the 5th largest. If both
    come from one distribution, whatever its shape, the interval lies above zero with a probability of
    at most (1 - level) / 2, and below zero likewise. Raises InputError where so few runs cannot
    reach the level.
    """
    left, right = (_runs(*side) for side in (("one", one), ("other", other)))
    differences = np.sort(np.subtract.outer(left, right), axis=None)
    k = rank_of_ends(len(left), len(right), level)
    return Interval(
        float(np.median(differences)), float(differences[k - 1]), float(differences[-k])
    )


def rank_of_ends(one: int, other: int, level: float = LEVEL) -> int:
    """Return which of the sorted differences, from either end, ends an interval of ``level``.

    The largest k for which fewer than k of all one * other differences are negative in at most a
    share (1 - level) / 2 of all ways to deal the runs' ranks. Raises InputError where no k is.
    """
    real_number("level", level, 0.0, 1.0)
    shares = _shares_by_wins(*(positive_count(*side) for side in (("one", one), ("other", other))))
    k = int((shares <= (1 - level) / 2 + 1e-12).sum())
    if not k:
        raise InputError(
            f"runs: {one} against {other} reach a level of {1 - 2 * shares[0]:.3g} at most, "
            f"expected {level:g}: use more runs, or a lower level"
        )
    return k


@functools.cache
def _shares_by_wins(one: int, other: int) -> np.ndarray:
    """Return the share of all splits in which the first side wins at most 0, 1, ... of all pairs."""
    return np.cumsum(splits_by_wins(one, other)) / math.comb(one + other, one)


def splits_by_wins(one: int, other: int) -> list[int]:
    """Return in how many splits of one + other ranks the first side wins 0, 1, ... of all pairs.

    One rank after the other, from the lowest: one more on the first side wins against all that the
    second side has so far. Mann and Whitney (1947).
    """
    sides = positive_count("one", one), positive_count("other", other)
    splits = {(0, 0): {0: 1}}  # runs dealt to each side -> wins -> number of ways
    for mine, theirs in itertools.product(*(range(side + 1) for side in sides)):
        ways = splits.setdefault((mine, theirs), {})
        for before, gained in (((mine - 1, theirs), theirs), ((mine, theirs - 1), 0)):
            for wins, number in splits.get(before, {}).items():
                ways[wins + gained] = ways.get(wins + gained, 0) + number
    return [splits[sides].get(wins, 0) for wins in range(one * other + 1)]


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


def _runs(what: str, scores: Sequence[float], least: int = 1) -> np.ndarray:
    """Return scores (run,) as an array; raises InputError for another shape or too few runs."""
    table = np.asarray(scores, dtype=float)
    if table.ndim != 1 or len(table) < least:
        raise InputError(
            f"{what}: expected a score per run, (run,), of {least} or more, got shape {table.shape}"
        )
    return _finite(table)


def _finite(scores: np.ndarray) -> np.ndarray:
    """Return the scores as an array; raises InputError unless there are some, all finite."""
    table = np.asarray(scores, dtype=float)
    if not table.size or not np.isfinite(table).all():
        raise InputError(f"scores: expected finite numbers, at least one, got {scores!r}")
    return table

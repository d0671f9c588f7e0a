"""Intervals against their definitions: by hand, by enumeration, by how often they cover the truth."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from emrld_lite.experiments.intervals import (
    Interval,
    bootstrap_interval,
    interquartile_mean,
    verdict,
    wilson_interval,
)
from emrld_lite.validation import InputError


@pytest.mark.parametrize(("successes", "episodes"), [(0, 50), (1, 240), (17, 40), (40, 40)])
def test_wilson_s_bounds_solve_his_equation(successes, episodes):
    # a bound p is where the seen rate lies z standard deviations of p away from p
    rate = successes / episodes
    for bound in wilson_interval(successes, episodes):
        if 0 < bound < 1:
            deviation = math.sqrt(bound * (1 - bound) / episodes)
            assert abs(rate - bound) == pytest.approx(1.96 * deviation)
    low, high = wilson_interval(successes, episodes)
    assert 0 <= low <= rate <= high <= 1
    assert high > low


@pytest.mark.parametrize(("successes", "episodes"), [(3, 2), (-1, 5), (0, 0), (0.5, 3)])
def test_counts_that_make_no_rate_are_refused(successes, episodes):
    with pytest.raises(InputError):
        wilson_interval(successes, episodes)


def test_the_middle_half_by_hand():
    assert interquartile_mean(np.array([8, 1, 7, 2, 6, 3, 5, 4])) == 4.5  # of 3, 4, 5, 6
    assert interquartile_mean(np.array([[1.0, 2.0], [3.0, 1000.0]])) == 2.5  # of 2, 3
    assert interquartile_mean(np.array([1.0, 2.0, 6.0])) == 3.0  # too few to leave one out


@given(arrays(float, st.integers(1, 40), elements=st.floats(-1e3, 1e3)))
def test_the_middle_half_by_a_plain_loop(scores):
    ordered, n = sorted(scores), len(scores)
    middle = [score for place, score in enumerate(ordered) if n // 4 <= place < n - n // 4]
    assert interquartile_mean(scores) == pytest.approx(sum(middle) / len(middle), abs=1e-9)


def test_one_lost_task_does_not_move_the_middle_half():
    scores = np.linspace(60, 80, 20)
    lost = scores.copy()
    lost[0] = -1e6
    assert interquartile_mean(lost) == interquartile_mean(scores)


def test_the_bootstrap_finds_the_quantiles_of_every_possible_resample():
    scores = np.random.default_rng(0).normal(50, 10, (4, 6))  # (seed, task)
    everything = [
        interquartile_mean(scores[list(rows)]) for rows in itertools.product(range(4), repeat=4)
    ]
    found = bootstrap_interval([scores], resamples=20_000)
    spread = max(everything) - min(everything)
    assert found.estimate == interquartile_mean(scores)
    assert found.low == pytest.approx(np.quantile(everything, 0.025), abs=0.02 * spread)
    assert found.high == pytest.approx(np.quantile(everything, 0.975), abs=0.02 * spread)


def test_of_three_runs_the_interval_reaches_from_the_worst_to_the_best():
    scores = np.random.default_rng(1).normal(50, 10, (3, 20))
    each = [interquartile_mean(run) for run in scores]
    found = bootstrap_interval([scores])
    assert (found.low, found.high) == pytest.approx((min(each), max(each)))


def test_strata_are_resampled_apart():
    # two experiments with identical runs inside: nothing varies, however different they are
    strata = [np.full((3, 8), 10.0), np.full((3, 8), 90.0)]
    assert bootstrap_interval(strata) == Interval(50.0, 50.0, 50.0)


def test_a_run_stays_whole():
    """Goals differ widely, runs hardly: an interval over goals would be wide, that over runs is not."""
    scores = np.tile(np.linspace(0, 100, 20), (5, 1)) + np.arange(5)[:, None]
    found = bootstrap_interval([scores])
    assert found.high - found.low <= 4


def test_the_interval_covers_the_truth_about_as_often_as_it_says():
    random = np.random.default_rng(2)
    covered = 0
    for trial in range(150):
        scores = 50 + random.normal(0, 5, (12, 1)) + random.normal(0, 1, (12, 4))
        found = bootstrap_interval([scores], resamples=200, level=0.9, seed=trial)
        covered += found.low <= 50 <= found.high
    assert 0.75 < covered / 150 < 0.98


def test_a_difference_turned_round_changes_its_sign():
    one, other = np.random.default_rng(3).normal(size=(2, 3, 5))
    there = bootstrap_interval([one], [other])
    back = bootstrap_interval([other], [one])
    assert there.estimate == pytest.approx(-back.estimate)
    assert there.estimate == pytest.approx(interquartile_mean(one) - interquartile_mean(other))


def test_verdicts():
    assert verdict(Interval(2, 1, 3)) == "ahead"
    assert verdict(Interval(-2, -3, -1)) == "behind"
    assert verdict(Interval(1, -1, 3)) == "not distinguishable at this budget"
    assert f"{Interval(2, 1, 3):.1f}" == "2.0 [1.0, 3.0]"


@pytest.mark.parametrize(
    ("strata", "message"),
    [
        ([], "got none"),
        ([np.zeros((2, 3, 4))], r"table 0: .* got shape \(2, 3, 4\)"),
        ([np.zeros((2, 3)), np.zeros((0, 3))], "table 1"),
        ([np.zeros(3), np.zeros(1)], "table 1: .* two runs or more"),
        ([np.full((2, 2), math.nan)], "finite"),
    ],
)
def test_tables_that_hold_no_scores_are_refused(strata, message):
    with pytest.raises(InputError, match=message):
        bootstrap_interval(strata)

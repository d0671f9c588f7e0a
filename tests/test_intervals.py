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
    interquartile_mean,
    median_coverage,
    rank_of_ends,
    shift_interval,
    splits_by_wins,
    verdict,
    wilson_interval,
    worst_to_best,
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


def wins(mine, theirs):
    """Return how many pairs the first side wins, one pair after the other."""
    return sum(one > other for one, other in itertools.product(mine, theirs))


def splits(one, other):
    """Yield every way to deal the ranks 0, 1, ... to two sides."""
    ranks = set(range(one + other))
    for mine in itertools.combinations(sorted(ranks), one):
        yield mine, sorted(ranks - set(mine))


@pytest.mark.parametrize(("one", "other"), [*itertools.product((1, 2, 3, 5), repeat=2)])
def test_wins_are_counted_as_by_going_through_every_split(one, other):
    everything = [wins(*split) for split in splits(one, other)]
    expected = [everything.count(number) for number in range(one * other + 1)]
    assert splits_by_wins(one, other) == expected


@pytest.mark.parametrize("level", [0.8, 0.9, 0.95])
@pytest.mark.parametrize(("one", "other"), [(3, 3), (3, 5), (4, 4), (5, 3), (5, 5)])
def test_a_verdict_is_false_at_most_as_often_as_stated_and_no_rule_of_ranks_is_wider(
    one, other, level
):
    """All splits are equally likely where both sides are the same: enumerate them."""
    if math.comb(one + other, one) * (1 - level) / 2 < 1 - 1e-9:
        with pytest.raises(InputError, match=f"{one} against {other} reach a level of 0.9 at most"):
            rank_of_ends(one, other, level)
        return
    found = [verdict(shift_interval(*split, level)) for split in splits(one, other)]
    allowed = len(found) * (1 - level) / 2
    assert found.count("ahead") <= allowed + 1e-9
    assert found.count("ahead") == found.count("behind")
    k = rank_of_ends(one, other, level)
    assert sum(splits_by_wins(one, other)[: k + 1]) > allowed  # one pair more would be too many


def test_three_against_three_and_five_against_five_by_hand():
    three = shift_interval([7.0, 9.0, 20.0], [1.0, 2.0, 6.0])
    assert three == Interval(7.0, 1.0, 19.0)  # of 1 3 5 6 7 8 14 18 19
    assert (rank_of_ends(3, 3), rank_of_ends(5, 5)) == (1, 5)
    one, other = np.random.default_rng(0).normal(size=(2, 5))
    ordered = sorted(a - b for a, b in itertools.product(one, other))
    assert shift_interval(one, other) == Interval(ordered[12], ordered[4], ordered[20])


@pytest.mark.parametrize("draw", ["normal", "exponential", "standard_cauchy"])
@pytest.mark.parametrize("runs", [3, 5])
def test_the_shift_is_covered_and_a_null_pair_called_false_as_often_as_stated(draw, runs):
    random = np.random.default_rng(1)
    found = [shift_interval(*getattr(random, draw)(size=(2, runs))) for _ in range(3000)]
    stated = {3: 1 / 20, 5: 12 / 252}[runs]
    for word in ("ahead", "behind"):
        share = sum(verdict(interval) == word for interval in found) / 3000
        assert share == pytest.approx(stated, abs=4 * math.sqrt(stated / 3000))


def test_a_difference_turned_round_changes_its_sign_and_a_shift_moves_it():
    one, other = np.random.default_rng(3).normal(size=(2, 5))
    there, back = shift_interval(one, other), shift_interval(other, one)
    assert there == pytest.approx((-back.estimate, -back.high, -back.low))
    moved = shift_interval(one + 10, other)
    assert moved == pytest.approx(tuple(value + 10 for value in there))


def test_equal_scores_are_never_told_apart():
    assert shift_interval([1.0] * 5, [1.0] * 5) == Interval(0.0, 0.0, 0.0)
    assert verdict(shift_interval([1.0] * 5, [1.0] * 5)) == "not distinguishable"


@pytest.mark.parametrize("runs", [2, 3, 5])
def test_from_worst_to_best_covers_the_median_as_often_as_it_says(runs):
    random = np.random.default_rng(2)
    found = [worst_to_best(random.exponential(size=runs)) for _ in range(4000)]
    covered = sum(interval.low <= math.log(2) <= interval.high for interval in found) / 4000
    assert covered == pytest.approx(median_coverage(runs), abs=0.03)
    assert [median_coverage(n) for n in (1, 3, 5)] == [0.0, 0.75, 0.9375]


def test_the_worst_and_the_best_stand_around_the_mean():
    assert worst_to_best([4.0, 1.0, 4.0]) == Interval(3.0, 1.0, 4.0)


def test_verdicts():
    assert verdict(Interval(2, 1, 3)) == "ahead"
    assert verdict(Interval(-2, -3, -1)) == "behind"
    assert verdict(Interval(1, -1, 3)) == "not distinguishable"
    assert f"{Interval(2, 1, 3):.1f}" == "2.0 [1.0, 3.0]"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: shift_interval([], [1.0, 2.0]), r"one: .* got shape \(0,\)"),
        (lambda: shift_interval([1.0, 2.0], np.zeros((2, 3))), r"other: .* got shape \(2, 3\)"),
        (lambda: shift_interval([1.0, 2.0], [1.0, 2.0]), "2 against 2 reach a level of 0.667"),
        (lambda: shift_interval([1.0, math.nan, 2.0], [1.0, 2.0, 3.0]), "finite"),
        (lambda: shift_interval([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 1.5), "level"),
        (lambda: worst_to_best([1.0]), "of 2 or more"),
        (lambda: worst_to_best([1.0, math.inf]), "finite"),
        (lambda: interquartile_mean(np.array([math.nan])), "finite"),
        (lambda: splits_by_wins(0, 3), "one"),
        (lambda: median_coverage(0), "runs"),
    ],
)
def test_scores_of_which_nothing_can_be_said_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()

"""Notebook 04's pictures over the whole range of their controls, against plain loops and formulas by hand."""

import itertools

import ipywidgets
import matplotlib.pyplot as plt
import numpy as np
import pytest
import torch

from emrld_lite.classroom.proof_drops import DROPS, MOVES, drops
from emrld_lite.classroom.sketches.goal_corridor import corridor
from emrld_lite.classroom.widgets import bounds, swamp
from emrld_lite.tabular import corridor_step, many_families, proof_lines, theorem_1
from emrld_lite.tabular.proof import RULES
from emrld_lite.validation import InputError

FRACTIONS = (0.0, 0.1, 0.5, 0.9, 1.0)


def controls_of(sliders, monkeypatch):
    """Return the controls that a function shows, by the name of the argument they move."""
    shown = {}
    monkeypatch.setattr(ipywidgets, "interact", lambda _, **controls: shown.update(controls))
    sliders()
    return shown


def whole_range(control):
    """Return a slider's ends and places between them, or all of a menu's options."""
    if hasattr(control, "options"):
        return list(control.options)
    return [control.min + share * (control.max - control.min) for share in FRACTIONS]


def every_setting(sliders, monkeypatch, places=slice(None)):
    """Return every combination of the places of all controls, as keyword arguments."""
    controls = controls_of(sliders, monkeypatch)
    ranges = [whole_range(control)[places] for control in controls.values()]
    return [dict(zip(controls, values, strict=True)) for values in itertools.product(*ranges)]


def bars(axes):
    """Return the signed length of every horizontal bar, from the top."""
    found = [bar for container in axes.containers for bar in container]
    return [bar.get_width() for bar in sorted(found, key=lambda bar: bar.get_y())]


def followed(policy, goal, discount):
    """Return the value of every corridor cell and the visits of it, by following the walk."""
    chain, pay = np.zeros((5, 5)), np.zeros(5)
    for cell, action in itertools.product(range(5), range(2)):
        landing = min(max(cell + (-1, 1)[action], 0), 4)
        chain[cell, 2 if landing == goal else landing] += policy[cell, action]
        pay[cell] += policy[cell, action] * (landing == goal)
    value, visits, now = np.zeros(5), np.zeros(5), np.eye(5)[2]
    steps = 1 if discount == 0 else int(np.log(1e-12) / np.log(discount)) + 1
    for time in range(steps):
        value = pay + discount * chain @ value
        visits += (1 - discount) * discount**time * now
        now = now @ chain
    return value, visits


def by_loops(quality, share, discount, stubbornness):
    """Return improvement and printed bound per step, Delta and its average, all by hand."""
    coin, gains, c1, delta, average, tv_old, tv_new, first = np.full((5, 2), 0.5), *[0.0] * 7
    delta = np.inf
    for goal, right in ((0, 0), (4, 1)):
        demo = np.full((5, 2), (1 - quality) / 2)
        demo[:, right] = (1 + quality) / 2
        if goal == 0 and stubbornness:
            demo[1] = [1 - stubbornness, stubbornness]
        new = (1 - share) * coin + share * demo
        value, d_old = followed(coin, goal, discount)
        after, d_new = followed(new, goal, discount)
        advantage = np.zeros((5, 2))
        for cell, action in itertools.product(range(5), range(2)):
            landing = min(max(cell + (-1, 1)[action], 0), 4)
            following = value[2 if landing == goal else landing]
            advantage[cell, action] = (landing == goal) + discount * following - value[cell]
        gains += 0.5 * (1 - discount) * (after[2] - value[2])
        c1 = max(c1, np.abs(advantage).max())
        of_demo = (demo * advantage).sum(1)
        delta, average = min(delta, of_demo.min()), average + 0.5 * d_new @ of_demo
        first += 0.5 * d_old @ (new * advantage).sum(1)
        tv_old += 0.25 * d_old @ np.abs(new - coin).sum(1)
        tv_new += 0.25 * d_new @ np.abs(new - demo).sum(1)
    return gains, first - 2 * c1 * tv_old + delta - 2 * c1 * tv_new, delta, average


def test_the_drops_add_up_to_what_the_bound_loses():
    assert [*MOVES] == [*RULES]
    for family in many_families(seed=3, total=500):
        theorem, scale = theorem_1(*family), 1 - family[0][0].discount
        lost = torch.stack([*drops(proof_lines(*family)).values()])
        assert (lost >= -1e-9 * theorem.c1).all()
        whole = scale * (theorem.improvement - theorem.bound)
        assert torch.allclose(lost.sum(0), whole, rtol=1e-6, atol=1e-9)


def test_the_waterfall_runs_from_the_truth_to_the_bound_everywhere(monkeypatch):
    for setting in every_setting(bounds.bound_sliders, monkeypatch, slice(0, 5, 2)):
        first, *falls, last = bars(bounds.bound_picture(**setting).axes[0])
        improvement, bound, _, _ = by_loops(**setting)
        assert len(falls) == len(DROPS)
        assert first == pytest.approx(improvement, abs=1e-9)
        assert last == pytest.approx(bound, abs=1e-9)
        assert first + sum(falls) == pytest.approx(last, abs=1e-9)


@pytest.mark.parametrize("stubbornness", FRACTIONS)
def test_one_stubborn_state_sets_delta_and_hardly_moves_the_average(stubbornness):
    title = bounds.bound_picture(stubbornness=stubbornness).axes[0].get_title()
    _, _, delta, average = by_loops(0.8, 0.5, 0.9, stubbornness)
    assert title == f"Delta = {delta:.3f} at the worst state, {average:.3f} on average"
    assert (delta < 0) == (stubbornness > 0.5)
    assert average > 0


def test_at_the_demonstrator_nothing_is_lost_for_it():
    for quality, discount in itertools.product((0.0, 0.5, 1.0), (0.0, 0.9, 0.99)):
        figure = bounds.bound_picture(quality, 1.0, discount, 0.0)
        assert bars(figure.axes[0])[1:3] == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_swamp_says_what_the_formulas_say(monkeypatch):
    for setting in every_setting(swamp.swamp_sliders, monkeypatch, slice(0, 5, 2)):
        gamma, slip, lead = setting.values()
        share = gamma * slip / (1 - gamma + gamma * slip)
        states, promises = swamp.swamp_picture(**setting).axes
        expected = [
            2 * lead - 3 * slip,
            (1 - share) * (2 * lead + slip) - share,
            2 * lead - slip - 2 * ((1 - share) * slip + share),
        ]
        assert bars(promises) == pytest.approx(expected, abs=1e-9)
        assert all(promises.get_xlim()[0] < value < promises.get_xlim()[1] for value in expected)
        assert any(f"{share:.0%} of the time" in text.get_text() for text in states.texts)
        plt.close("all")


def crosses(figure):
    """Return how many lines of the proof are drawn as failed."""
    return sum(line.get_marker() == "X" for line in figure.axes[0].lines)


def falls_from(claim):
    """Return the amount from which a claim about the corridor is false, by hand."""
    gains, _, delta, average = by_loops(0.8, 0.5, 0.9, 0.0)
    c1 = 0.5  # the step into the goal is worth 1, and the other way as much less
    if claim == "Delta is claimed too large":
        return (average - delta) / c1
    # with two actions, sum |new - demo| |A| is minus the sum without bars, which is average - gains
    two_tv = 2 * 0.2  # new moves right with 0.7, the demonstrator with 0.9, in every cell
    return 1 - (average - gains) / (c1 * two_tv)


@pytest.mark.parametrize("claim", ["Delta is claimed too large", "C1 is claimed too small"])
def test_a_claim_may_be_false_by_what_the_proof_gives_away(claim):
    limit = falls_from(claim)
    for amount in np.linspace(0, 1, 21):
        assert (crosses(bounds.assumption_picture(claim, amount)) > 0) == (amount > limit), amount
        plt.close("all")


def test_every_false_claim_fails_where_the_notebook_says(monkeypatch):
    first = {
        "Delta is claimed too large": "6  Assumption 1",
        "C1 is claimed too small": "7  Hölder",
        "the critic is wrong at the start": "2  Lemma 1",
        "distance is measured on the demonstrator's states": "7  Hölder, demonstrator",
    }
    for setting in every_setting(bounds.assumption_sliders, monkeypatch):
        figure = bounds.assumption_picture(**setting)
        title = figure.axes[0].get_title()
        if setting["claim"] == "nothing" or setting["amount"] == 0:
            assert title == "every move holds"
            assert crosses(figure) == 0
        elif setting["amount"] >= 0.5:
            assert title.startswith(f"first to fail: {first[setting['claim']]}")
        plt.close("all")


def test_a_claim_that_is_not_on_the_menu_is_refused():
    with pytest.raises(InputError, match="claim"):
        bounds.assumption_picture("gamma is claimed too large", 0.5)


@pytest.mark.parametrize("goal", [0, 4])
def test_the_corridor_shows_the_visits_that_it_is_given(goal):
    mdps, _, old, new, _ = corridor_step()
    visits = [mdps[goal // 4].visitation(policy[goal // 4]) for policy in (old, new)]
    _, axes = plt.subplots()
    corridor(axes, dict(zip(("old", "new"), visits, strict=True)), start=2, goal=goal)
    heights = [[bar.get_height() for bar in container] for container in axes.containers]
    assert np.allclose(heights, torch.stack(visits))
    for policy, shares in zip((old, new), visits, strict=True):
        walked = followed(policy[goal // 4].numpy(), goal, 0.9)[1]
        assert np.allclose(walked, shares)

"""Notebook 03: the cloning sliders over their whole range, and the designs' walks and copies."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
import torch

from emrld_lite.classroom import designs
from emrld_lite.classroom.sketches.corridor import corridor
from emrld_lite.classroom.widgets import cloning
from emrld_lite.demonstrators import recipes
from emrld_lite.envs import make
from emrld_lite.validation import InputError

EVERYTHING = [(noise, cut) for noise in cloning.NOISES for cut in cloning.CUTS]


@pytest.fixture(scope="module")
def copies():
    """Return the copies of the sliders, fitted once."""
    return cloning.copies_by_noise_and_cut()


def own_demonstration(noise):
    """Return the whole demonstration of the goal that the sliders show, made without the sliders."""
    goals = make("two_wheeled").training_tasks()[[4, 9, 14, 19]]
    expert = recipes.load_or_train_expert("two_wheeled", "optimal")
    recipe = recipes.Recipe(action_noise=noise, short_of_reward=0.1)
    data = recipes.demonstrate(expert, "two_wheeled", goals, "optimal", 0, recipe)
    return data.states[1, 0, : int(data.lengths()[1]), :2]


@pytest.mark.parametrize(("noise", "cut"), EVERYTHING)
def test_the_picture_shows_the_demonstration_without_its_first_steps(copies, noise, cut):
    figure = cloning.cloning_picture(copies, noise, cut)
    (drawn,) = [line for line in figure.axes[0].lines if line.get_linestyle() == "--"]
    np.testing.assert_allclose(drawn.get_xydata(), own_demonstration(noise)[cut:], atol=1e-5)


@pytest.mark.parametrize(("noise", "cut"), EVERYTHING)
def test_the_framed_number_is_the_mean_over_goals_and_episodes(copies, noise, cut):
    figure = cloning.cloning_picture(copies, noise, cut)
    table = figure.axes[1]
    frame = table.patches[0]
    column, row = frame.get_x() + 0.5, frame.get_y() + 0.5
    (shown,) = [t.get_text() for t in table.texts if t.get_position() == (column, row)]
    total = 0.0
    for goal in range(4):
        rewards = copies.rollout.rewards[copies.place(noise, cut, goal)]
        total += sum(float(episode.sum()) for episode in rewards) / len(rewards)
    assert float(shown) == pytest.approx(total / 4, abs=0.51)
    said = float(re.search(r"return ([-\d.]+)", figure.axes[0].get_title())[1])
    one = copies.rollout.rewards[copies.place(noise, cut)].sum(-1).mean()
    assert said == pytest.approx(float(one), abs=0.06)


def test_noise_brings_back_what_the_cut_takes(copies):
    returns = dict(zip(EVERYTHING, copies.returns().flatten().tolist(), strict=True))
    assert max(returns[0.0, cut] for cut in (2, 4, 8)) < 20
    assert min(returns[0.1, cut] for cut in cloning.CUTS) > 40


@pytest.mark.parametrize(("noise", "cut"), [(0.15, 0), (0.1, 3)])
def test_a_copy_that_was_not_fitted_is_refused(copies, noise, cut):
    with pytest.raises(InputError, match=r"unknown (noise|cut)"):
        cloning.cloning_picture(copies, noise, cut)


def test_pictures_do_not_stay_open(copies):
    before = plt.get_fignums()
    cloning.cloning_picture(copies, 0.1, 4)
    assert plt.get_fignums() == before


def test_the_corridor_of_noisy_data_is_the_wider_one():
    clean, noisy = corridor().axes
    widths = [np.ptp(axes.collections[0].get_paths()[0].vertices[:, 1]) for axes in (clean, noisy)]
    plt.close("all")
    assert widths[1] > 2 * widths[0]


def test_a_walk_goes_through_its_places_in_even_steps():
    actions = designs.walk([0.3, 0.0], [0.3, 0.25])
    steps = 0.1 * actions.numpy()
    np.testing.assert_allclose(steps.cumsum(0)[[2, 5]], [[0.3, 0.0], [0.3, 0.25]], atol=1e-6)
    assert len(steps) == 6  # 3 of 0.1, and 3 of a twelfth
    assert np.linalg.norm(steps, axis=1).max() < 0.1 + 1e-6


@pytest.mark.parametrize("places", [(), ([1.0],), ([float("nan"), 0.0],)])
def test_a_place_that_is_none_is_refused(places):
    with pytest.raises(InputError, match="place"):
        designs.walk(*places)


def test_the_averaging_copy_creeps_by_the_excess_of_votes_onwards():
    """Three returns from half-way: 4 votes onwards and 3 back, a seventh of a step."""
    goal = torch.tensor([0.0, 2.0])
    hesitant = designs.walk(*[0.5 * goal, 0 * goal] * 3, goal)
    data = designs.as_demonstrations(goal, [hesitant])
    way = designs.averaging_copy(data, width=0.01).states
    assert float(way[1, 1]) == pytest.approx(0.1, abs=1e-4)  # at the start all votes go onwards
    assert float(way[2, 1] - way[1, 1]) == pytest.approx(0.1 / 7, abs=1e-4)


def test_the_averaging_copy_stops_before_the_place_where_the_demonstrator_turns():
    goal = torch.tensor([0.0, 2.0])
    data = designs.as_demonstrations(goal, [designs.walk(*[0.5 * goal, 0 * goal] * 3, goal)])
    copied = designs.averaging_copy(data, width=0.1)
    assert 0.8 < float(copied.states[-1, 1]) < 1.0
    assert designs.outcome(goal, copied, wanted=20.0) == designs.STAYS


def test_the_copy_of_the_honest_walk_arrives():
    goal = torch.tensor([0.0, 2.0])
    data = designs.as_demonstrations(goal, [designs.walk(goal)])
    copied = designs.averaging_copy(data, width=0.1)
    assert copied.reached
    assert designs.outcome(goal, copied, wanted=copied.total) == designs.ARRIVES

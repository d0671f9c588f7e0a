"""What notebook 02 shows on the page: the sliders on sparsity, and the chain from reward to gradient."""

import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
import torch

from emrld_lite.classroom.sketches.starvation import EMPTY, LINKS, reward_chain
from emrld_lite.classroom.widgets import sparsity
from emrld_lite.envs import make
from emrld_lite.policy import initialise
from emrld_lite.rollout import collect
from emrld_lite.validation import InputError


@pytest.fixture(scope="module")
def walks():
    """Return few walks, which draw fast."""
    return sparsity.random_walks(count=60, seed=3)


def closest(walk, angle):
    """Return how near one walk comes to a goal, in plain floats."""
    x, y = 2 * math.cos(math.radians(angle)), 2 * math.sin(math.radians(angle))
    return min(math.hypot(a - x, b - y) for a, b in walk.tolist())


@pytest.mark.parametrize("angle", range(0, 181, 60))
def test_the_picture_counts_the_walks_that_meet_the_disc(walks, angle):
    needed = sorted(closest(walk, angle) for walk in walks)
    for radius in (0.05, 0.8, 1.4, 1.95):
        plane, curve = sparsity.sparsity_picture(walks, angle, radius).axes
        assert plane.get_title() == f"{sum(d <= radius for d in needed)} of 60 walks are paid"
        (dot,) = (line for line in curve.lines if line.get_marker() == "o")
        share = 100 * sum(d <= radius for d in needed) / 60
        assert dot.get_xydata().tolist() == [[radius, pytest.approx(share)]]
    assert float(curve.get_title().split()[-1]) == pytest.approx(needed[29], abs=0.006)


def test_the_curve_is_the_share_of_every_radius(walks):
    needed = [closest(walk, 75) for walk in walks]
    curve = sparsity.sparsity_picture(walks, 75, 0.5).axes[1].lines[0].get_xydata()
    for radius, share in curve[::20]:
        assert share == pytest.approx(100 * np.mean([d <= radius for d in needed]), abs=1.7)


def test_the_walks_are_the_environments():
    """With a goal that no walk meets, a rollout goes through the same places."""
    walks = sparsity.random_walks(count=20, seed=5)
    tasks = make("point2d").training_tasks()[:1]
    random = torch.Generator().manual_seed(5)
    rollout = collect(make("point2d"), tasks, initialise(2, 2, 5), 20, random)
    assert rollout.mask.all()
    torch.testing.assert_close(rollout.states[0, :, 1:], walks[:, :-1])
    assert (walks[:, 1:] - walks[:, :-1]).norm(dim=-1).max() <= 0.1 + 1e-6


@pytest.mark.parametrize("wrong", [(-5, 0.2), (185, 0.2), (90, 0.0), (90, 2.0), (90, math.nan)])
def test_what_no_slider_gives_is_refused(walks, wrong):
    with pytest.raises(InputError, match=r"angle|radius"):
        sparsity.sparsity_picture(walks, *wrong)


def test_a_link_of_the_chain_is_empty_where_it_is_zero():
    figure = reward_chain({"nothing": [0.0] * 6, "something": [44, 44, 14, 30, 1e-5, 0.13]})
    boxes = figure.axes[0].patches
    empty = [box.get_facecolor() == plt.matplotlib.colors.to_rgba(EMPTY) for box in boxes]
    assert empty == [True] * 6 + [False] * 6
    assert [box.get_linestyle() for box in boxes] == ["--"] * 6 + ["-"] * 6
    written = [text.get_text() for text in figure.axes[0].texts]
    assert {*LINKS, "0", "44", "1e-05", "0.13"} <= set(written)
    plt.close(figure)


def test_a_chain_needs_one_size_per_link():
    with pytest.raises(InputError, match="one per link"):
        reward_chain({"too short": [0.0] * 5})

"""Notebook 01's sliders draw over their whole range, and what they show agrees with other calculations."""

import math
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest
import torch

from emrld_lite import policy
from emrld_lite.advantage import generalised_advantage
from emrld_lite.classroom import noise
from emrld_lite.classroom.sketches.causality import what_an_action_changes
from emrld_lite.classroom.widgets import exploration, gae
from emrld_lite.envs.point2d import STEP_LIMIT, displacement
from emrld_lite.validation import InputError


@pytest.fixture(scope="module")
def params():
    return policy.initialise(2, 2, seed=0)


@pytest.fixture(scope="module")
def spread(params):
    return exploration.measured_spread(params, episodes=100)


@pytest.fixture(scope="module")
def differences(params):
    def estimate(rewards, values, discount, gae_lambda):
        return generalised_advantage(rewards[None], values[None], discount, gae_lambda)[0]

    return gae.advantage_differences(params, estimate, pairs=400)


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    plt.close("all")


@pytest.mark.parametrize("sigma", [0.03, 0.2, 1.0, 5.0, 30.0])
def test_the_picture_of_sigma_says_its_share(params, spread, sigma):
    plane, curves = exploration.exploration_picture(params, spread, sigma).axes
    drawn = sigma * torch.randn(20_000, 2, generator=torch.Generator().manual_seed(1))
    moves = displacement(drawn, "at-most")
    altered = ((moves - STEP_LIMIT * drawn).norm(dim=1) > 1e-6).float().mean()
    assert exploration.altered_share(sigma) == pytest.approx(float(altered), abs=0.015)
    assert f"{100 * exploration.altered_share(sigma):.0f} %" in plane.get_title()
    assert any(list(line.get_xdata()) == [sigma, sigma] for line in curves.lines)


@pytest.mark.parametrize("sigma", exploration.MEASURED_AT)
def test_the_spread_by_formula_is_that_of_summed_steps(sigma):
    random = torch.Generator().manual_seed(2)
    steps = displacement(sigma * torch.randn(2000, 100, 2, generator=random), "at-most")
    ends = steps.sum(1)
    measured = float(ends.square().sum(1).mean().sqrt())
    assert exploration.expected_spread(sigma) == pytest.approx(measured, rel=0.05)


def test_the_spread_stops_growing(spread):
    measured = dict(zip(spread.sigmas, spread.distances, strict=True))
    assert measured[1.0] > 5 * measured[0.1]
    assert measured[30.0] < 1.3 * measured[1.0]


def test_a_sigma_out_of_range_is_refused(params, spread):
    with pytest.raises(InputError, match="sigma"):
        exploration.exploration_picture(params, spread, 100.0)


@pytest.mark.parametrize("values", gae.VALUES)
@pytest.mark.parametrize("count", gae.COUNTS)
@pytest.mark.parametrize("gae_lambda", [0.0, 0.45, 0.95, 1.0])
def test_the_picture_of_lambda_says_what_is_best(differences, values, count, gae_lambda):
    left, right = gae.gae_picture(differences, gae_lambda, values, count).axes
    errors = {
        one: differences.biases[values, one] ** 2
        + np.var(differences.estimates[values, one].numpy(), ddof=1) / count
        for one in gae.LAMBDAS
    }
    best = min(errors, key=errors.get)
    assert right.get_title().endswith(f"least error at {best:g}")
    assert f"lambda {gae_lambda:g}" in left.get_title()


def test_bias_ends_and_noise_begins_with_lambda(differences):
    for values in gae.VALUES:
        assert abs(differences.biases[values, 1.0]) < 1e-3
        assert abs(differences.biases[values, 0.0]) > 0.5
        noises = [differences.error_parts(values, one, 1)[1] for one in gae.LAMBDAS]
        assert noises[0] < 1e-6
        assert all(one < other for one, other in pairwise(noises))


def test_averaging_takes_out_noise_by_the_root_of_the_count(differences):
    for gae_lambda in (0.5, 0.95, 1.0):
        every = differences.estimates["the linear baseline", gae_lambda]
        spread = float(every.reshape(100, 4).mean(1).std())
        noise_of_four = differences.error_parts("the linear baseline", gae_lambda, 4)[1]
        assert spread == pytest.approx(noise_of_four, rel=0.25)


def test_without_a_value_function_lambda_zero_sees_one_reward(differences):
    """The first rewards differ by 2.1 - 1.9, whatever comes after."""
    seen = differences.exact + differences.biases["zero", 0.0]
    assert seen == pytest.approx(0.2, abs=1e-5)


def test_the_first_steps_lead_towards_the_goal_and_away(params):
    rollout = gae.first_steps(params, episodes=30, seed=0)
    assert torch.allclose(rollout.states[0, :, 1], torch.tensor([0.0, 0.1]))
    assert torch.allclose(rollout.states[1, :, 1], torch.tensor([0.0, -0.1]))
    moved = rollout.states[:, :, 2] - rollout.states[:, :, 1]
    assert torch.allclose(moved, displacement(rollout.actions[:, :, 1], "at-most"), atol=1e-6)


def test_estimates_are_weighted_sums_of_residuals(params, differences):
    """Each by its definition, sum of (gamma lambda)^k delta_k, for the first pairs."""
    rollout = gae.first_steps(params, episodes=400, seed=3)
    values = gae.baseline_of(params, rollout, seed=4)
    after = torch.cat([values[..., 1:], torch.zeros_like(values[..., :1])], -1)
    residuals = (rollout.rewards + gae.DISCOUNT * after - values).double()
    powers = (gae.DISCOUNT * 0.9) ** torch.arange(residuals.shape[-1]).double()
    towards, away = (residuals * powers).sum(-1)
    found = differences.estimates["the linear baseline", 0.9]
    assert torch.allclose(found, towards - away.roll(200), atol=1e-3)


def test_the_clouds_show_every_estimate():
    random = torch.Generator().manual_seed(0)
    found = {
        name: (
            estimates := 1 + scale * torch.randn(12, 5, generator=random),
            noise.noise(estimates),
        )
        for name, scale in (("wide", 2.0), ("narrow", 0.2))
    }
    expected = math.sqrt(float(found["wide"][0].var(0, correction=0).sum()))
    assert found["wide"][1] == pytest.approx(expected, rel=1e-5)
    figure = noise.clouds(found)
    assert [len(axes.collections[0].get_offsets()) for axes in figure.axes] == [12, 12]
    assert [axes.get_title().split(":")[0] for axes in figure.axes] == ["wide", "narrow"]


def test_the_drawing_weighs_each_reward_as_the_return_does():
    words = [text.get_text() for text in what_an_action_changes().axes[0].texts]
    assert {"$ R_0$", r"$\gamma R_1$", r"$\gamma^4 R_4$"} <= set(words)

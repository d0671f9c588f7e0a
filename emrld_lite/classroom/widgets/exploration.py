"""A slider on sigma: which drawn actions the environment alters, and how far the paths spread."""

from __future__ import annotations

import math
from typing import NamedTuple

import ipywidgets
import matplotlib.pyplot as plt
import numpy as np
import torch
from IPython.display import display
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...envs import make
from ...experiments import plotting
from ...policy import Params
from ...rollout import Rollout, collect
from ...validation import real_number
from .answer import as_image

SMALLEST, LARGEST = 0.03, 30.0
MEASURED_AT = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
GOAL = torch.tensor([[0.0, 2.0]])


class Spread(NamedTuple):
    """How far episodes end from each other, measured at some sigmas."""

    sigmas: tuple[float, ...]
    distances: list[float]
    """Root mean squared distance of the last states from their mean, length units."""


def altered_share(sigma: float) -> float:
    """Return the probability that an action drawn with mean 0 is outside of the disc of radius 1."""
    return math.exp(-0.5 / sigma**2)


def expected_spread(sigma: float) -> float:
    """Return the root mean squared distance from the start after 100 steps whose mean is 0.

    With r the drawn action's length, r^2 is exponential with mean 2 sigma^2, and a step is
    0.1 min(r, 1) long. Independent steps add their squares.
    """
    return math.sqrt(2.0 * sigma**2 * -math.expm1(-0.5 / sigma**2))


def paths_with(params: Params, sigma: float, episodes: int, seed: int = 0) -> Rollout:
    """Return episodes on Point2D of the policy with another sigma, from the same draws for each."""
    real_number("sigma", sigma, SMALLEST, LARGEST)
    wider = {**params, "log_sigma": torch.full_like(params["log_sigma"], math.log(sigma))}
    return collect(make("point2d"), GOAL, wider, episodes, torch.Generator().manual_seed(seed))


def measured_spread(params: Params, episodes: int = 200) -> Spread:
    """Return how far the ends of episodes lie from their mean, at seven sigmas."""
    distances = []
    for sigma in MEASURED_AT:
        rollout = paths_with(params, sigma, episodes)
        last = rollout.mask[0].sum(-1).long() - 1  # (episode,)
        ends = rollout.states[0, torch.arange(episodes), last]  # (episode, 2)
        distances.append(float((ends - ends.mean(0)).square().sum(1).mean().sqrt()))
    return Spread(MEASURED_AT, distances)


def exploration_sliders(params: Params, spread: Spread) -> None:
    """Show a slider for sigma over the paths and the two curves."""

    def show(sigma: float) -> None:
        display(as_image(exploration_picture(params, spread, sigma)))

    ipywidgets.interact(
        show,
        sigma=ipywidgets.FloatLogSlider(
            value=1.0,
            min=math.log10(SMALLEST),
            max=math.log10(LARGEST),
            step=0.05,
            continuous_update=False,
        ),
    )


def exploration_picture(params: Params, spread: Spread, sigma: float = 1.0) -> Figure:
    """Return twenty paths with this sigma, and the altered share and the spread over all sigmas."""
    rollout = paths_with(params, sigma, episodes=20)
    figure, (plane, curves) = plt.subplots(1, 2, figsize=(8.4, 3.4), layout="none")  # which is slow
    figure.subplots_adjust(left=0.08, right=0.99, bottom=0.15, top=0.9, wspace=0.2)
    make("point2d").draw_tasks(plane, GOAL)
    plotting.trajectories(rollout, plane, episodes=20)
    plane.plot(0, 0, marker="x", color="black", markersize=8, zorder=5)  # over the paths
    plane.set(xlim=(-2.4, 2.4), ylim=(-2.1, 2.4), xticks=range(-2, 3), yticks=range(-2, 3))
    plane.set_title(f"sigma {sigma:.2g}: {100 * altered_share(sigma):.0f} % of actions altered")
    _over_all_sigmas(curves, spread)
    curves.axvline(sigma, color="black", linewidth=1, linestyle="--")
    plt.close(figure)
    return figure


def _over_all_sigmas(curves: Axes, spread: Spread) -> None:
    """Draw the altered share and the spread, by their formulas, and the spread as measured."""
    every = np.geomspace(SMALLEST, LARGEST, 80)
    curves.plot(every, [altered_share(one) for one in every], ":", color="#D55E00")
    curves.plot(every, [expected_spread(one) for one in every], color="#0072B2")
    curves.plot(spread.sigmas, spread.distances, "o", color="#0072B2", markersize=5)
    curves.text(0.035, 0.62, "spread of the ends\n(length units)", color="#0072B2", fontsize=9)
    curves.text(2.2, 0.55, "share of actions\nthat is altered", color="#D55E00", fontsize=9)
    curves.set_xscale("log")
    curves.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    curves.minorticks_off()
    curves.set(xlabel="sigma (units of the action)", ylabel="share, or length units")
    curves.set(ylim=(-0.03, 1.1), yticks=[0.0, 0.5, 1.0])

"""A slider on sparsity: the same random walks, a goal that moves, and a disc that grows and shrinks."""

from __future__ import annotations

import math

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from matplotlib.figure import Figure

from ...envs import make
from ...envs.drawing import round_goal
from ...envs.goals import GOAL_RADIUS
from ...policy import initialise
from ...rollout import collect
from ...validation import real_number


def random_walks(count: int = 500, seed: int = 0) -> torch.Tensor:
    """Return walks of an untrained policy on Point2D, (walk, time, 2); no goal stops them."""
    environment = make("point2d")
    tasks = environment.training_tasks()[:1]
    random = torch.Generator().manual_seed(seed)
    return collect(environment, tasks, initialise(2, 2, seed), count, random).states[0]


def sparsity_sliders(walks: torch.Tensor) -> None:
    """Show sliders for the goal's angle and the radius that pays, over the same walks."""

    def show(angle: float, radius: float) -> None:
        display(sparsity_picture(walks, angle, radius))

    ipywidgets.interact(
        show,
        angle=ipywidgets.IntSlider(value=60, min=0, max=180, step=5, continuous_update=False),
        radius=ipywidgets.FloatSlider(
            value=0.2, min=0.02, max=2.0, step=0.02, continuous_update=False
        ),
    )


def sparsity_picture(walks: torch.Tensor, angle: float, radius: float) -> Figure:
    """Return the walks, those that meet the disc in colour; ``angle`` in degrees from the x axis."""
    real_number("angle in degrees", angle, 0, 180)
    real_number("radius", radius, minimum=0.0)
    turn = math.radians(angle)
    goal = torch.tensor([GOAL_RADIUS * math.cos(turn), GOAL_RADIUS * math.sin(turn)])
    met = ((walks - goal).norm(dim=-1) <= radius).any(-1)  # (walk,)
    figure, axes = plt.subplots(figsize=(5, 4.2))
    for walk in walks[~met][:150]:
        axes.plot(walk[:, 0], walk[:, 1], color="#BBBBBB", linewidth=0.5)
    for walk in walks[met]:
        axes.plot(walk[:, 0], walk[:, 1], color="#D55E00", linewidth=1.0)
    round_goal(axes, goal.tolist(), radius)
    axes.set(xlim=(-2.8, 2.8), ylim=(-2.0, 2.8), aspect="equal")
    axes.set(xlabel="x (length units)", ylabel="y (length units)")
    axes.set_title(f"{int(met.sum())} of {len(walks)} walks are paid")
    plt.close(figure)
    return figure

"""Sliders on sparsity: the same random walks, a goal that moves, and a disc that grows and shrinks."""

from __future__ import annotations

import math

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import PlaceHolderLayoutEngine
from torch import Tensor

from ...envs.drawing import round_goal
from ...envs.goals import GOAL_RADIUS
from ...envs.point2d import HORIZON, NEAR, displacement
from ...policy import initialise, mean
from ...validation import real_number
from .answer import as_image

ANGLES = (0, 180)  # degrees from the x axis
RADII = (0.05, 1.95)  # at 2 the start itself would be paid
DRAWN = 60  # walks of each kind: more of them make no better picture

Walks = Float[Tensor, "walk time 2"]


def random_walks(count: int = 500, seed: int = 0) -> Walks:
    """Return the places after each step of an untrained policy's walks; no goal stops them."""
    params = initialise(2, 2, seed)
    noise = torch.randn(1, count, HORIZON, 2, generator=torch.Generator().manual_seed(seed))
    place, places = torch.zeros(1, count, 2), []
    for time in range(HORIZON):
        place = place + displacement(mean(params, place) + noise[:, :, time], "at-most")
        places.append(place[0])
    return torch.stack(places, dim=1)


def closest_approaches(walks: Walks, angle: float) -> Float[Tensor, " walk"]:
    """Return how near each walk comes to the goal at ``angle`` degrees: the radius that it needs."""
    real_number("angle in degrees", angle, *ANGLES)
    goal = torch.tensor(_goal(angle))
    return (walks - goal).norm(dim=-1).amin(-1)


def sparsity_sliders(walks: Walks) -> None:
    """Show sliders for the goal's angle and the radius that pays, over the same walks."""

    def show(angle: float, radius: float) -> None:
        display(as_image(sparsity_picture(walks, angle, radius)))

    low, high = RADII
    ipywidgets.interact(
        show,
        angle=ipywidgets.IntSlider(
            value=90, min=ANGLES[0], max=ANGLES[1], step=5, continuous_update=False
        ),
        radius=ipywidgets.FloatSlider(
            value=NEAR, min=low, max=high, step=0.05, continuous_update=False
        ),
    )


def sparsity_picture(walks: Walks, angle: float, radius: float) -> Figure:
    """Return the walks, those that meet the disc marked, beside the share that every radius would pay."""
    real_number("radius", radius, *RADII)
    needed = closest_approaches(walks, angle)
    placed = PlaceHolderLayoutEngine(adjust_compatible=True, colorbar_gridspec=False)
    figure = plt.figure(figsize=(9.2, 3.9), layout=placed)  # a real engine draws everything twice
    plane = figure.add_axes((0.07, 0.13, 0.45, 0.78))
    curve = figure.add_axes((0.62, 0.13, 0.36, 0.78))
    _draw_walks(plane, walks, needed <= radius)
    round_goal(plane, _goal(angle), radius)
    plane.set_title(f"{int((needed <= radius).sum())} of {len(walks)} walks are paid")
    _draw_shares(curve, needed, radius)
    plt.close(figure)
    return figure


def _goal(angle: float) -> list[float]:
    turn = math.radians(angle)
    return [GOAL_RADIUS * math.cos(turn), GOAL_RADIUS * math.sin(turn)]


def _draw_walks(axes: Axes, walks: Walks, paid: Tensor) -> None:
    """Draw some walks that are paid in thick lines, and some that are not in thin ones."""
    looks = ((~paid, "#BBBBBB", 0.5), (paid, "#D55E00", 1.1))
    for chosen, colour, width in looks:
        lines = walks[chosen][:DRAWN].numpy()
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=width))
    axes.plot(0, 0, marker="x", color="black", markersize=7)
    axes.set(xlim=(-2.8, 2.8), ylim=(-1.8, 2.8), aspect="equal")
    axes.set(xticks=(-2, 0, 2), yticks=(0, 2))  # every label costs time to draw
    axes.set(xlabel="x (length units)", ylabel="y (length units)")


def _draw_shares(axes: Axes, needed: Tensor, radius: float) -> None:
    """Draw which share of the walks a disc of each radius pays; the present radius as a dot."""
    radii = torch.linspace(*RADII, 200)
    shares = 100 * (needed[:, None] <= radii).double().mean(0)
    axes.plot(radii, shares, color="#333333")
    present = 100 * float((needed <= radius).double().mean())
    axes.plot(radius, present, marker="o", color="#D55E00", markersize=8)
    axes.axvline(NEAR, color="#0072B2", linestyle="--", label=f"the paper's {NEAR}")
    axes.set(xlabel="radius of the disc that pays (length units)", ylabel="walks that are paid (%)")
    axes.set(xlim=(0, 2), ylim=(-3, 103), xticks=(0, 1, 2), yticks=(0, 50, 100))
    axes.set_title(f"half of the walks need a radius of {float(needed.median()):.2f}")
    axes.legend(loc="upper left")

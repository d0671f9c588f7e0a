"""The states that demonstrations cover, as a corridor: where a copy leaves it, and what brings it back."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...envs.drawing import GOAL_COLOUR
from ...experiments.plotting import DEMONSTRATION_COLOUR

COVERED, COPY = "#FDF1DC", "#0072B2"
ALONG = np.linspace(0.0, 10.0, 200)


def corridor() -> Figure:
    """Return two drawings: a demonstration without corrections, and one with them."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 2.9), sharey=True)
    _frame(panels[0], "clean data: one line of states", 0.13)
    panels[0].plot(ALONG, 0 * ALONG, color=DEMONSTRATION_COLOUR, linestyle="--")
    left = 0.012 * ALONG**2 + 0.05 * np.sin(2 * ALONG)
    panels[0].plot(ALONG, left, color=COPY)
    panels[0].text(6.0, 0.95, "no data here:\nnobody showed\nthe way back", ha="center", color=COPY)
    panels[0].annotate(
        "small errors add up", (3.2, 0.14), (0.6, 0.75), arrowprops={"arrowstyle": "->"}
    )
    _frame(panels[1], "noisy data: a corridor of states", 0.55)
    shown = 0.42 * np.sin(2.1 * ALONG) * np.exp(-0.02 * ALONG)
    panels[1].plot(ALONG, shown, color=DEMONSTRATION_COLOUR, linestyle="--")
    panels[1].plot(ALONG, 0.2 * np.sin(1.4 * ALONG + 0.3) * ALONG**0.2, color=COPY)
    for place in np.arange(0.75, 9.5, 1.5):
        side = np.sign(np.sin(2.1 * place))
        look = {"arrowstyle": "->", "color": "#555555", "linewidth": 1.4}
        ends = {"xy": (place + 0.35, 0.12 * side), "xytext": (place, 0.5 * side)}
        panels[1].annotate("", **ends, arrowprops=look)
    panels[1].text(5.0, 0.95, "arrows: the corrections\nthat the demonstrator shows", ha="center")
    return figure


def _frame(axes: Axes, title: str, width: float) -> None:
    """Draw start, goal and the covered states, ``width`` to either side."""
    axes.set(xlim=(-0.8, 11.2), ylim=(-0.9, 1.75))
    axes.axis("off")
    axes.fill_between(ALONG, -width, width, color=COVERED)
    axes.plot(0, 0, marker="x", color="black", markersize=9, linestyle="none")
    axes.plot(10, 0, marker="*", color=GOAL_COLOUR, markersize=18, markeredgecolor="black")
    axes.text(0, -0.75, "start", ha="center")
    axes.text(10, -0.75, "goal", ha="center")
    axes.set_title(title)

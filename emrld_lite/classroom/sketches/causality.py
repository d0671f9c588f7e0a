"""One episode as a drawing: where the parameters enter, and which rewards one action can change."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .shapes import DATA, PARAMETERS, box

STEPS, CHOSEN = 5, 2
LATER, EARLIER = "#0072B2", "#999999"


def what_an_action_changes() -> Figure:
    """Return a drawing of five steps: the policy draws every action, and one action reaches forward."""
    figure, axes = plt.subplots(figsize=(8.6, 3.5))
    axes.set(xlim=(-1.2, 10.4), ylim=(-1.2, 4.3))
    axes.axis("off")
    axes.grid(visible=False)
    for step in range(STEPS):
        _one_step(axes, step)
    for step in range(CHOSEN, STEPS):
        _link(axes, (2 * CHOSEN + 0.15, 1.5), (2 * step, 0.55), LATER, "-")
    _reach(axes, -0.7, 2 * CHOSEN - 0.7, f"already there when $a_{CHOSEN}$ is drawn", EARLIER)
    _reach(axes, 2 * CHOSEN - 0.55, 9.0, f"what $a_{CHOSEN}$ can change", LATER)
    axes.text(10.3, 3.7, r"$\theta$ is here only", color="#555555", ha="right", va="bottom")
    axes.annotate("", (8.35, 2.2), (9.6, 3.65), arrowprops={"arrowstyle": "->", "color": "#555555"})
    axes.text(-1.1, 3.1, "states", ha="right", va="center", fontsize=9)
    axes.text(-1.1, 1.9, "actions", ha="right", va="center", fontsize=9)
    axes.text(-1.1, 0.2, "rewards\nas in $G(\\tau)$", ha="right", va="center", fontsize=9)
    return figure


def _one_step(axes: Axes, step: int) -> None:
    place = 2 * step
    box(axes, (place, 3.1), f"$s_{step}$", "white")
    box(axes, (place, 1.9), f"$a_{step}$", PARAMETERS)
    factor = {0: "", 1: r"\gamma"}.get(step, rf"\gamma^{step}")
    box(axes, (place, 0.2), f"${factor} R_{step}$", DATA)
    _link(axes, (place, 2.72), (place, 2.3), "black", "-")
    if step + 1 < STEPS:
        _link(axes, (place + 0.4, 3.1), (place + 1.6, 3.1), "black", "-")
        _link(axes, (place + 0.4, 2.1), (place + 1.6, 2.85), "black", "-")
    if step != CHOSEN:
        _link(axes, (place, 1.5), (place, 0.6), EARLIER, ":")


def _link(
    axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str, line: str
) -> None:
    look = {"arrowstyle": "->", "color": colour, "linewidth": 1.3, "linestyle": line}
    axes.annotate("", xy=end, xytext=start, arrowprops=look)


def _reach(axes: Axes, start: float, end: float, text: str, colour: str) -> None:
    axes.plot([start, start, end, end], [-0.3, -0.45, -0.45, -0.3], color=colour, linewidth=1.5)
    axes.text((start + end) / 2, -0.6, text, ha="center", va="top", color=colour, fontsize=10)

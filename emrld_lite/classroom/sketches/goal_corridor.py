"""The corridor as a drawing: five cells in a row, the goal at one end, and who is where how often."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from .shapes import DATA, PARAMETERS

LOOKS = {"color": ("#DDDDDD", "#9BC7E4", "#555555"), "hatch": ("", "//", "..")}
DEPTH = 0.16  # of the row of cells below the axis, in units of the visitation


def corridor(axes: Axes, visits: Mapping[str, Sequence[float]], start: int, goal: int) -> None:
    """Draw the row of cells, and above each how much of its time every policy spends there."""
    cells = len(next(iter(visits.values())))
    for cell in range(cells):
        colour = {goal: DATA, start: PARAMETERS}.get(cell, "white")
        axes.add_patch(
            Rectangle((cell - 0.5, -DEPTH), 1, DEPTH, facecolor=colour, edgecolor="#555555")
        )
        text = {goal: "goal: +1", start: "start"}.get(cell, "")
        axes.text(cell, -DEPTH / 2, text, ha="center", va="center", fontsize=9)
    axes.annotate(
        "",
        xy=(start, -DEPTH),
        xytext=(goal, -DEPTH),
        arrowprops={
            "arrowstyle": "->",
            "linestyle": ":",
            "color": "#555555",
            "connectionstyle": f"arc3,rad={0.2 if goal < start else -0.2}",
        },
    )
    middle = (start + goal) / 2
    axes.text(middle, -1.95 * DEPTH, "starts again", ha="center", color="#555555", fontsize=9)
    for place, (name, shares) in enumerate(visits.items()):
        look = {key: values[place % len(values)] for key, values in LOOKS.items()}
        at = np.arange(cells) + 0.27 * (place - 1)
        axes.bar(at, np.asarray(shares), 0.25, label=name, edgecolor="#333333", **look)
    axes.set(xlim=(-0.6, cells - 0.4), ylim=(-2.1 * DEPTH, None), xlabel="state")
    axes.set(xticks=range(cells), yticks=[0, 0.2, 0.4, 0.6])
    axes.grid(visible=False, axis="x")

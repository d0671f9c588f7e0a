"""From rewards to the gradient as a drawing: at which link of the chain nothing is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...validation import InputError

LINKS = {
    r"reward $R_t$": "summed up",
    r"return $G_t$": "fitted",
    r"baseline $B(s_t)$": "subtracted",
    r"$G_t - B(s_t)$": "divided by its\ndeviation",
    r"advantage $\hat A_t$": r"times $\nabla \log \pi$,"
    "\nthe mean of it",
    r"gradient": "",
}
EMPTY, FILLED = "#EEEEEE", "#FDF1DC"
APART, WIDE, HIGH = 2.6, 1.5, 0.62  # between boxes, and their size


def reward_chain(rows: Mapping[str, Sequence[float]]) -> Figure:
    """Return the chain from reward to gradient, with the largest size of each link in every row.

    A link that is exactly zero is an empty, dashed box. Raises InputError for a row of another length.
    """
    figure, axes = plt.subplots(figsize=(11, 1.3 + 0.75 * len(rows)))
    for row, (name, sizes) in enumerate(rows.items()):
        if len(sizes) != len(LINKS):
            raise InputError(f"{name}: expected {len(LINKS)} sizes, one per link, got {len(sizes)}")
        axes.text(-1.1, -row, name, ha="right", va="center", fontsize=10)
        for place, size in enumerate(sizes):
            _link(axes, place * APART, -row, size, last=place == len(sizes) - 1)
    for place, (link, step) in enumerate(LINKS.items()):
        axes.text(place * APART, 0.62, link, ha="center", va="bottom", fontsize=10)
        middle = (place + 0.5) * APART
        axes.text(
            middle, -len(rows) + 0.3, step, ha="center", va="top", fontsize=8, color="#555555"
        )
    axes.set(xlim=(-5.2, 5 * APART + 1), ylim=(-len(rows) - 0.35, 1.15))
    axes.axis("off")
    return figure


def _link(axes: Axes, x: float, y: float, size: float, last: bool) -> None:
    """Draw one link's box with its size, and the arrow to the next."""
    zero = size == 0
    axes.add_patch(
        plt.Rectangle(
            (x - WIDE / 2, y - HIGH / 2),
            WIDE,
            HIGH,
            facecolor=EMPTY if zero else FILLED,
            edgecolor="#555555",
            linestyle="--" if zero else "-",
        )
    )
    axes.text(x, y, f"{size:.2g}", ha="center", va="center", fontsize=10)
    if not last:
        look = {"arrowstyle": "->", "color": "#AAAAAA" if zero else "black"}
        start, end = (x + WIDE / 2, y), (x + APART - WIDE / 2, y)
        axes.annotate("", xy=end, xytext=start, arrowprops=look)

"""The parts that every schematic drawing is made of: a symbol in a box, and an arrow between two."""

from __future__ import annotations

from matplotlib.axes import Axes

PARAMETERS, DATA = "#DCEBF7", "#FDF1DC"  # boxes of policies, and of episodes


def box(axes: Axes, centre: tuple[float, float], text: str, colour: str) -> None:
    """Write a symbol in a box."""
    axes.text(
        *centre,
        text,
        ha="center",
        va="center",
        fontsize=15,
        bbox={"boxstyle": "round,pad=0.35", "facecolor": colour, "edgecolor": "#555555"},
    )


def arrow(
    axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str, colour: str
) -> None:
    """Draw an arrow with what happens on the way above it."""
    look = {"arrowstyle": "->", "color": colour, "linewidth": 1.6}
    axes.annotate("", xy=end, xytext=start, arrowprops=look)
    middle = ((start[0] + end[0]) / 2, start[1] + 0.12)
    axes.text(*middle, text, ha="center", va="bottom", fontsize=9, color=colour)

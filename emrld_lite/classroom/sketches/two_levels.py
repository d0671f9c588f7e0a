"""Algorithm 1 as a drawing: what is collected, adapted and updated, and in which order."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .shapes import DATA, PARAMETERS, arrow, box

REWARD, CLONING, BACK = "#9A6A00", "#333333", "#555555"  # no algorithm's colour
SYMBOLS = (
    ((0.9, 2.5), r"$\theta_k$", PARAMETERS),
    ((3.5, 2.5), r"$\tilde\theta_{k,i}$", PARAMETERS),
    ((6.0, 2.5), r"$\mathcal{D}^{\mathrm{tr}}_i$", DATA),
    ((5.0, 0.7), r"$\mathcal{D}^{\mathrm{dem}}_i$", DATA),
    ((8.7, 2.5), r"$\theta_{k,i}$", PARAMETERS),
    ((11.2, 2.5), r"$\mathcal{D}^{\mathrm{val}}_i$", DATA),
    ((13.9, 2.5), r"$\theta_{k+1}$", PARAMETERS),
)


def two_levels() -> Figure:
    """Return a drawing of Algorithm 1: the adaptation of each task inside, the meta-update around it."""
    figure, axes = plt.subplots(figsize=(9.8, 3.5))
    axes.set(xlim=(0.3, 14.7), ylim=(-0.1, 4.6))
    axes.axis("off")
    axes.grid(visible=False)
    inside = {"fill": False, "linestyle": "--", "edgecolor": "#777777"}
    axes.add_patch(plt.Rectangle((2.5, 0.05), 9.4, 3.55, **inside))
    axes.text(11.75, 0.25, "for each task $i$", ha="right", color=BACK, fontsize=11)
    for symbol in SYMBOLS:
        box(axes, *symbol)
    arrow(axes, (1.35, 2.5), (2.95, 2.5), "", "black")
    _dashed(axes, (4.4, 0.9), (3.55, 1.95))
    axes.text(2.65, 0.95, "EMRLD-WS:\none step on\n" + r"$\mathcal{L}^{\mathrm{BC}}$", fontsize=9)
    arrow(axes, (4.1, 2.5), (5.4, 2.5), "roll out\nline 6", "black")
    arrow(axes, (6.6, 2.5), (8.1, 2.5), _weighted("rl", "RL"), REWARD)
    _dashed(axes, (5.65, 0.85), (8.35, 2.0))
    axes.text(7.1, 0.95, _weighted("bc", "BC"), color=CLONING, fontsize=12)
    axes.text(8.75, 1.75, "line 7", fontsize=9)
    arrow(axes, (9.3, 2.5), (10.6, 2.5), "roll out\nline 8", "black")
    arrow(axes, (11.8, 2.5), (13.3, 2.5), "TRPO\nline 10", REWARD)
    way = {"arrowstyle": "->", "linestyle": ":", "color": BACK, "connectionstyle": "arc3,rad=0.17"}
    axes.annotate("", xy=(0.9, 3.0), xytext=(11.2, 3.0), arrowprops={**way, "linewidth": 1.6})
    said = "the meta-gradient goes back through the adaptation"
    axes.text(6.0, 4.2, said, ha="center", color=BACK, fontsize=10)
    return figure


def _weighted(weight: str, loss: str) -> str:
    return rf"$w_{{\mathrm{{{weight}}}}} \nabla \mathcal{{L}}^{{\mathrm{{{loss}}}}}$"


def _dashed(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Draw the arrow of what the demonstration does."""
    look = {"arrowstyle": "->", "color": CLONING, "linewidth": 1.6, "linestyle": (0, (4, 2))}
    axes.annotate("", xy=end, xytext=start, arrowprops=look)

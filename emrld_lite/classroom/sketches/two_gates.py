"""Where on its way MAML starves, as a drawing: the two places at which a reward must be found."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .shapes import DATA, PARAMETERS, arrow, box

FED, STARVED = "#0072B2", "#B03A00"
LINE, BELOW = 3.3, 1.0  # heights of the way with rewards, and of what happens without


def two_gates() -> Figure:
    """Return a drawing of one meta-iteration of MAML, and of what each lack of a reward does to it."""
    figure, axes = plt.subplots(figsize=(9.4, 3.6))
    axes.set(xlim=(0, 13), ylim=(0, 4.6))
    axes.axis("off")
    box(axes, (0.9, LINE), r"$\theta$", PARAMETERS)
    box(axes, (3.9, LINE), r"$\mathcal{D}^{\mathrm{tr}}_i$", DATA)
    box(axes, (6.7, LINE), r"$\theta_i$", PARAMETERS)
    box(axes, (9.3, LINE), r"$\mathcal{D}^{\mathrm{val}}_i$", DATA)
    box(axes, (12.2, LINE), r"$g_i$", PARAMETERS)
    arrow(axes, (1.4, LINE), (3.3, LINE), "roll out", "black")
    arrow(axes, (4.5, LINE), (6.2, LINE), "adapt", FED)
    arrow(axes, (7.2, LINE), (8.7, LINE), "roll out", "black")
    arrow(axes, (9.9, LINE), (11.7, LINE), "meta-gradient", FED)
    axes.text(
        3.9, 4.35, "first gate: a reward here?", ha="center", color=FED, fontsize=10, weight="bold"
    )
    axes.text(
        9.3, 4.35, "second gate: and here?", ha="center", color=FED, fontsize=10, weight="bold"
    )
    _starves(
        axes,
        3.9,
        "none: every advantage is 0,\n" + r"$\theta_i = \theta$, $H = 0$: nothing is adapted",
    )
    _starves(
        axes,
        9.3,
        "none: every advantage is 0,\n" + r"$g_i = 0$: nothing is learned from task $i$",
    )
    return figure


def _starves(axes: Axes, place: float, text: str) -> None:
    """Draw the way out of the loop below a box: a dashed arrow with a cross at its end."""
    look = {"arrowstyle": "-|>", "color": STARVED, "linewidth": 1.6, "linestyle": "--"}
    axes.annotate("", xy=(place, BELOW + 0.75), xytext=(place, LINE - 0.5), arrowprops=look)
    axes.plot(place, BELOW + 0.5, "x", color=STARVED, markersize=11, markeredgewidth=2.5)
    axes.text(place, BELOW + 0.2, text, ha="center", va="top", color=STARVED, fontsize=10)

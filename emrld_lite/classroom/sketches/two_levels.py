"""Algorithm 1 as a drawing: what is collected, adapted and updated, and in which order."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ...experiments.plotting import LOOKS
from .shapes import DATA, PARAMETERS, arrow, box

RL_COLOUR, CLONING_COLOUR = LOOKS["emrld"]["color"], LOOKS["emrld-ws"]["color"]


def two_levels() -> Figure:
    """Return a drawing of Algorithm 1: the adaptation of each task inside, the meta-update around it."""
    figure, axes = plt.subplots(figsize=(9, 3.2))
    axes.set(xlim=(0, 12), ylim=(0, 4.2))
    axes.axis("off")
    axes.grid(visible=False)
    axes.add_patch(
        plt.Rectangle((2.35, 0.25), 7.1, 3.35, fill=False, linestyle="--", edgecolor="#777777")
    )
    axes.text(9.3, 0.45, "for each task $i$", ha="right", color="#555555", fontsize=10)
    box(axes, (1.1, 2.4), r"$\theta_k$", PARAMETERS)
    box(axes, (3.7, 2.4), r"$\mathcal{D}^{\mathrm{tr}}_i$", DATA)
    box(axes, (3.7, 0.8), r"$\mathcal{D}^{\mathrm{dem}}_i$", DATA)
    box(axes, (6.2, 2.4), r"$\theta_{k,i}$", PARAMETERS)
    box(axes, (8.5, 2.4), r"$\mathcal{D}^{\mathrm{val}}_i$", DATA)
    box(axes, (10.9, 2.4), r"$\theta_{k+1}$", PARAMETERS)
    arrow(axes, (1.6, 2.4), (3.2, 2.4), "roll out\n(line 6)", "black")
    arrow(
        axes,
        (4.2, 2.4),
        (5.7, 2.4),
        r"$w_{\mathrm{rl}} \nabla \mathcal{L}^{\mathrm{RL}}$",
        RL_COLOUR,
    )
    arrow(axes, (4.2, 0.8), (5.9, 2.0), "", CLONING_COLOUR)
    axes.text(
        5.5, 1.05, r"$w_{\mathrm{bc}} \nabla \mathcal{L}^{\mathrm{BC}}$", color=CLONING_COLOUR
    )
    axes.text(6.2, 1.62, "(line 7)", ha="center", fontsize=9)
    arrow(axes, (6.7, 2.4), (8.0, 2.4), "roll out\n(line 8)", "black")
    arrow(axes, (9.0, 2.4), (10.4, 2.4), "TRPO\n(line 10)", RL_COLOUR)
    axes.annotate(
        "",
        xy=(1.1, 2.85),
        xytext=(8.5, 2.85),
        arrowprops={
            "arrowstyle": "->",
            "linestyle": ":",
            "color": "#555555",
            "connectionstyle": "arc3,rad=0.2",
        },
    )
    axes.text(
        4.8,
        3.82,
        "the meta-gradient goes back through line 7",
        ha="center",
        color="#555555",
        fontsize=9,
    )
    return figure

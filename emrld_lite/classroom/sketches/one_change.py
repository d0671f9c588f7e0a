"""Control and switched runs as a drawing: which comparisons say what did it, and which do not."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

SAME, CHANGED, MARK = "#DCEBF7", "#D55E00", "#B03A00"
SETTINGS = (
    "data",
    r"$w_{\mathrm{rl}}$",
    r"$w_{\mathrm{bc}}$",
    "warm\nstart",
    "opti-\nmiser",
    "itera-\ntions",
)
ROWS = (
    ("control", (), ""),
    ("one switch", (2,), "differs in one setting: this did it"),
    ("another", (3,), "differs in one setting: this did it"),
    ("two at once", (1, 4), "which of the two did it? nobody can say"),
)


def one_change() -> Figure:
    """Return the settings of a control and of three runs to compare with it; changed ones are hatched."""
    figure, axes = plt.subplots(figsize=(9.2, 3.0))
    for row, (name, changed, said) in enumerate(ROWS):
        axes.text(-0.25, -row, name, ha="right", va="center", fontsize=10)
        for column in range(len(SETTINGS)):
            _setting(axes, column, -row, column in changed)
        wrong = len(changed) > 1
        axes.text(
            len(SETTINGS) + 0.15,
            -row,
            said,
            va="center",
            fontsize=10,
            color=MARK if wrong else "black",
            weight="bold" if wrong else "normal",
        )
    for column, setting in enumerate(SETTINGS):
        axes.text(column + 0.45, 0.55, setting, ha="center", va="bottom", fontsize=10)
    axes.set(xlim=(-1.9, 11.6), ylim=(-len(ROWS) + 0.4, 1.35))
    axes.axis("off")
    return figure


def _setting(axes: Axes, column: int, row: int, changed: bool) -> None:
    """Draw one setting of one run as a box."""
    axes.add_patch(
        plt.Rectangle(
            (column, row - 0.32),
            0.9,
            0.64,
            facecolor=CHANGED if changed else SAME,
            hatch="///" if changed else "",
            edgecolor="white" if changed else "#777777",
        )
    )

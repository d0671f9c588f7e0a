"""Panels that several figures share: learning curves and adaptation of stored runs, and one legend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import plotting
from .results import returns_by_step
from .runs import load_curve

GOALS_SHOWN = 20  # unseen tasks in a figure of paths


def training(stored: Mapping[str, Sequence[Path]], axes: Axes) -> None:
    """Draw learning curves, or say that there are none."""
    if not stored:
        none_stored(axes)
        return
    curves = {
        name: [load_curve(run / "curve.csv") for run in seeds] for name, seeds in stored.items()
    }
    plotting.learning_curves(curves, axes)


def adaptation(
    stored: Mapping[str, Sequence[Path]], axes: Axes, goal: str | None, earned: float
) -> None:
    """Draw returns on test tasks by adaptation step, and the demonstrator's return."""
    if not stored:
        return
    tested = {name: [returns_by_step(run, goal) for run in seeds] for name, seeds in stored.items()}
    plotting.adaptation_steps(tested, axes)
    axes.axhline(earned, color="#777777", linewidth=1.2, label="_demonstrator")


def none_stored(axes: Axes) -> None:
    axes.text(0.5, 0.5, "no stored runs", transform=axes.transAxes, ha="center")


def one_legend(figure: Figure, panels: Sequence[Axes]) -> None:
    """Put one legend of all algorithms above the figure in place of one in each panel."""
    named: dict[str, object] = {}
    for axes in panels:
        lines, labels = axes.get_legend_handles_labels()
        named |= dict(zip(labels, lines, strict=True))
        if axes.get_legend():
            axes.get_legend().remove()
    names = [plotting.label(name) for name in plotting.LOOKS if plotting.label(name) in named]
    figure.legend([named[name] for name in names], names, loc="outside upper center", ncols=5)

"""The figures of the studies: sensitivity (Fig. 7), ablation (Fig. 8), and the ledger's switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import plotting
from .intervals import worst_to_best
from .panels import none_stored
from .results import STEPS_SHOWN, run_scores
from .runs import load_curve
from .studies import ABLATION_END, SENSITIVITY_END, ablation_runs, sensitivity_runs, switch_runs


def sensitivity(folder: Path) -> Figure:
    """Draw EMRLD and EMRLD-WS with five values of w_rl (w_bc = 1) and of w_bc (w_rl = 1). Fig. 7."""
    figure, panels = plt.subplots(2, 2, figsize=(8.4, 5.8), sharex="row", sharey=True)
    for row, varied in zip(panels.T, ("w_rl", "w_bc"), strict=True):
        for axes, algorithm in zip(row, ("emrld", "emrld-ws"), strict=True):
            symbol, fixed = (f"$w_{{\\mathrm{{{part}}}}}$" for part in _pair(varied))
            stored = sensitivity_runs(folder, algorithm, varied)
            labels = {f"{symbol} = {value}": runs for value, runs in stored.items()}
            looks = dict(zip(labels, plotting.shades(algorithm, len(labels)), strict=True))
            _study(labels, looks, axes, SENSITIVITY_END[algorithm])
            axes.set_title(f"{plotting.label(algorithm)}, {fixed} = 1")
    for axes in panels[0]:
        axes.set_xlabel("")
    for axes in panels[:, 1]:
        axes.set_ylabel("")
    for axes in panels.flat:
        if axes.get_legend():
            axes.legend(loc="lower right", fontsize=8)  # where the curves have risen
    return figure


def _pair(varied: str) -> tuple[str, str]:
    """Return the subscript of the varied weight, then that of the fixed one."""
    return ("rl", "bc") if varied == "w_rl" else ("bc", "rl")


def ablation(folder: Path) -> Figure:
    """Draw EMRLD on Point2D, whole, without cloning and without RL in the adaptation. Fig. 8."""
    figure, panels = plt.subplots(1, 2, figsize=(8.4, 3.4), sharey=True)
    labels = {
        "EMRLD": "EMRLD",
        "w_bc = 0": r"no cloning, $w_{\mathrm{bc}} = 0$",
        "w_rl = 0": r"no RL, $w_{\mathrm{rl}} = 0$",
    }
    without = (("black", ":", "^"), ("#777777", "--", "D"))
    looks = [dict(zip(("color", "linestyle", "marker"), look, strict=True)) for look in without]
    looks = dict(zip(labels.values(), [plotting.LOOKS["emrld"], *looks], strict=True))
    for axes, quality in zip(panels, STEPS_SHOWN, strict=True):
        stored = {labels[name]: runs for name, runs in ablation_runs(folder, quality).items()}
        _study(stored, looks, axes, ABLATION_END)
        axes.set_title(f"Point2D, {quality} data")
    panels[1].set_ylabel("")
    return figure


def _study(
    stored: Mapping[str, Sequence[Path]],
    looks: Mapping[str, Mapping[str, object]],
    axes: Axes,
    end: int,
) -> None:
    """Draw the learning curves of one panel of a study up to iteration ``end``."""
    if not stored:
        none_stored(axes)
        return
    curves = {
        name: [load_curve(run / "curve.csv") for run in runs] for name, runs in stored.items()
    }
    plotting.banded_curves(curves, looks, axes, end)


def switches(folder: Path) -> Figure:
    """Draw what each switch of the ledger leaves of EMRLD-WS's return on unseen goals.

    A row per switch, the control first; one that is stored with a single seed has no interval, and is
    left out.
    """
    figure, axes = plt.subplots(figsize=(7.2, 4.6))
    stored = {name: seeds for name, seeds in switch_runs(folder).items() if len(seeds) > 1}
    if not stored:
        none_stored(axes)
        return figure
    scores = {name: run_scores(runs, step=1) for name, runs in stored.items()}
    rows = {name: (worst_to_best(seeds), seeds) for name, seeds in scores.items()}
    plotting.forest(rows, axes)
    axes.set_xlabel("return on unseen goals after one step")
    return figure

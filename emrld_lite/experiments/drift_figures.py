"""The figures of changing dynamics: Fig. 6 in simulation, and the four readings of its experiment."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ..demonstrators.recipes import unseen_demonstrations
from ..envs import make
from ..envs.two_wheeled_drift import ROBOT_DRIFT
from . import plotting
from .evaluation import evaluate_run
from .panels import GOALS_SHOWN, adaptation, none_stored, one_legend, training
from .results import EARNED, stored_seeds
from .runs import load_run
from .studies import READINGS

DRIFT = "two_wheeled_drift"


def drift(folder: Path, seed: int = 0) -> Figure:
    """Draw TwoWheeled with changing dynamics: training, unseen drifts, paths. Fig. 6, simulated part.

    The paths, a panel per algorithm, are three episodes of its run with ``seed``, after one adaptation
    step, in the unseen task nearest the drift of the paper's robot.
    """
    figure = plt.figure(figsize=(11.0, 6.2))
    names = list(plotting.LOOKS)
    grid = figure.add_gridspec(2, 2 * len(names), height_ratios=(3, 2))
    left, middle = (figure.add_subplot(grid[0, half]) for half in (slice(0, 5), slice(5, 10)))
    stored = stored_seeds(folder, DRIFT, "optimal")
    training(stored, left)
    adaptation(stored, middle, None, EARNED[DRIFT])
    unseen = unseen_demonstrations(DRIFT, "optimal", GOALS_SHOWN)
    shown_task = int((unseen.tasks - ROBOT_DRIFT).abs().argmin())
    for place, name in enumerate(names):
        axes = figure.add_subplot(grid[1, 2 * place : 2 * place + 2])
        make(DRIFT).draw_tasks(axes, unseen.tasks)
        axes.set(xlim=(-1.2, 2.6), ylim=(-2.6, 1.8), title=plotting.label(name))
        ylabel = f"drift {float(unseen.tasks[shown_task]):+.2f} rad/s\ny (length units)"
        axes.set(ylabel=ylabel if place == 0 else "")
        for run in stored.get(name, []):
            if run.name.endswith(f"-seed{seed}"):
                rollout = evaluate_run(load_run(run), unseen, 1).rollouts[-1]
                look = {"color": plotting.LOOKS[name]["color"], "linewidth": 1.4}
                plotting.trajectories(rollout, axes, shown_task, 3, **look)
    one_legend(figure, (left, middle))
    return figure


def readings(folder: Path) -> Figure:
    """Draw adaptation to unseen drifts for each reading of the experiment, a panel per reading.

    A column per reading of the drift, a row per state, with the heading and without; lines and bands as in
    Fig. 3, the grey line is what the demonstrations earn.
    """
    figure, panels = plt.subplots(2, 2, figsize=(8.6, 6.0), sharex=True, sharey=True)
    for axes, reading in zip(panels.flat, READINGS, strict=True):
        stored = stored_seeds(folder, reading.runs, "optimal")
        adaptation(stored, axes, None, EARNED[reading.env])
        axes.set_title(reading.title)
        if not stored:
            none_stored(axes)
    for axes in panels[0]:
        axes.set_xlabel("")
    for axes in panels[:, 1]:
        axes.set_ylabel("")
    one_legend(figure, panels.flat)
    return figure

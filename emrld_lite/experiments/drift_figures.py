"""The figures of changing dynamics: Fig. 6 in simulation, the four readings of it, drifts never met."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..demonstrations import load_demonstrations
from ..demonstrators.recipes import unseen_demonstrations
from ..envs import make
from ..envs.two_wheeled_drift import ROBOT_DRIFT
from . import plotting
from .evaluation import CUT, SAMPLED, evaluate_run
from .panels import GOALS_SHOWN, adaptation, none_stored, one_legend, training
from .results import EARNED, stored_seeds, task_scores
from .runs import load_run
from .studies import CUT_READINGS, NARROW_DRIFT, READINGS, Reading

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


def by_drift(folder: Path) -> Figure:
    """Draw the return after one step by the test drift, where training met all drifts and where few.

    A column per reading of the experiment. Above policies whose training drifts are spread as far as the
    test's, below ones whose training drifts are at most NARROW_DRIFT, the grey part. Bands reach from the
    lowest to the highest seed.
    """
    figure, panels = plt.subplots(2, len(READINGS), figsize=(13.0, 5.6), sharex="col", sharey=True)
    for column, reading in zip(panels.T, READINGS, strict=True):
        drifts = unseen_demonstrations(reading.env, "optimal", GOALS_SHOWN).tasks[:, 0].numpy()
        order = drifts.argsort()
        for axes, runs in zip(column, (reading.runs, reading.narrow), strict=True):
            stored = stored_seeds(folder, runs, "optimal")
            for name, seeds in stored.items():
                returns = task_scores(seeds, step=1)[:, order]  # (seed, drift)
                plotting.returns_against(drifts[order], name, returns, axes)
            if not stored:
                none_stored(axes)
    _spread_above_narrow(panels, READINGS)
    one_legend(figure, panels.flat)
    return figure


def _spread_above_narrow(panels: np.ndarray, readings: Sequence[Reading]) -> None:
    """Label panels with a column per reading: above trained on spread drifts, below on the grey ones."""
    for column, reading in zip(panels.T, readings, strict=True):
        column[0].set_title(reading.title)
        column[1].axvspan(-NARROW_DRIFT, NARROW_DRIFT, color="#999999", alpha=0.2, linewidth=0)
        column[1].set_xlabel(f"test drift ({make(reading.env).drift_unit})")
    for axes, trained in zip(panels[:, 0], ("all drifts", "narrow drifts"), strict=True):
        axes.set_ylabel(f"trained on {trained}\nmean return, one step")


def steering() -> Figure:
    """Draw the steering that the demonstrations of changing dynamics ask for, where the drift is a rate.

    Left step by step, in the training demonstrations of both ends and of the middle; right the largest of
    each training demonstration and of each of the test. The robot clips at 1: what is beyond, in grey, it
    does not do.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 3.6))
    data = load_demonstrations("optimal", DRIFT)
    unseen = unseen_demonstrations(DRIFT, "optimal", GOALS_SHOWN)
    looks = zip((0, len(data.tasks) // 2, -1), (":", "--", "-"), strict=True)
    for task, style in looks:
        asked = data.actions[task, 0, : int(data.lengths()[task]), 1]
        left.plot(asked, style, color="black", label=f"drift {float(data.tasks[task]):+.1f} rad/s")
    for shown, marker, label in ((data, "s", "training"), (unseen, "o", "test")):
        largest = shown.actions[:, 0, :, 1].abs().amax(-1)
        right.plot(shown.tasks[:, 0], largest, marker, color="black", fillstyle="none", label=label)
    for axes, ends in ((left, (1.0, -1.0)), (right, (1.0,))):
        for end in ends:
            axes.axhspan(end, 5.0 * end, color="#999999", alpha=0.2, linewidth=0)
        axes.legend()
    left.set(xlabel="step", ylabel="steering (1 is all it can)", ylim=(-5.0, 2.0))
    right.set(
        xlabel=f"drift ({make(DRIFT).drift_unit})", ylabel="largest steering", ylim=(0.0, 5.0)
    )
    return figure


def by_drift_and_steering(folder: Path) -> Figure:
    """Draw the return after one step by the test drift, the demonstrations' steering cut and as it is.

    A column per state, the drift a rate; above trained on drifts as wide as the test's, below on narrow
    ones, none of whose demonstrations steers so far that it could be cut. Lines with markers: cut in the
    training and in the test; thin ones: in neither. MAML reads none. Means over seeds.
    """
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 6.0), sharex=True, sharey=True)
    drifts = unseen_demonstrations(DRIFT, "optimal", GOALS_SHOWN).tasks[:, 0].numpy()
    order = drifts.argsort()

    def line(axes: Axes, runs: str, name: str, table: str, **look: object) -> None:
        for seeds in filter(None, [stored_seeds(folder, runs, "optimal").get(name)]):
            means = task_scores(seeds, 1, table=table).mean(0)
            axes.plot(drifts[order], means[order], **{**plotting.LOOKS[name], **look})

    for column, reading in zip(panels.T, CUT_READINGS, strict=True):
        # no steering within the narrow drifts is large enough to be cut: the same runs
        trainings = (reading.cut, reading.runs), (reading.narrow, reading.narrow)
        for axes, (cut, usual) in zip(column, trainings, strict=True):
            for name in ("emrld", "emrld-ws"):
                line(axes, cut, name, CUT, label=plotting.label(name))
                line(axes, usual, name, SAMPLED, linewidth=0.8, marker="")
            line(axes, usual, "maml", SAMPLED, label=plotting.label("maml"))
    _spread_above_narrow(panels, CUT_READINGS)
    one_legend(figure, panels.flat)
    return figure

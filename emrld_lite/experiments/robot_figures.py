"""Pictures of the robot study: the paths of Fig. 6, and how far adaptation carries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import torch
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..envs.two_wheeled_drift import ROBOT_DRIFT, TwoWheeledDrift
from ..validation import InputError
from . import plotting
from .results import stored_seeds
from .robot_driving import Adapted, Driven, adapt_on_robot, controller_on_robot
from .robot_study import AFTER, BEFORE, Row, controller_name
from .runs import load_run

NOBODY = {"color": "black", "linestyle": "-.", "linewidth": 1.2}  # the textbook controller's look
UNADAPTED = {"color": "#777777", "linestyle": ":", "linewidth": 1.2}
SHOWN = 3  # episodes of each panel of paths
SEED_SHOWN = 1  # EMRLD's seed 0 happens to lean the way of the paper's drift, and arrives unadapted
LABELS = {
    "drift": "drift of the robot (rad/s)",
    "delay": "delay of a command (s)",
    "friction": "sliding friction (log scale)",
    "odometry_turn": "deviation of the heading in 1 s (rad)",
    "odometry_slide": "deviation of a measured distance (share)",
}


class Sweep(NamedTuple):
    """Scores of some runs over the values of what was varied."""

    values: Float[np.ndarray, " value"]
    """In rising order; drifts as rad/s of the robot."""
    scores: Float[np.ndarray, "run value"]
    """Mean returns, or shares of the episodes."""


def sweep_of(
    rows: Sequence[Row], names: Sequence[str], varied: str, stage: str, score: str = "mean_return"
) -> Sweep:
    """Return the scores of runs in one sweep of the study; raises InputError where one was not driven.

    ``score`` is the column: the mean return, or the share that "reached" the goal, or "truly" did.
    """
    found: dict[str, dict[float, float]] = {name: {} for name in names}
    for row in rows:
        if row.run in found and (row.varied, row.stage) == (varied, stage):
            found[row.run][row.bias if varied == "drift" else row.value] = getattr(row, score)
    values = sorted({value for scores in found.values() for value in scores})
    if not values or any(set(scores) != set(values) for scores in found.values()):
        raise InputError(f"study: expected {varied}, {stage} of {list(names)}, got less")
    table = [[found[name][value] for value in values] for name in names]
    return Sweep(np.array(values), np.array(table))


def paper_robot(folder: Path, seed: int = SEED_SHOWN) -> Figure:
    """Let one stored run of each algorithm adapt on the robot under the paper's drift. Fig. 6, right part."""
    drifts = torch.tensor([[ROBOT_DRIFT]])
    found = {
        name: [run for run in seeds if run.name.endswith(f"-seed{seed}")]
        for name, seeds in stored_seeds(folder, TwoWheeledDrift.name, "optimal").items()
    }
    driven = {
        name: adapt_on_robot(load_run(seeds[0]), drifts) for name, seeds in found.items() if seeds
    }
    return robot_paths(driven, controller_on_robot(drifts))


def robot_paths(
    driven: Mapping[str, Adapted], controller: Driven | None = None, shown: int = SHOWN
) -> Figure:
    """Draw where the robot really went, a panel per algorithm: the meta-policy, and one step later. Fig. 6.

    ``driven`` holds one drift, by algorithm; a last panel shows the textbook ``controller``.
    """
    count = len(driven) + (controller is not None)
    figure, panels = plt.subplots(1, count, figsize=(2.3 * count, 3.1), sharey=True, squeeze=False)
    for axes, (name, adapted) in zip(panels[0], driven.items(), strict=False):
        before, after = adapted.before, adapted.after
        _paths(before, axes, shown, **UNADAPTED)
        _paths(after, axes, shown, color=plotting.LOOKS[name]["color"], linewidth=1.5)
        axes.set_title(f"{plotting.label(name)}\n{_reached(before)}, then {_reached(after)}")
    if controller is not None:
        _paths(controller, panels[0, -1], shown, **NOBODY)
        panels[0, -1].set_title(f"aim at the goal\n{_reached(controller)}")
    for axes in panels[0]:
        TwoWheeledDrift().draw_tasks(axes, torch.zeros(1, 1))
        axes.set(xlim=(-0.8, 2.7), ylim=(-1.6, 1.9), xlabel="x (m)", ylabel="y (m)")
        axes.title.set_fontsize(10)
        axes.label_outer()
    return figure


def _paths(driven: Driven, axes: Axes, shown: int, **look: object) -> None:
    """Draw the true ways of the first task's episodes, from the start on."""
    for episode in range(min(shown, driven.truth.shape[1])):
        steps = int(driven.rollout.mask[0, episode].sum())
        way = driven.truth[0, episode, :steps, :2]
        axes.plot([0.0, *way[:, 0].tolist()], [0.0, *way[:, 1].tolist()], **look)


def _reached(driven: Driven) -> str:
    """Return how many episodes of the first task ended at the goal."""
    return f"{int(driven.rollout.success[0].sum())}/{driven.rollout.success.shape[1]}"


def robot_sweeps(
    rows: Sequence[Row], runs: Mapping[str, Sequence[str]], world: TwoWheeledDrift
) -> Figure:
    """Draw what adaptation gains over the drift, a panel per algorithm, and what hardware it bears.

    ``runs`` names the seeds of each algorithm that is shown. Lines are means over seeds, bands reach from
    the lowest to the highest; the dash-dotted line is the textbook controller.
    """
    figure, panels = plt.subplots(2, 3, figsize=(11.0, 5.6), sharey=True)
    control = [controller_name(world)]
    for axes, (name, seeds) in zip(panels[0], runs.items(), strict=True):
        _line(axes, sweep_of(rows, seeds, "drift", BEFORE), label="before", **UNADAPTED)
        look = {**plotting.LOOKS[name], "label": "after one step"}
        _line(axes, sweep_of(rows, seeds, "drift", AFTER), **look)
        _line(axes, sweep_of(rows, control, "drift", BEFORE), label="aim at the goal", **NOBODY)
        axes.set(title=plotting.label(name), xlabel=LABELS["drift"])
    panels[0, -1].legend(loc="lower left", fontsize=8)
    for axes, varied in zip(panels[1], ("delay", "odometry_turn", "friction"), strict=True):
        for name, seeds in runs.items():
            look = {**plotting.LOOKS[name], "label": plotting.label(name)}
            _line(axes, sweep_of(rows, seeds, varied, AFTER), **look)
        _line(axes, sweep_of(rows, control, varied, BEFORE), label="aim at the goal", **NOBODY)
        axes.set(xlabel=LABELS[varied])
        if varied == "friction":
            axes.set_xscale("log")
            values = sweep_of(rows, control, varied, BEFORE).values
            axes.set_xticks(values, [f"{value:g}" for value in values])
            axes.minorticks_off()
    panels[1, 0].legend(loc="lower left", fontsize=8)
    for axes in panels[:, 0]:
        axes.set_ylabel("return")
    return figure


def _line(axes: Axes, sweep: Sweep, **look: object) -> None:
    """Draw the mean over seeds with the band from the lowest to the highest."""
    (line,) = axes.plot(sweep.values, sweep.scores.mean(0), **look)
    low, high = sweep.scores.min(0), sweep.scores.max(0)
    axes.fill_between(
        sweep.values, low, high, color=line.get_color(), alpha=plotting.BAND, linewidth=0
    )

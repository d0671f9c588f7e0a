"""A slider on the drift: the stored policies' paths before and after one adaptation step, by algorithm."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from ...demonstrators.recipes import demonstrate, load_or_train_expert
from ...envs import make
from ...envs.two_wheeled_drift import DRIFT_LIMIT
from ...experiments import plotting
from ...experiments.evaluation import evaluate_run
from ...experiments.results import stored_seeds
from ...experiments.runs import load_run
from ...experiments.studies import READINGS
from ...rollout import Rollout, episode_returns
from ...validation import InputError, real_number
from .answer import as_image

ENV, STEP, DRAWN = "two_wheeled_drift", 0.1, 4
BEFORE = "#777777"


class Driven(NamedTuple):
    """One algorithm's episodes on every drift, before and after one adaptation step."""

    before: Rollout
    after: Rollout


def drifts() -> torch.Tensor:
    """Return every drift of the slider, (drift, 1), radians per second."""
    count = round(2 * DRIFT_LIMIT / STEP) + 1
    return torch.linspace(-DRIFT_LIMIT, DRIFT_LIMIT, count)[:, None]


def drive(folder: Path, heading: bool = True, seed: int = 0) -> dict[str, Driven]:
    """Return what the stored run of each algorithm with ``seed`` does on every drift; takes seconds.

    Of the policies that see their heading, or of those that do not; InputError where there is none.
    """
    (reading,) = (r for r in READINGS if r.env == ENV and r.heading == heading)
    data = demonstrate(load_or_train_expert(ENV, "optimal"), ENV, drifts(), "optimal", seed=0)
    found = {}
    for name, seeds in stored_seeds(folder, reading.runs, "optimal").items():
        for run in seeds:
            if run.name.endswith(f"-seed{seed}"):
                found[name] = Driven(*evaluate_run(load_run(run), data, steps=1).rollouts)
    if not found:
        raise InputError(f"{folder}: expected runs of {reading.runs} with seed {seed}, got none")
    return found


def drift_picture(driven: Mapping[str, Driven], drift: float) -> Figure:
    """Return a panel per algorithm: its paths at one drift, before the step in grey, after it in colour."""
    real_number("drift", drift, -DRIFT_LIMIT, DRIFT_LIMIT)
    task = int((drifts()[:, 0] - drift).abs().argmin())
    # Few ticks and no layout engine: a label costs more time than a path.
    figure, panels = plt.subplots(
        1, len(driven), figsize=(9.8, 3.1), dpi=90, layout="none", squeeze=False
    )
    figure.subplots_adjust(left=0.055, right=0.995, bottom=0.17, top=0.8, wspace=0.09)
    for axes, (name, episodes) in zip(panels[0], driven.items(), strict=True):
        _draw(axes, task, name, episodes)
    for axes in panels[0][1:]:
        axes.set(xlabel="", ylabel="", yticklabels=[])
    figure.suptitle(f"drift {float(drifts()[task]):+.1f} rad/s", fontsize=11)
    plt.close(figure)
    return figure


def _draw(axes: Axes, task: int, name: str, episodes: Driven) -> None:
    """Draw the goal and a few paths of one algorithm."""
    make(ENV).draw_tasks(axes, drifts()[task : task + 1])
    look = plotting.LOOKS[name]
    axes.add_collection(_paths(episodes.before, task, colors=BEFORE, linestyles="--"))
    axes.add_collection(_paths(episodes.after, task, colors=look["color"], linewidths=1.5))
    for rollout, colour in ((episodes.before, BEFORE), (episodes.after, look["color"])):
        last = rollout.mask[task].sum(-1).long() - 1
        ends = rollout.states[task, torch.arange(len(last)), last][:DRAWN]
        axes.plot(ends[:, 0], ends[:, 1], look["marker"], color=colour, markersize=4)
    before, after = (float(episode_returns(part)[task].mean()) for part in episodes)
    axes.set(xlim=(-1.2, 2.7), ylim=(-2.6, 2.6), xticks=(0, 2), yticks=(-2, 0, 2))
    axes.set_title(f"{plotting.label(name)}\nreturn {before:.0f}, then {after:.0f}", fontsize=10)


def _paths(rollout: Rollout, task: int, **look: object) -> LineCollection:
    """Return the first episodes of one task as lines."""
    lengths = rollout.mask[task].sum(-1).long()
    lines = [rollout.states[task, n, : int(lengths[n]), :2].numpy() for n in range(DRAWN)]
    return LineCollection(lines, **look)


def drift_sliders(driven: Mapping[bool, Mapping[str, Driven]]) -> None:
    """Show a slider for the drift above the panels, and a switch that hides the heading.

    ``driven`` holds the episodes by whether the heading is seen.
    """

    def show(drift: float, heading: bool) -> None:
        display(as_image(drift_picture(driven[heading], drift)))

    slider = ipywidgets.FloatSlider(
        value=0.0, min=-DRIFT_LIMIT, max=DRIFT_LIMIT, step=STEP, continuous_update=False
    )
    switch = ipywidgets.ToggleButtons(options={"seen": True, "hidden": False}, value=True)
    ipywidgets.interact(show, drift=slider, heading=switch)

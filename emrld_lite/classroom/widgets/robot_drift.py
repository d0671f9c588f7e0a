"""A slider on the robot's drift: where a stored policy drives before and after one adaptation step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import PlaceHolderLayoutEngine

from ...envs.two_wheeled_drift import DRIFT_LIMIT, TwoWheeledDrift
from ...experiments import plotting
from ...experiments.robot_driving import Adapted, Driven, adapt_on_robot, controller_on_robot
from ...experiments.robot_figures import NOBODY, UNADAPTED
from ...experiments.runs import Run
from ...rollout import episode_returns
from ...validation import InputError
from .answer import as_image

DRIFTS = tuple(round(0.2 * step - DRIFT_LIMIT, 1) for step in range(9))  # rad/s
EPISODES = 2  # drawn of each kind


class Drives(NamedTuple):
    """Everything that the slider can show, driven beforehand; a task per drift."""

    adapted: dict[str, Adapted]
    """By algorithm."""
    controller: Driven


def drive_everywhere(runs: Mapping[str, Run], seed: int = 0) -> Drives:
    """Let each algorithm's policy drive under every drift, and adapt; a dozen seconds per policy."""
    drifts = torch.tensor(DRIFTS)[:, None]
    driven = {
        name: adapt_on_robot(run, drifts, episodes=EPISODES, seed=seed)
        for name, run in runs.items()
    }
    return Drives(driven, controller_on_robot(drifts, episodes=EPISODES, seed=seed))


def drift_sliders(drives: Drives) -> None:
    """Show a slider for the drift, and one panel per algorithm."""

    def show(drift: float) -> None:
        display(as_image(drift_picture(drives, drift)))

    ipywidgets.interact(
        show, drift=ipywidgets.SelectionSlider(options=DRIFTS, value=-0.6, continuous_update=False)
    )


def drift_picture(drives: Drives, drift: float) -> Figure:
    """Return the ways under one of DRIFTS: grey before adaptation, coloured after, dashed the controller."""
    if drift not in DRIFTS:
        raise InputError(f"drift: expected one of {DRIFTS}, got {drift}")
    task, count = DRIFTS.index(drift), len(drives.adapted)
    placed = PlaceHolderLayoutEngine(adjust_compatible=True, colorbar_gridspec=False)
    figure = plt.figure(figsize=(3.2 * count, 2.9), layout=placed)
    for place, (name, adapted) in enumerate(drives.adapted.items()):
        axes = figure.add_axes(((place + 0.16) / count, 0.15, 0.8 / count, 0.73))
        _draw(axes, drives.controller, task, **NOBODY)
        _draw(axes, adapted.before, task, **UNADAPTED)
        _draw(axes, adapted.after, task, color=plotting.LOOKS[name]["color"], linewidth=1.6)
        returns = [
            float(episode_returns(driven.rollout)[task].mean())
            for driven in (adapted.before, adapted.after)
        ]
        axes.set_title(f"{plotting.label(name)}: {returns[0]:.0f}, then {returns[1]:.0f}")
        TwoWheeledDrift().draw_tasks(axes, torch.zeros(1, 1))
        axes.set(xlim=(-1.0, 2.7), ylim=(-1.0, 1.9), xticks=(0, 2), yticks=(0, 1))
        axes.set(xlabel="x (m)", ylabel="y (m)" if place == 0 else "")
    plt.close(figure)
    return figure


def _draw(axes: Axes, driven: Driven, task: int, **look: object) -> None:
    """Draw the true ways of one task."""
    for episode in range(driven.truth.shape[1]):
        steps = int(driven.rollout.mask[task, episode].sum())
        way = driven.truth[task, episode, :steps, :2]
        axes.plot([0.0, *way[:, 0].tolist()], [0.0, *way[:, 1].tolist()], **look)

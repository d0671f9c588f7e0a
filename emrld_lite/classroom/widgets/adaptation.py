"""Sliders for the adaptation: the weights of its two losses, the task, and the warm start."""

from __future__ import annotations

import dataclasses

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from matplotlib.figure import Figure

from ...adapt import Adaptation, adapt, warm_start
from ...advantage import Score
from ...demonstrations import Demonstrations
from ...envs import Environment
from ...experiments import plotting
from ...policy import Params
from ...rollout import collect, episode_returns


def adaptation_slider(
    environment: Environment,
    meta_params: Params,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    task: int = 0,
    seed: int = 0,
) -> None:
    """Show sliders for w_rl, w_bc and the task, a box for the warm start, and the adapted policy's paths.

    Moving a slider repeats the adaptation with the same draws, so that only the slider matters.
    """

    def show(task: int, w_rl: float, w_bc: float, warm: bool) -> None:
        chosen = dataclasses.replace(adaptation, warm_start=warm)
        figure = adapted_paths(
            environment, meta_params, demonstrations, chosen, seed, task, w_rl, w_bc
        )
        display(figure)

    weight = {"min": 0.0, "max": 2.0, "step": 0.1, "continuous_update": False}
    ipywidgets.interact(
        show,
        task=ipywidgets.IntSlider(
            value=task, min=0, max=len(demonstrations.tasks) - 1, continuous_update=False
        ),
        w_rl=ipywidgets.FloatSlider(value=adaptation.w_rl, **weight),
        w_bc=ipywidgets.FloatSlider(value=adaptation.w_bc, **weight),
        warm=ipywidgets.Checkbox(value=adaptation.warm_start, description="warm start"),
    )


def adapted_paths(
    environment: Environment,
    meta_params: Params,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    seed: int,
    task: int,
    w_rl: float,
    w_bc: float,
) -> Figure:
    """Return a picture of one task: the episodes of D^tr, and those after adapting with the given weights."""
    random = torch.Generator().manual_seed(seed)
    one = demonstrations.take(slice(task, task + 1))
    start = warm_start(meta_params, one, adaptation)
    before = Score()(collect(environment, one.tasks, start, 20, random))
    after = before
    if w_rl or w_bc:
        chosen = dataclasses.replace(adaptation, w_rl=w_rl, w_bc=w_bc)
        task_params = adapt(meta_params, before, one, chosen)
        after = collect(environment, one.tasks, task_params, 20, random)
    figure, axes = plt.subplots(figsize=(5, 3.4))
    environment.draw_tasks(axes, one.tasks)
    plotting.trajectories(before, axes, color="#BBBBBB", linestyle=":")
    plotting.trajectories(after, axes)
    first = "warm start, " if adaptation.warm_start else ""
    weights = f"{first}w_rl = {w_rl:.1f}, w_bc = {w_bc:.1f}"
    axes.set_title(f"{weights}: return {episode_returns(after).mean():.1f}")
    plt.close(figure)
    return figure

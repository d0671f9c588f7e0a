"""Things that move on the page: a learning curve that fills in, and a slider for the adaptation."""

from __future__ import annotations

import dataclasses

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from matplotlib.figure import Figure

from ..adapt import Adaptation, adapt, warm_start
from ..advantage import Score
from ..demonstrations import Demonstrations
from ..envs import Environment
from ..experiments import plotting
from ..policy import Params
from ..rollout import collect, episode_returns
from ..train import Record


class LiveCurve:
    """A learning curve that is drawn again, in the same place, as records come in."""

    def __init__(self, algorithm: str, iterations: int, every: int = 5, target: float = 70.0):
        self.algorithm, self.iterations, self.every, self.target = (
            algorithm,
            iterations,
            every,
            target,
        )
        self.records: list[Record] = []
        self._handle = display(self._draw(), display_id=True)

    def add(self, record: Record) -> None:
        """Take one more record and draw anew every few of them."""
        self.records.append(record)
        if len(self.records) % self.every == 0:
            self._handle.update(self._draw())

    def finish(self) -> None:
        """Draw the curve as it stands."""
        self._handle.update(self._draw())

    def _draw(self) -> Figure:
        figure, axes = plt.subplots(figsize=(6, 3.2))
        axes.axhline(self.target, color="grey", linewidth=1, linestyle=(0, (1, 2)))
        if self.records:
            before = [record.return_before for record in self.records]
            axes.plot(before, color="grey", linewidth=1, label="before adaptation")
            plotting.learning_curves({self.algorithm: [self.records]}, axes)
        axes.set(xlim=(0, self.iterations), ylim=(-2, 85))
        axes.set(xlabel="meta-iteration", ylabel="mean return")
        plt.close(figure)
        return figure


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

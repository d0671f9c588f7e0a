"""Sliders for the adaptation: the weights of its two losses, the task, and the warm start."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import NamedTuple

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from ...adapt import Adaptation, adapt, warm_start
from ...advantage import Score
from ...demonstrations import Demonstrations
from ...envs import Environment
from ...experiments.plotting import LOOKS, demonstration
from ...policy import Params
from ...rollout import Rollout, collect, episode_returns
from .answer import as_image

EPISODES = 20  # per task, as in training
BEFORE = "#777777"  # colour of D^tr
LARGEST_WEIGHT = 2.0


class Weights(NamedTuple):
    """What the sliders say about one adaptation."""

    w_rl: float
    w_bc: float
    warm: bool


class Adapter:
    """Adapts one meta-policy to one task again and again; D^tr is collected once per task and start.

    Every draw is the same whatever the weights, so that only the weights matter.
    """

    def __init__(
        self,
        environment: Environment,
        meta_params: Params,
        demonstrations: Demonstrations,
        rule: Adaptation,
        seed: int = 0,
    ) -> None:
        self.environment, self.meta_params = environment, meta_params
        self.demonstrations, self.rule, self.seed = demonstrations, rule, seed
        self.before = functools.cache(self._before)

    def _before(self, task: int, warm: bool) -> tuple[Rollout, torch.Tensor]:
        """Return D^tr with its advantages, and the state of the generator after it."""
        random = torch.Generator().manual_seed(self.seed)
        one, rule = self.task(task), dataclasses.replace(self.rule, warm_start=warm)
        start = warm_start(self.meta_params, one, rule)
        collected = collect(self.environment, one.tasks, start, EPISODES, random)
        return Score()(collected), random.get_state()

    def task(self, task: int) -> Demonstrations:
        """Return the task's demonstration."""
        return self.demonstrations.take(slice(task, task + 1))

    def after(self, task: int, weights: Weights) -> Rollout:
        """Return the episodes after the adaptation; with both weights zero it is the start alone."""
        before, state = self.before(task, weights.warm)
        if not (weights.w_rl or weights.w_bc):
            return before
        rule = Adaptation(
            weights.w_rl,
            weights.w_bc,
            weights.warm,
            self.rule.adapt_lr,
            self.rule.bc_reduction,
            self.rule.log_density,
        )
        one, random = self.task(task), torch.Generator()
        random.set_state(state)
        adapted = adapt(self.meta_params, before, one, rule)
        return collect(self.environment, one.tasks, adapted, EPISODES, random)


def adaptation_sliders(adapter: Adapter, task: int = 0) -> ipywidgets.Widget:
    """Return sliders for the task and both weights, a box for the warm start, and the picture they make.

    The axes of a task are drawn once, and only what the weights change is drawn anew.
    """
    axes_of = functools.cache(functools.partial(_own_axes, adapter))
    drawn: dict[int, list[Artist]] = {}

    def show(task: int, w_rl: float, w_bc: float, warm: bool) -> None:
        axes = axes_of(task)
        for artist in drawn.pop(task, []):
            artist.remove()
        drawn[task] = _episodes(axes, adapter, task, Weights(w_rl, w_bc, warm))
        display(as_image(axes.figure))

    weight = {"min": 0.0, "max": LARGEST_WEIGHT, "step": 0.1, "continuous_update": False}
    last = len(adapter.demonstrations.tasks) - 1
    return ipywidgets.interactive(
        show,
        task=ipywidgets.IntSlider(value=task, min=0, max=last, continuous_update=False),
        w_rl=ipywidgets.FloatSlider(value=adapter.rule.w_rl, **weight),
        w_bc=ipywidgets.FloatSlider(value=adapter.rule.w_bc, **weight),
        warm=ipywidgets.Checkbox(value=adapter.rule.warm_start, description="warm start"),
    )


def adaptation_picture(adapter: Adapter, task: int, settings: Sequence[Weights]) -> Figure:
    """Return a panel per setting: the episodes of D^tr in grey, those after the step in colour."""
    columns = min(len(settings), 2)
    rows = -(-len(settings) // columns)
    figure, panels = plt.subplots(
        rows, columns, figsize=(4.6 * columns, 3.1 * rows), sharex=True, sharey=True, squeeze=False
    )
    for axes, weights in zip(panels.flat, settings, strict=False):
        _task(axes, adapter, task)
        _episodes(axes, adapter, task, weights)
        axes.label_outer()
    plt.close(figure)
    return figure


def _own_axes(adapter: Adapter, task: int) -> Axes:
    """Return axes with the task in a figure of their own, whose layout costs no time."""
    figure = Figure(figsize=(4.6, 3.1), dpi=90, layout="none")
    axes = figure.add_axes((0.13, 0.16, 0.84, 0.68))
    _task(axes, adapter, task)
    return axes


def _task(axes: Axes, adapter: Adapter, task: int) -> None:
    """Draw what no weight changes: the goal and the demonstration."""
    one = adapter.task(task)
    adapter.environment.draw_tasks(axes, one.tasks)
    demonstration(one.states[0, 0, : int(one.lengths()[0])], axes)


def _episodes(axes: Axes, adapter: Adapter, task: int, weights: Weights) -> list[Artist]:
    """Draw what one setting does to one task, and return what was drawn beside the title."""
    before, _ = adapter.before(task, weights.warm)
    after = adapter.after(task, weights)
    look = LOOKS["emrld-ws" if weights.warm else "emrld" if weights.w_bc else "maml"]
    ends = after.states[0, torch.arange(EPISODES), after.mask[0].sum(-1).long() - 1]
    marks = {"color": look["color"], "marker": look["marker"], "markersize": 4, "zorder": 4}
    (last,) = axes.plot(ends[:, 0], ends[:, 1], linestyle="none", alpha=0.8, **marks)
    axes.set_title(
        f"w_rl = {weights.w_rl:.1f}, w_bc = {weights.w_bc:.1f}, "
        f"{'warm start' if weights.warm else 'no warm start'}\n"
        f"mean return {episode_returns(before).mean():.0f} before the step, "
        f"{episode_returns(after).mean():.0f} after it",
        fontsize=10,
    )
    return [
        axes.add_collection(_paths(before, colors=BEFORE, linewidths=0.8)),
        axes.add_collection(_paths(after, colors=look["color"], linewidths=0.9, alpha=0.7)),
        last,
    ]


def _paths(rollout: Rollout, **look: object) -> LineCollection:
    """Return the episodes of a rollout of one task as lines."""
    lengths = rollout.mask[0].sum(-1).long()
    paths = [
        states[: int(length), :2].numpy()
        for states, length in zip(rollout.states[0], lengths, strict=True)
    ]
    return LineCollection(paths, **look)

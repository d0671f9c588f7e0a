"""Sliders for a demonstration's noise and cut: what the copy of it does then.

A copy takes longer to fit than a slider may take to answer, so all of them are fitted beforehand, together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import ipywidgets
import matplotlib.pyplot as plt
import torch
from IPython.display import display
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from torch import Tensor

from ...demonstrations import Demonstrations
from ...demonstrators import recipes
from ...demonstrators.cloning import clone
from ...envs import make
from ...experiments import plotting
from ...rollout import Rollout, collect, episode_returns
from ...validation import check_choice
from .answer import as_image

ENVIRONMENT = "two_wheeled"
NOISES = (0.0, 0.05, 0.1, 0.2, 0.3)  # of the action range
CUTS = (0, 1, 2, 4, 8)  # first steps removed
GOALS = (4, 9, 14, 19)  # of the 24 training tasks; a slider's picture shows the second
SHOWN = 1
EPISODES = 10
SHORT_OF_REWARD = 0.1  # every demonstration ends this far from the disc that pays


@dataclass(frozen=True)
class Copies:
    """Demonstrations of every noise, cut and goal, in this order, and episodes of their copies."""

    data: Demonstrations
    """One demonstration per copy."""
    rollout: Rollout
    """Ten episodes of each copy, acting with its own noise."""

    def place(self, noise: float, cut: int, goal: int = SHOWN) -> int:
        """Return where a copy stands; a noise or cut that was not fitted raises InputError."""
        check_choice("noise", f"{noise:g}", [f"{value:g}" for value in NOISES])
        check_choice("cut", str(cut), [str(value) for value in CUTS])
        return (NOISES.index(noise) * len(CUTS) + CUTS.index(cut)) * len(GOALS) + goal

    def returns(self) -> Float[Tensor, "noise cut"]:
        """Return the copies' mean returns over goals and episodes."""
        means = episode_returns(self.rollout).mean(-1)
        return means.reshape(len(NOISES), len(CUTS), len(GOALS)).mean(-1)


def copies_by_noise_and_cut(seed: int = 0) -> Copies:
    """Fit and play the copies of every noise, cut and goal: some seconds for a hundred of them."""
    expert = recipes.load_or_train_expert(ENVIRONMENT, "optimal")
    environment = make(ENVIRONMENT)
    tasks = environment.training_tasks()[list(GOALS)]
    parts = []
    for noise in NOISES:
        recipe = recipes.Recipe(action_noise=noise, short_of_reward=SHORT_OF_REWARD)
        whole = recipes.demonstrate(expert, ENVIRONMENT, tasks, "optimal", seed, recipe)
        parts += [_without_first(whole, cut) for cut in CUTS]
    data = _together(parts)
    draws = torch.Generator().manual_seed(seed)
    return Copies(data, collect(environment, data.tasks, clone(data, seed=seed), EPISODES, draws))


def _without_first(data: Demonstrations, cut: int) -> Demonstrations:
    """Return the demonstrations without their first steps."""
    states, actions, mask = (part[:, :, cut:] for part in (data.states, data.actions, data.mask))
    return replace(data, states=states, actions=actions, mask=mask)


def _together(parts: list[Demonstrations]) -> Demonstrations:
    """Return all demonstrations as one set, the shorter ones filled up with zeros."""
    longest = max(part.mask.shape[-1] for part in parts)

    def joined(name: str) -> Tensor:
        blocks = [getattr(part, name) for part in parts]
        whole = torch.zeros(sum(map(len, blocks)), 1, longest, *blocks[0].shape[3:])
        start = 0
        for block in blocks:
            whole[start : start + len(block), :, : block.shape[2]] = block
            start += len(block)
        return whole

    names = ("states", "actions", "mask")
    tasks = torch.cat([part.tasks for part in parts])
    return replace(parts[0], tasks=tasks, **{name: joined(name) for name in names})


def cloning_sliders(copies: Copies) -> None:
    """Show sliders for the noise of the demonstration and the steps that are cut from its beginning."""

    def show(noise: float, cut: int) -> None:
        display(as_image(cloning_picture(copies, noise, cut)))

    ipywidgets.interact(
        show,
        noise=ipywidgets.SelectionSlider(options=NOISES, value=0.0, continuous_update=False),
        cut=ipywidgets.SelectionSlider(options=CUTS, value=0, continuous_update=False),
    )


def cloning_picture(copies: Copies, noise: float, cut: int) -> Figure:
    """Return one demonstration with its copy's episodes, and the returns of all copies beside them."""
    place = copies.place(noise, cut)
    figure = plt.figure(
        figsize=(9, 3.4), layout="none"
    )  # fixed places: fitting them takes as long again
    plane = figure.add_axes((0.08, 0.16, 0.48, 0.74))
    table = figure.add_axes((0.65, 0.16, 0.33, 0.74))
    make(ENVIRONMENT).draw_tasks(plane, copies.data.tasks[place : place + 1])
    plotting.trajectories(copies.rollout, plane, task=place)
    known = copies.data.states[place, 0, : int(copies.data.lengths()[place])]
    plotting.demonstration(known, plane, marker="o", markersize=3, linewidth=1.0)
    mean = float(episode_returns(copies.rollout)[place].mean())
    plane.set_title(f"noise {noise:g}, first {cut} steps cut: return {mean:.1f}")
    _returns_table(copies, table, NOISES.index(noise), CUTS.index(cut))
    plt.close(figure)
    return figure


def _returns_table(copies: Copies, axes: Axes, row: int, column: int) -> None:
    """Draw the mean return of every noise and cut as a number on a shade, one of them framed."""
    returns = copies.returns()
    axes.imshow(returns.numpy(), cmap="Blues", vmin=0, vmax=100, aspect="auto")
    for i, j in torch.cartesian_prod(torch.arange(len(NOISES)), torch.arange(len(CUTS))).tolist():
        colour = "white" if returns[i, j] > 60 else "black"
        axes.text(j, i, f"{returns[i, j]:.0f}", ha="center", va="center", color=colour)
    frame = plt.Rectangle((column - 0.5, row - 0.5), 1, 1, fill=False, edgecolor="#D55E00", lw=3)
    axes.add_patch(frame)
    axes.set_xticks(range(len(CUTS)), CUTS)
    axes.set_yticks(range(len(NOISES)), NOISES)
    axes.grid(visible=False)
    axes.set(xlabel="first steps cut", ylabel="noise (of the action range)")
    axes.set_title("mean return of the copies, four goals", fontsize=10)

"""The house style, and what a figure is put together from; colour is never the only sign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import torch
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from ..algorithms import ALGORITHMS
from ..demonstrations import Demonstrations
from ..envs import Environment, make
from ..rollout import Rollout
from ..train import Record
from .intervals import Interval

# Okabe and Ito's colour-blind safe palette; one colour, line and marker per algorithm everywhere
LOOKS = {
    "emrld": {"color": "#0072B2", "linestyle": "-", "marker": "o"},
    "emrld-ws": {"color": "#D55E00", "linestyle": (0, (3, 1)), "marker": "s"},
    "maml": {"color": "#009E73", "linestyle": ":", "marker": "^"},
    "meta-bc": {"color": "#CC79A7", "linestyle": "-.", "marker": "D"},
    "gmps": {"color": "#56B4E9", "linestyle": (0, (10, 3)), "marker": "v"},
}
BAND = 0.18  # opacity of a band between seeds
EDGE = {"linewidth": 0.5, "alpha": 0.45}  # of the band's lowest and highest seed
DEMONSTRATION_COLOUR = "#333333"
STYLE = {
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "figure.constrained_layout.use": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "axes.titlesize": 11,
    "axes.labelsize": 10,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.8,
    "font.size": 10,
    "svg.hashsalt": "emrld",
}


def use_style() -> None:
    """Switch matplotlib to the workbook's style."""
    plt.rcParams.update(STYLE)


def label(algorithm: str) -> str:
    """Return an algorithm's name as figures print it."""
    return ALGORITHMS[algorithm].label


def learning_curves(curves: Mapping[str, Sequence[Sequence[Record]]], axes: Axes) -> None:
    """Draw the mean return after adaptation over seeds, with the band from lowest to highest seed.

    ``curves`` maps an algorithm to one sequence of records per seed. Fig. 3 and 4, top row.
    """
    looks = {label(name): LOOKS[name] for name in curves}
    banded_curves({label(name): seeds for name, seeds in curves.items()}, looks, axes)


def banded_curves(
    curves: Mapping[str, Sequence[Sequence[Record]]],
    looks: Mapping[str, Mapping[str, Any]],
    axes: Axes,
    end: int | None = None,
) -> None:
    """Draw learning curves by their labels, mean and lowest to highest seed, up to iteration ``end``."""
    lowest = 0.0
    for name, seeds in curves.items():
        shortest = min(len(seed) for seed in seeds)
        returns = np.array([[row.return_after for row in seed[:shortest]] for seed in seeds])[
            :, :end
        ]
        mean = returns.mean(0)
        lowest = min(lowest, 1.1 * float(mean.min()))
        axes.plot(mean, label=name, markevery=max(1, len(mean) // 8), **looks[name])
        _band(np.arange(len(mean)), returns, axes, looks[name]["color"])
    axes.set_xlabel("meta-iteration")
    axes.set_ylabel("mean return after adaptation")
    axes.set_ylim(bottom=min(-2.0, lowest))
    axes.legend(loc="best")


def _band(places: np.ndarray, returns: np.ndarray, axes: Axes, colour: Any) -> None:
    """Fill from the lowest to the highest seed of returns (seed, place), with thin edges."""
    if len(returns) > 1:
        low, high = returns.min(0), returns.max(0)
        axes.fill_between(places, low, high, color=colour, alpha=BAND, lw=0)
        for edge in (low, high):
            axes.plot(places, edge, color=colour, label="_edge of a band", **EDGE)


def shades(algorithm: str, count: int) -> list[dict[str, Any]]:
    """Return ``count`` looks in one algorithm's colour, from light to dark, each with its own line."""
    colour = np.array(to_rgb(LOOKS[algorithm]["color"]))
    lines = ((0, (1, 1)), (0, (3, 1, 1, 1)), (0, (3, 1)), (0, (6, 1)), "-")
    markers = ("v", "D", "^", "s", "o")
    strengths = np.linspace(0.5, 1.0, count)
    return [
        {"color": tuple(1 - strength * (1 - colour)), "linestyle": line, "marker": marker}
        for strength, line, marker in zip(strengths, lines, markers, strict=False)
    ]


def forest(rows: Mapping[str, tuple[Interval, Sequence[float]]], axes: Axes) -> None:
    """Draw an interval and its seeds per row, the first row's as a reference across the others."""
    reference = next(iter(rows.values()))[0]
    axes.axvspan(reference.low, reference.high, color="#999999", alpha=0.2, linewidth=0)
    for height, (interval, seeds) in enumerate(rows.values()):
        axes.plot([interval.low, interval.high], [height, height], color="#333333", linewidth=1.6)
        axes.plot(interval.estimate, height, marker="D", color="#333333", markersize=6)
        axes.plot(seeds, [height] * len(seeds), "o", color="#D55E00", markersize=4, alpha=0.8)
    axes.set_yticks(range(len(rows)), list(rows))
    axes.set_xlim(left=0.0)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)


def runs_and_mean(scores: Sequence[float], place: float, axes: Axes, **look: Any) -> None:
    """Draw each run's score at ``place`` as a marker of the given look, and their mean as a bar."""
    spread = place + 0.05 * np.linspace(-1, 1, len(scores))
    axes.plot(spread, scores, linestyle="none", markersize=4, alpha=0.8, **look)
    axes.plot([place - 0.13, place + 0.13], [np.mean(scores)] * 2, color="black", linewidth=2)


def divergence(
    curves: Mapping[str, Sequence[Sequence[Record]]], bound: float, axes: Axes, top: float = 1e6
) -> None:
    """Draw by how much each update moved the adapted policies, per algorithm and seed, in nats.

    On a logarithmic axis, with the trust region's ``bound`` as a line. What lies above ``top``, or is
    infinite, stands as a triangle on the upper edge.
    """
    for name, seeds in curves.items():
        look = {"color": LOOKS[name]["color"]}
        for number, seed in enumerate(seeds):
            moved = np.array([row.kl for row in seed])
            called = label(name) if number == 0 else "_another seed"
            marks = {"marker": LOOKS[name]["marker"], "markersize": 5, "markeredgecolor": "black"}
            marks["markevery"] = (7 * number, max(1, len(moved) // 6))
            axes.plot(
                np.minimum(moved, top), label=called, linewidth=0.8, alpha=0.8, **marks, **look
            )
            beyond = np.flatnonzero(moved > top)
            axes.plot(beyond, [top / 3] * len(beyond), "^", markersize=6, **look)
    axes.axhline(bound, color="black", linewidth=1.4)
    axes.set(yscale="log", ylim=(1e-5, top), xlabel="meta-iteration")
    axes.set_ylabel("KL of one update (nats)")
    axes.legend(loc="upper right")


def waits(rows: Mapping[str, Sequence[int | None]], budget: int, axes: Axes) -> None:
    """Draw how many iterations each training took, a row per kind, its median as a bar.

    None, a training that did not get there, is a cross behind the ``budget``.
    """
    beyond = 1.06 * budget
    for height, (name, taken) in enumerate(rows.items()):
        there = np.array([value for value in taken if value is not None], dtype=float)
        never = len(taken) - len(there)
        look = LOOKS[next((key for key in LOOKS if name.startswith(f"{label(key)} ")), "emrld-ws")]
        spread = height + 0.25 * np.linspace(-1, 1, max(len(there), 2))[: len(there)]
        axes.plot(
            there, spread, look["marker"], color=look["color"], markersize=4, alpha=0.75, zorder=3
        )
        late = height + 0.25 * np.linspace(-1, 1, max(never, 2))[:never]
        axes.plot([beyond] * never, late, "x", color="black", markersize=5)
        if never <= len(there):
            middle = np.sort([*there, *[beyond] * never])[(len(taken) - 1) // 2]
            axes.plot([middle] * 2, [height - 0.38, height + 0.38], color="black", linewidth=2)
    axes.set_yticks(range(len(rows)), list(rows))
    axes.set_xlim(0, 1.1 * budget)
    axes.set_xlabel("meta-iterations until the mean return is 70")
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)


def adaptation_steps(curves: Mapping[str, Sequence[Sequence[float]]], axes: Axes) -> None:
    """Draw mean returns on test tasks over adaptation steps, one sequence of returns per seed.

    Bands reach from the lowest to the highest seed. Fig. 3 and 4, bottom row.
    """
    for algorithm, seeds in curves.items():
        returns_against(np.arange(len(seeds[0])), algorithm, np.array(seeds), axes)
        axes.set_xticks(range(len(seeds[0])))
    axes.set_xlabel("adaptation steps")
    axes.set_ylabel("mean return, test tasks")
    axes.legend(loc="best")


def returns_against(places: np.ndarray, algorithm: str, returns: np.ndarray, axes: Axes) -> None:
    """Draw one algorithm's returns (seed, place) against the places, mean and lowest to highest seed."""
    axes.plot(places, returns.mean(0), label=label(algorithm), **LOOKS[algorithm])
    _band(places, returns, axes, LOOKS[algorithm]["color"])


def trajectories(
    rollout: Rollout, axes: Axes, task: int = 0, episodes: int = 10, **look: object
) -> None:
    """Draw the first ``episodes`` paths of one task, thin and see-through."""
    look = {"color": "#56B4E9", "linewidth": 0.9, "alpha": 0.7, **look}
    for episode in range(min(episodes, rollout.mask.shape[1])):
        length = int(rollout.mask[task, episode].sum())
        path = rollout.states[task, episode, :length]
        axes.plot(path[:, 0], path[:, 1], **look)


def demonstration(states: torch.Tensor, axes: Axes, **look: object) -> None:
    """Draw one demonstrated path, (time, 2)."""
    look = {"color": DEMONSTRATION_COLOUR, "linewidth": 1.6, "linestyle": "--", **look}
    axes.plot(states[:, 0], states[:, 1], **look)


def reward_landscape(environment: Environment, task: torch.Tensor, axes: Axes) -> None:
    """Draw the sparse reward of standing still at every place of a plane, for one task (task_dim,)."""
    side = torch.linspace(-2.5, 2.5, 251)
    y, x = torch.meshgrid(side, side, indexing="ij")
    states = torch.zeros(1, side.numel() ** 2, environment.state_dim)
    states[0, :, 0], states[0, :, 1] = x.flatten(), y.flatten()
    still = torch.tensor(environment.idle_action)
    moved = environment.step(task[None], states, still.expand(*states.shape[:2], 2), time=0)
    levels = [-0.01, 0.001, 0.5, 0.7, 0.9, 1.1, 100]
    shades = ("#FFFFFF", "#FDF1DC", "#F8D9A0", "#F3C164", "#E69F00", "#7A5C00")
    rewards = moved.rewards.reshape(251, 251)
    axes.contourf(x, y, rewards, levels=levels, colors=shades)
    axes.plot(0, 0, marker="x", color="black", markersize=7)
    axes.set_aspect("equal")
    axes.set_xlabel("x (length units)")
    axes.set_ylabel("y (length units)")


def all_demonstrations(data: Demonstrations, axes: Axes) -> None:
    """Draw every demonstration on the axes of its environment. Fig. 2, for every environment."""
    environment = make(data.environment)
    environment.draw_tasks(axes, data.tasks)
    for states, length in zip(data.states[:, 0], data.lengths(), strict=True):
        track = environment.track(states[:length])
        axes.plot(*track, color=DEMONSTRATION_COLOUR, linewidth=1.0)
        axes.plot(*track[:, -1], marker="o", markersize=3, color="black")

"""An experiment of the reader's own, on Point2D: its design, its live trainings, and their picture."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from .. import train
from ..config import TrainConfig
from ..demonstrations import load_demonstrations

HIGHER, LOWER, SAME = "higher", "lower", "no different"
EXAMPLE = {"switch": {"episodes": 5}, "expected": LOWER, "seeds": (0, 1, 2), "iterations": 20}
LAST = 5  # iterations over which the score of a short training is a mean


LONGEST = 240  # iterations of all trainings together: two minutes
NOT_SWITCHES = {
    "seed": "the seeds are drawn on both sides alike; they are no switch",
    "iterations": "both sides need the same number of iterations",
    "stop_at_return": "both sides need the same number of iterations",
    "algorithm": "another algorithm changes several things at once",
    "demos": "with sub-optimal data w_rl changes as well (Table 1), so two things would change",
    "env": "another environment is no setting of this one: nothing could be compared",
    "heading": "it has no effect on Point2D, whose state has none",
    "start": "it has no effect on Point2D: it is the cheetah's",
    "paid_side": "it has no effect on Point2D: it is the cheetah's",
    "meta_lr": "TRPO does not read it, and Adam makes no step here",
    "reward": "the returns of another reward cannot be compared with the control's",
}


def control_config(iterations: int, seed: int = 0) -> TrainConfig:
    """Return the control: EMRLD-WS on Point2D with optimal data, everything else by default."""
    return TrainConfig(algorithm="emrld-ws", iterations=iterations, seed=seed)


def live_curves(
    switch: Mapping[str, Any], seeds: Sequence[int], iterations: int
) -> Iterator[tuple[str, list[float]]]:
    """Yield, training by training, its side and its mean return after adaptation by iteration."""
    for seed in seeds:
        for side, changes in (("control", {}), ("switched", switch)):
            config = dataclasses.replace(control_config(iterations, int(seed)), **changes)
            data = load_demonstrations(config.demos, config.env)
            yield side, [one.record.return_after for one in train.meta_train(config, data)]


def draw_own_curves(curves: Mapping[str, np.ndarray]) -> Figure:
    """Return both sides' curves, thin for each seed and thick for the mean."""
    figure, axes = plt.subplots(figsize=(6.4, 3.2))
    looks = {"control": ("#D55E00", "-"), "switched": ("#333333", "--")}
    for name, (colour, line) in looks.items():
        for seed in curves[name]:
            axes.plot(seed, line, color=colour, linewidth=0.8, alpha=0.6)
        axes.plot(curves[name].mean(0), line, color=colour, linewidth=2.4, label=name)
    axes.set(xlabel="meta-iteration", ylabel="mean return after adaptation", ylim=(-2, 85))
    axes.legend(loc="upper left")
    return figure

"""Sliders on verdicts: the gap between two algorithms, the spread over seeds, and the number of seeds."""

from __future__ import annotations

import functools

import ipywidgets
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import display
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...experiments.intervals import (
    AHEAD,
    BEHIND,
    EVEN,
    Interval,
    rank_of_ends,
    shift_interval,
    verdict,
)
from ...validation import positive_count, real_number
from .answer import as_image

LARGEST_GAP, SPREADS, SEEDS = 10.0, (0.5, 8.0), (3, 20)
EXPERIMENTS = 2000
LOOKS = ((AHEAD, "#0072B2", ""), (EVEN, "#DDDDDD", ""), (BEHIND, "#D55E00", "///"))


@functools.cache
def _luck(seeds: int) -> np.ndarray:
    """Return standard normal scores of many experiments, (experiment, side, run)."""
    return np.random.default_rng(seeds).normal(size=(EXPERIMENTS, 2, seeds))


def verdict_shares(gap: float, spread: float, seeds: int) -> dict[str, float]:
    """Return how often the rank interval says ahead, not distinguishable and behind.

    The first side is better by ``gap``; ``spread`` is the standard deviation over seeds, on both sides.
    """
    real_number("gap", gap, 0.0, LARGEST_GAP)
    real_number("spread", spread, *SPREADS)
    positive_count("seeds", seeds, *SEEDS)
    luck, k = _luck(seeds), rank_of_ends(seeds, seeds)
    differences = luck[:, 0, :, None] - luck[:, 1, None, :] + gap / spread
    below = (differences < 0).sum((1, 2))  # the interval lies above zero where fewer than k are
    above = (differences > 0).sum((1, 2))
    ahead, behind = float((below < k).mean()), float((above < k).mean())
    return {AHEAD: ahead, EVEN: 1.0 - ahead - behind, BEHIND: behind}


def drawn_experiment(
    gap: float, spread: float, seeds: int, draw: int = 0
) -> tuple[np.ndarray, Interval]:
    """Return one experiment's scores, (side, run), and the interval of their difference."""
    scores = spread * _luck(seeds)[draw] + np.array([[gap], [0.0]])
    return scores, shift_interval(*scores)


def seeds_picture(gap: float = 3.0, spread: float = 3.0, seeds: int = 3, draw: int = 0) -> Figure:
    """Return how often each verdict falls, by the number of seeds (left), and one experiment (right)."""
    figure = plt.figure(figsize=(9.2, 3.7), layout="none")
    shares, one = (
        figure.add_axes(place) for place in ((0.07, 0.27, 0.5, 0.63), (0.7, 0.27, 0.28, 0.63))
    )
    _draw_shares(shares, gap, spread, seeds)
    _draw_experiment(one, gap, spread, seeds, draw)
    plt.close(figure)
    return figure


def _draw_shares(axes: Axes, gap: float, spread: float, seeds: int) -> None:
    """Draw a bar of three parts per number of seeds; a frame stands around the present one."""
    numbers = sorted({3, 4, 5, 6, 8, 10, 15, 20, seeds})
    every = [verdict_shares(gap, spread, number) for number in numbers]
    under = np.zeros(len(numbers))
    for name, colour, hatch in LOOKS:
        heights = np.array([100 * shares[name] for shares in every])
        axes.bar(
            range(len(numbers)),
            heights,
            bottom=under,
            color=colour,
            hatch=hatch,
            edgecolor="white",
            linewidth=0,
            label=name,
        )
        under += heights
    place = numbers.index(seeds)
    frame = {"fill": False, "edgecolor": "black", "linewidth": 2, "zorder": 4}
    axes.add_patch(plt.Rectangle((place - 0.45, 0), 0.9, 100, **frame))
    axes.set_xticks(range(len(numbers)), [str(number) for number in numbers])
    axes.set(
        xlabel="seeds of each side", ylabel="experiments (%)", ylim=(0, 101), yticks=(0, 50, 100)
    )
    axes.grid(visible=False)
    axes.set_title(
        f"gap {gap:.1f}, spread {spread:.1f}, {seeds} seeds: ahead in {100 * every[place][AHEAD]:.0f} %"
    )
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=3)


def _draw_experiment(axes: Axes, gap: float, spread: float, seeds: int, draw: int) -> None:
    """Draw one experiment's scores, and below them the interval of their difference."""
    scores, interval = drawn_experiment(gap, spread, seeds, draw)
    sides = (("first side", "o", "#0072B2", 2), ("second side", "s", "#D55E00", 1))
    for side, (_, marker, colour, height) in zip(scores, sides, strict=True):
        axes.plot(side, [height] * seeds, marker, color=colour, markersize=6, alpha=0.8)
    axes.plot([interval.low, interval.high], [0, 0], color="black", linewidth=2)
    axes.plot(interval.estimate, 0, "D", color="black", markersize=7)
    axes.axvline(0, color="#777777", linewidth=1)
    axes.set_yticks((2, 1, 0), ("first\nside", "second\nside", "differ-\nence"))
    reach = max(1.0, 1.1 * float(np.abs([*scores.ravel(), interval.low, interval.high]).max()))
    axes.set(ylim=(-0.6, 2.6), xlim=(-reach, reach), xlabel="return, above a common level")
    axes.locator_params(axis="x", nbins=5)
    axes.set_title(f"one experiment: {verdict(interval)}")


def seeds_sliders() -> None:
    """Show sliders for the gap, the spread, the number of seeds, and which experiment is drawn."""

    def show(gap: float, spread: float, seeds: int, draw: int) -> None:
        display(as_image(seeds_picture(gap, spread, seeds, draw)))

    later = {"continuous_update": False}
    ipywidgets.interact(
        show,
        gap=ipywidgets.FloatSlider(value=3.0, min=0.0, max=LARGEST_GAP, step=0.5, **later),
        spread=ipywidgets.FloatSlider(value=3.0, min=SPREADS[0], max=SPREADS[1], step=0.5, **later),
        seeds=ipywidgets.IntSlider(value=3, min=SEEDS[0], max=SEEDS[1], **later),
        draw=ipywidgets.IntSlider(value=0, min=0, max=49, description="experiment", **later),
    )

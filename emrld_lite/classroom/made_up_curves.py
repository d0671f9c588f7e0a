"""Four made-up trainings for an exercise in reading: their returns and KL, and what is true of them."""

from __future__ import annotations

from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from ..experiments.results import FLAT, LATE

ITERATIONS, BOUND, NAT = 150, 0.02, 1.0
FLAT_CURVE, CLIMBING = "flat", "climbing"
IN_BOUNDS, BROKE_DOWN = "in bounds", "broke down"


class Training(NamedTuple):
    """One made-up training: (iteration,) each, and the part of the axis that its panel shows."""

    returns: np.ndarray
    kl: np.ndarray
    axis: tuple[float, float]

    @property
    def rise(self) -> float:
        """Return by how much the last fifth lies above the fifth before, as a share of its level."""
        window = len(self.returns) // LATE
        last, before = self.returns[-window:].mean(), self.returns[-2 * window : -window].mean()
        return float((last - before) / last)

    @property
    def truth(self) -> tuple[str, str]:
        """Return whether the curve still climbs, and whether an update left all bounds."""
        return (
            CLIMBING if self.rise > FLAT else FLAT_CURVE,
            BROKE_DOWN if self.kl.max() > NAT else IN_BOUNDS,
        )


def trainings() -> dict[str, Training]:
    """Return the four trainings by their panels, the same ones each time."""
    random, time = np.random.default_rng(7), np.arange(ITERATIONS) / ITERATIONS

    def noise(size: float) -> np.ndarray:
        return size * random.normal(size=ITERATIONS)

    kept = [BOUND * random.uniform(0.6, 1.0, ITERATIONS) for _ in range(2)]
    wild = [np.exp(random.normal(-3, 1.5, ITERATIONS)) for _ in range(2)]
    for kl, places in zip(wild, ((60, 61, 97, 120), (35, 80, 81, 82, 140)), strict=True):
        kl[list(places)] = random.uniform(50, 5000, len(places))
    return {
        "A": Training(75.0 - 7.0 * np.exp(-2.2 * time) + noise(0.12), kept[0], (72.0, 74.6)),
        "B": Training(1.0 + 7.0 * time**2 + noise(0.35), kept[1], (0.0, 80.0)),
        "C": Training(22.0 * (1 - np.exp(-12 * time)) + noise(1.0), wild[0], (0.0, 40.0)),
        "D": Training(8.0 + 42.0 * time + noise(5.0), wild[1], (0.0, 80.0)),
    }


def curves_to_read() -> Figure:
    """Return the returns of the four trainings above, and below how far each update moved the policies."""
    figure, panels = plt.subplots(2, 4, figsize=(11.5, 4.6), sharex=True)
    for column, (name, training) in zip(panels.T, trainings().items(), strict=True):
        top, bottom = column
        top.plot(training.returns, color="black", linewidth=1.3)
        top.set(title=f"Training {name}", ylim=training.axis)
        bottom.plot(training.kl, color="#0072B2", linewidth=0.9)
        bottom.axhline(BOUND, color="black", linestyle="--", linewidth=1.2)
        bottom.set(yscale="log", ylim=(1e-4, 1e5), xlabel="meta-iteration")
        for place in (0.6, 0.8):
            top.axvline(place * ITERATIONS, color="#777777", linestyle=":", linewidth=1)
    panels[0, 0].set_ylabel("mean return")
    panels[1, 0].set_ylabel("KL of one update (nats)")
    return figure

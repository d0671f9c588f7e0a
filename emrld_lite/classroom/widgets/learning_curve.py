"""A learning curve that fills in while the algorithm trains."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import display
from matplotlib.figure import Figure

from ...algorithms import ALGORITHMS
from ...experiments import plotting, runs
from ...experiments.results import seeds_of
from ...train import Record

UNLABELLED = {"A": "emrld-ws", "B": "emrld"}


class LiveCurve:
    """A learning curve that is drawn again, in the same place, as records come in."""

    def __init__(self, algorithm: str, iterations: int, every: int = 5, target: float = 70.0):
        self.algorithm, self.iterations, self.every, self.target = (
            algorithm,
            iterations,
            every,
            target,
        )
        self.warm_start = ALGORITHMS[algorithm].warm_start
        self.after = f"{plotting.label(algorithm)} after the adaptation ($D^{{val}}$)"
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
            first = "after the warm start" if self.warm_start else "before the adaptation"
            axes.plot(before, color="#666666", linewidth=1.2, label=f"{first} ($D^{{tr}}$)")
            plotting.banded_curves(
                {self.after: [self.records]}, {self.after: plotting.LOOKS[self.algorithm]}, axes
            )
        axes.set(xlim=(0, self.iterations), ylim=(-2, 85))
        axes.set(xlabel="meta-iteration", ylabel="mean return, twelve training tasks")
        plt.close(figure)
        return figure


def unlabelled_panels() -> tuple[Figure, dict[str, float]]:
    """Return EMRLD's and EMRLD-WS's stored curves in panels A and B, and each panel's last grey return.

    Means over the seeds, before the adaptation step (grey, thin) and after it (black, thick); the grey
    return is the mean of the last ten iterations. The longer training is cut to the length of the
    other, which would give the answer away.
    """
    trainings = {}
    for panel, algorithm in UNLABELLED.items():
        found = seeds_of(runs.SHIPPED, f"point2d-optimal-{algorithm}")
        trainings[panel] = [runs.load_run(folder).curve for folder in found]
    shortest = min(len(curve) for curves in trainings.values() for curve in curves)
    figure, panels = plt.subplots(1, 2, figsize=(9, 3.2), sharey=True)
    last = {}
    for axes, (panel, curves) in zip(panels, trainings.items(), strict=True):
        before = np.mean([[row.return_before for row in c[:shortest]] for c in curves], 0)
        after = np.mean([[row.return_after for row in c[:shortest]] for c in curves], 0)
        axes.plot(after, color="black", label="after the adaptation step")
        axes.plot(before, color="#777777", linewidth=1, label="before it ($D^{tr}$)")
        axes.set(title=f"Panel {panel}", xlabel="meta-iteration", ylim=(-2, 85))
        last[panel] = float(before[-10:].mean())
    panels[0].set_ylabel("mean return, twelve training tasks")
    panels[0].legend(loc="lower right")
    plt.close(figure)
    return figure, last

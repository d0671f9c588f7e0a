"""A learning curve that fills in while the algorithm trains."""

from __future__ import annotations

import matplotlib.pyplot as plt
from IPython.display import display
from matplotlib.figure import Figure

from ...algorithms import ALGORITHMS
from ...experiments import plotting
from ...train import Record


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

"""Fig. 7 turned round: what a weight does to the end of a training, and to its speed, seed by seed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..experiments import plotting
from ..experiments.results import iterations_to, training_scores
from ..experiments.studies import SENSITIVITY_END, sensitivity_runs

HALFWAY = 35.0  # of a return of about 70
VARIED = {
    "w_rl": {"color": "#9A6A00", "marker": "o", "linestyle": "-"},
    "w_bc": {"color": "#333333", "marker": "s", "linestyle": "--"},
}
APART = {"w_rl": -0.015, "w_bc": 0.015}  # so that the points of both can be seen


def return_and_speed(folder: Path, algorithms: Sequence[str] = ("emrld", "emrld-ws")) -> Figure:
    """Return late return (left) and iterations to 35 (right) against each weight, a row per algorithm.

    Points are seeds, lines their means; a seed that does not reach 35 is a cross, and counts with all
    its iterations. The weight that is not varied is 1.
    """
    figure, panels = plt.subplots(
        len(algorithms), 2, figsize=(8.8, 5.0), sharex=True, squeeze=False
    )
    for (late, speed), algorithm in zip(panels, algorithms, strict=True):
        end = SENSITIVITY_END[algorithm]
        for varied in VARIED:
            runs = sensitivity_runs(folder, algorithm, varied)
            ends = {value: training_scores(seeds, end) for value, seeds in runs.items()}
            waits = {
                value: np.array([iterations_to(run, HALFWAY, end) or end + 1 for run in seeds])
                for value, seeds in runs.items()
            }
            _draw(late, ends, varied)
            _draw(speed, waits, varied, most=end)
        late.set(ylim=(0, 85), ylabel=f"{plotting.label(algorithm)}\nlate return")
        speed.set(ylim=(0, 1.03 * end), ylabel=f"iterations to {HALFWAY:g}")
    for axes in panels[-1]:
        axes.set(xlabel="weight (the other is 1)", xticks=(0.2, 0.4, 0.6, 0.8, 1.0))
    panels[0, 1].legend(loc="upper right")
    return figure


def _draw(axes: Axes, values: dict[float, np.ndarray], varied: str, most: float = np.inf) -> None:
    """Draw one number per seed against the weight, and the line of the means; a cross above ``most``."""
    look, symbol = VARIED[varied], f"$w_{{\\mathrm{{{varied[2:]}}}}}$ varied"
    points = {"linestyle": "none", "markersize": 4, "alpha": 0.6}
    crosses = {"linestyle": "none", "marker": "x", "markersize": 7, "alpha": 1.0}
    for value, seeds in values.items():
        for chosen, marks in ((seeds <= most, points), (seeds > most, crosses)):
            shown = np.minimum(seeds[chosen], most)
            axes.plot([value + APART[varied]] * len(shown), shown, **{**look, **marks})
    places = [value + APART[varied] for value in values]
    means = [np.minimum(seeds, most).mean() for seeds in values.values()]
    axes.plot(places, means, label=symbol, **look)

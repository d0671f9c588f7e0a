"""Pictures of Theorem 1: one look a quantity throughout, and colour never the only sign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from torch import Tensor

from .emrld import ExactIterate
from .families import Family
from .proof import ProofLine
from .theorem import as_dict, related_bounds, theorem_1

# Okabe and Ito's palette again, without the three colours that belong to algorithms
LOOKS = {
    "improvement": {"color": "black", "linestyle": "-", "linewidth": 2.4},
    "bound": {"color": "#CC79A7", "linestyle": "--", "marker": "o"},
    "bound_group_2": {"color": "#E69F00", "linestyle": "-.", "marker": "s"},
    "bound_average_delta": {"color": "#56B4E9", "linestyle": "-", "marker": "^"},
    "trust_region": {"color": "#777777", "linestyle": ":", "marker": "v"},
    "substituted": {"color": "#CC79A7", "linestyle": ":", "marker": "x"},
    "repaired": {"color": "#7A5C00", "linestyle": "--", "marker": "d"},
    "group_1": {"color": "#B0A0C8"},
    "group_2": {"color": "#E69F00"},
}
LABELS = {
    "improvement": "improvement",
    "bound": "Theorem 1 as printed",
    "bound_group_2": "second group alone",
    "bound_average_delta": "average Delta",
    "trust_region": "trust region (2017)",
    "substituted": "demonstrator's states",
    "repaired": "demonstrator's states, repaired",
    "group_1": "first group",
    "group_2": "second group",
}


def everything(family: Family) -> dict[str, Tensor]:
    """Return all parts and bounds of a family by name."""
    return as_dict(theorem_1(*family)) | as_dict(related_bounds(*family))


def against_improvement(improvement: Tensor, bound: Tensor, axes: Axes, name: str) -> None:
    """Draw families as points, improvement across and a bound upwards; above the line would be false."""
    look = LOOKS[name]
    axes.plot(
        improvement, bound, ".", color=look["color"], markersize=2, alpha=0.5, rasterized=True
    )
    reach = [-1e4, 1e4]
    axes.plot(reach, reach, color="black", linewidth=1)
    axes.set_xscale("symlog", linthresh=0.1)
    axes.set_yscale("symlog", linthresh=0.1)
    ticks = [-1e3, -10, -0.1, 0.1, 10, 1e3]
    axes.set(xlim=(-3e3, 3e3), ylim=(-3e5, 3e3), xticks=ticks, yticks=[-1e5, *ticks])
    axes.set(xlabel="improvement (return)", title=LABELS[name])


def along(
    families: Callable[[float], Family],
    values: np.ndarray,
    names: Sequence[str],
    axes: Axes,
    per_step: bool = False,
) -> dict[str, np.ndarray]:
    """Draw quantities of families(value) over ``values``, and return them by name.

    With ``per_step`` they are multiplied by 1 - gamma: the mean over a discounted step.
    """
    given = [families(float(value)) for value in values]
    scales = [float(1 - family[0][0].discount) if per_step else 1.0 for family in given]
    found = [everything(family) for family in given]
    curves = {
        name: np.array([scale * float(p[name]) for scale, p in zip(scales, found, strict=True)])
        for name in names
    }
    for name, curve in curves.items():
        spacing = max(1, len(values) // 8)
        axes.plot(values, curve, label=LABELS[name], markevery=spacing, **LOOKS[name])
    axes.set_ylabel("return per step" if per_step else "return")
    return curves


def slacks(lines: Sequence[ProofLine], axes: Axes) -> None:
    """Draw how far each line of the proof holds; a line that fails is a cross, left of zero."""
    for place, line in enumerate(lines):
        slack = float(line.slack.min())
        fine = line.holds()
        axes.plot(
            0.0 if fine and line.relation == "=" else slack,
            place,
            marker="o" if fine else "X",
            color="black" if fine else "#D55E00",
            markersize=6 if fine else 10,
        )
    axes.axvline(0, color="black", linewidth=0.8)
    axes.set_xscale("symlog", linthresh=0.01)
    axes.set(xlim=(-10, 10), xlabel="slack, relative to the sides", ylim=(len(lines) - 0.5, -0.5))
    ticks = [-1, -0.1, 0, 0.1, 1]
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.set_yticks(range(len(lines)), [f"{line.name}  ({line.relation})" for line in lines])


def exact_training(
    runs: Mapping[str, Sequence[ExactIterate]],
    looks: Mapping[str, dict],
    value: Callable[[ExactIterate], float],
    axes: Axes,
) -> None:
    """Draw one number of every iterate over meta-iterations, one curve per run."""
    for name, iterates in runs.items():
        curve = [float(value(iterate)) for iterate in iterates]
        spacing = max(1, len(curve) // 8)
        axes.plot(curve, label=name, markevery=spacing, **looks[name])
    axes.set_xlabel("meta-iteration")

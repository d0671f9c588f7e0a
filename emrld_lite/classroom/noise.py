"""The variance experiment of notebook 01, for readers whose own is not right yet, and its picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import matplotlib.pyplot as plt
import torch
from jaxtyping import Float
from matplotlib.figure import Figure
from torch import Tensor

Estimates = Float[Tensor, "batch parameter"]


def compare_baselines(
    draw: Callable[[], Any],
    estimate: Callable[[Any, Tensor], Float[Tensor, " parameter"]],
    baselines: Mapping[str, Callable[[Any], Tensor]],
    batches: int,
) -> dict[str, tuple[Estimates, float]]:
    """Return each baseline's gradient estimates on the same batches, and their noise.

    The noise is the root of their mean squared distance from their own mean.
    """
    seen = [draw() for _ in range(batches)]
    found = {}
    for name, baseline in baselines.items():
        estimates = torch.stack([estimate(batch, baseline(batch)) for batch in seen])
        found[name] = (estimates, noise(estimates))
    return found


def noise(estimates: Estimates) -> float:
    """Return the root of the estimates' mean squared distance from their mean."""
    return float((estimates - estimates.mean(0)).square().sum(1).mean().sqrt())


def clouds(found: Mapping[str, tuple[Estimates, float]]) -> Figure:
    """Return the estimates in one plane, a panel per baseline: along their mean, and across it.

    Across is the direction in which the first baseline's estimates scatter most.
    """
    every = {name: torch.as_tensor(estimates).float() for name, (estimates, _) in found.items()}
    first, *_, last = every.values()
    along = last.mean(0) / last.mean(0).norm()
    centred = first - first.mean(0)
    centred = centred - (centred @ along)[:, None] * along
    across = torch.linalg.svd(centred, full_matrices=False).Vh[0]
    plane = torch.stack([along, across])  # (2, parameter)
    figure, panels = plt.subplots(1, len(every), figsize=(8.4, 3.0), sharex=True, sharey=True)
    for axes, (name, estimates) in zip(panels, every.items(), strict=True):
        axes.scatter(*(estimates @ plane.T).T, s=16, color="#0072B2", alpha=0.8)
        axes.plot(*(plane @ estimates.mean(0)), marker="+", color="black", markersize=13)
        axes.annotate("", tuple(plane @ last.mean(0)), (0, 0), arrowprops={"arrowstyle": "->"})
        axes.set(
            title=f"{name}: noise {float(found[name][1]):.2f}", xlabel="along the mean gradient"
        )
    panels[0].set_ylabel("across it")
    return figure

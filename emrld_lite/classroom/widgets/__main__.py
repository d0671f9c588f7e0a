"""How fast the sliders answer: ``python -m emrld_lite.classroom.widgets`` prints a line for each.

Times are from the move of a slider to the picture as PNG, on one thread, over the controls' whole range.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import torch
from matplotlib.figure import Figure

from ...advantage import generalised_advantage
from ...algorithms import ALGORITHMS
from ...demonstrations import load_demonstrations
from ...envs import make
from ...experiments import plotting, runs
from ...experiments.results import stored_seeds
from ...policy import initialise
from . import (
    adaptation,
    bounds,
    cloning,
    drift,
    exploration,
    gae,
    one_step,
    robot_drift,
    seeds,
    sparsity,
    swamp,
)
from .answer import as_image

Move = Callable[[], Figure]


def moves() -> Iterator[tuple[str, Iterable[Move]]]:
    """Yield every widget by name, with its pictures from one end of its controls to the other."""
    params = initialise(2, 2, seed=0)
    spread = exploration.measured_spread(params)
    sigmas = np.geomspace(exploration.SMALLEST, exploration.LARGEST, 9)
    yield (
        "01 sigma",
        [lambda s=s: exploration.exploration_picture(params, spread, s) for s in sigmas],
    )
    found = gae.advantage_differences(params, generalised_advantage)
    lambdas = gae.LAMBDAS[::3]
    yield "01 lambda", [lambda x=x: gae.gae_picture(found, x) for x in lambdas]
    walks, radii = sparsity.random_walks(), np.linspace(*sparsity.RADII, 9)
    yield "02 goal and radius", [lambda r=r: sparsity.sparsity_picture(walks, 60, r) for r in radii]
    copies = cloning.copies_by_noise_and_cut()
    cuts = [(noise, cut) for noise in cloning.NOISES[::4] for cut in cloning.CUTS[::3]]
    yield "03 noise and cut", [lambda c=c: cloning.cloning_picture(copies, *c) for c in cuts]
    yield "04 bounds", [lambda s=s: bounds.bound_picture(s) for s in np.linspace(0, 1, 9)]
    amounts = np.linspace(0, 1, 9)
    yield "04 assumptions", [lambda a=a: bounds.assumption_picture(amount=a) for a in amounts]
    slips = np.linspace(0.0, 0.25, 9)
    yield "04 swamp", [lambda s=s: swamp.swamp_picture(slip=s) for s in slips]
    alphas = np.linspace(0.0, one_step.LARGEST_ALPHA, 9)
    yield "05 alpha", [lambda a=a: one_step.one_step_picture(a) for a in alphas]
    yield "06 weights", adaptations()
    numbers = range(seeds.SEEDS[0], seeds.SEEDS[1] + 1, 2)
    yield "07 seeds", [lambda n=n: seeds.seeds_picture(3.0, 3.0, n) for n in numbers]
    driven, drifts = (
        drift.drive(runs.SHIPPED),
        np.linspace(-drift.DRIFT_LIMIT, drift.DRIFT_LIMIT, 9),
    )
    yield "07 drift", [lambda d=d: drift.drift_picture(driven, d) for d in drifts]
    stored = stored_seeds(runs.SHIPPED, "two_wheeled_drift", "optimal")
    found = {name: runs.load_run(stored[name][0]) for name in ("emrld", "emrld-ws", "maml")}
    robots = robot_drift.drive_everywhere(found)
    yield "09 drift", [lambda d=d: robot_drift.drift_picture(robots, d) for d in robot_drift.DRIFTS]


def adaptations() -> list[Move]:
    """Return the pictures of the weights' sliders, for a stored policy."""
    stored = runs.load_run(runs.SHIPPED / "point2d-optimal-emrld-ws-seed0")
    rule = ALGORITHMS["emrld-ws"].adaptation("optimal")
    adapter = adaptation.Adapter(
        make("point2d"), stored.meta_params, load_demonstrations("optimal", "point2d"), rule
    )
    weights = [adaptation.Weights(0.2, w_bc, w_bc < 1.5) for w_bc in np.linspace(0, 2, 9)]
    return [lambda w=w: adaptation.adaptation_picture(adapter, 2, [w]) for w in weights]


def seconds(move: Move) -> float:
    """Return how long one picture takes, drawn and written."""
    started = time.perf_counter()
    as_image(move())
    return time.perf_counter() - started


def main() -> None:
    """Print the median and the slowest answer of every widget, milliseconds."""
    torch.set_num_threads(1)
    plotting.use_style()
    for name, pictures in moves():
        _, *times = [1000 * seconds(move) for move in pictures]  # the first loads fonts and caches
        print(f"{name:20} median {np.median(times):5.0f} ms, slowest {max(times):5.0f} ms")


if __name__ == "__main__":
    main()

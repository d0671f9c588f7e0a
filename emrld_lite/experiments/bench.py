"""What a meta-iteration costs: seconds by part, steps per second, memory, growth with the tasks.

Everything is measured from outside: whole iterations by the clock, their parts by Python's profiler in
iterations of their own, because it slows the code a little.
"""

from __future__ import annotations

import cProfile
import pstats
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import torch

from ..config import AlgorithmName, TrainConfig
from ..demonstrations import load_demonstrations
from ..demonstrators.recipes import unseen_demonstrations
from ..envs import ENVIRONMENTS, make
from ..rollout import collect
from ..train import Iterate, meta_train
from ..trpo import conjugate_gradient, fisher_product, line_search

try:
    import resource
except ImportError:  # Windows has no such module
    resource = None

PARTS: dict[str, tuple[Callable[..., Any], ...]] = {  # what counts to which part
    "rollout": (collect,),
    "Fisher and CG": (fisher_product, conjugate_gradient),
    "line search": (line_search,),
}
REST = "adaptation and gradient"


class Cost(NamedTuple):
    """Cost of one meta-iteration: medians over iterations, and the peak memory so far."""

    tasks: int
    seconds: float
    fastest: float
    slowest: float
    parts: dict[str, float]
    steps_per_second: float
    peak_megabytes: float | None


def measure(tasks: int, iterations: int, seed: int = 0, env: str = "point2d") -> Cost:
    """Time the first meta-iterations of EMRLD-WS from an untrained policy.

    Its episodes run their full 100 steps; the dense reward makes every part of the update work.
    """
    config = TrainConfig(
        env=env, algorithm="emrld-ws", seed=seed, reward="dense", iterations=2 * iterations + 1
    )
    loop = meta_train(config, unseen_demonstrations(env, "optimal", tasks, seed))
    next(loop)  # the first one warms up
    whole, iterates = zip(*(timed(loop) for _ in range(iterations)), strict=True)
    parts = profiled(loop)
    seconds = statistics.median(whole)
    rollout = seconds * parts["rollout"]
    return Cost(
        tasks=tasks,
        seconds=seconds,
        fastest=min(whole),
        slowest=max(whole),
        parts={part: seconds * share for part, share in parts.items()},
        steps_per_second=steps_of(iterates[-1]) / rollout,
        peak_megabytes=peak_megabytes(),
    )


def timed(loop: Iterator[Iterate]) -> tuple[float, Iterate]:
    """Return the seconds of the next iteration, and what it left behind."""
    began = time.perf_counter()
    iterate = next(loop)
    if torch.cuda.is_initialized():
        torch.cuda.synchronize()
    return time.perf_counter() - began, iterate


def steps_of(iterate: Iterate) -> float:
    """Return the steps taken in an iteration."""
    return float(iterate.before.mask.sum() + iterate.after.mask.sum())


def profiled(loop: Iterator[Iterate]) -> dict[str, float]:
    """Return the share of each part in the iterations that are left, by Python's profiler."""
    with cProfile.Profile() as profiler:
        began = time.perf_counter()
        for _ in loop:
            pass
        whole = time.perf_counter() - began
    spent = {place: row[3] for place, row in pstats.Stats(profiler).stats.items()}  # cumulative

    def seconds(function: Callable[..., Any]) -> float:
        code = getattr(function, "__wrapped__", function).__code__
        return spent.get((code.co_filename, code.co_firstlineno, code.co_name), 0.0)

    shares = {part: sum(map(seconds, functions)) / whole for part, functions in PARTS.items()}
    return {**shares, REST: 1.0 - sum(shares.values())}


def peak_megabytes() -> float | None:
    """Return the process's peak resident memory in MB (10^6 bytes); None where the system won't say."""
    if resource is None:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6


def report(iterations: int, tasks: tuple[int, ...]) -> None:
    """Print the costs of each environment at its training size, then Point2D's for numbers of tasks."""
    print(f"EMRLD-WS, {torch.get_num_threads()} threads, {iterations} iterations per row; medians;")
    print("20 episodes of 100 steps per task, before and again after adaptation\n")
    parts = (*PARTS, REST)
    heads = ("environment", "tasks", "seconds", "(range)", *parts, "steps/s", "peak MB", "s/task")
    print("  ".join(f"{head:>{max(9, len(head))}}" for head in heads))
    sizes = [(env, len(make(env).training_tasks())) for env in ENVIRONMENTS]
    grown = [("point2d", count) for count in sorted(tasks)]
    for env, count in sizes + grown:
        cost = measure(count, iterations, env=env)
        peak = "unknown" if cost.peak_megabytes is None else f"{cost.peak_megabytes:.0f}"
        cells = (
            env.replace("two_wheeled", "2wheeled"),
            str(count),
            f"{cost.seconds:.3f}",
            f"{cost.fastest:.2f}-{cost.slowest:.2f}",
            *(f"{cost.parts[part]:.3f}" for part in parts),
            f"{cost.steps_per_second:.0f}",
            peak,
            f"{cost.seconds / count:.4f}",
        )
        print(
            "  ".join(f"{c:>{max(9, len(h))}}" for c, h in zip(cells, heads, strict=True)),
            flush=True,
        )


def walk(algorithm: AlgorithmName = "emrld-ws") -> list[str]:
    """Return the package's functions that one meta-iteration calls, in call order, with file and line."""
    config = TrainConfig(algorithm=algorithm, iterations=2, episodes=2)
    loop = meta_train(config, load_demonstrations(config.demos, config.env))
    next(loop)
    package = Path(__file__).resolve().parent.parent
    met: dict[str, None] = {}  # in order, each once

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event == "call" and package in Path(code.co_filename).parents:
            place = f"{Path(code.co_filename).relative_to(package)}:{code.co_firstlineno}"
            if not code.co_name.startswith("<"):
                met[f"{code.co_qualname}  {place}"] = None

    sys.setprofile(note)
    try:
        next(loop)
    finally:
        sys.setprofile(None)
    return list(met)

"""What a meta-iteration costs: seconds by part, steps a second, memory, growth with the tasks."""

from __future__ import annotations

import statistics
import sys
import time
from typing import NamedTuple

import mujoco
import numpy as np
import torch

from . import timing
from .config import TrainConfig
from .demonstrator import demonstrate, load_or_train_expert
from .envs import make
from .envs.cheetah_body import cheetah_model
from .envs.half_cheetah import FRAME_SKIP
from .policy import initialise
from .train import iteration_generator, meta_iteration

try:
    import resource
except ImportError:  # Windows has no such module
    resource = None

PARTS = ("rollout", "adaptation and gradient", "Fisher and CG", "line search")


class Cost(NamedTuple):
    """Cost of one meta-iteration: medians over iterations, and the peak memory so far."""

    tasks: int
    seconds: float
    fastest: float
    slowest: float
    parts: dict[str, float]
    steps_per_second: float
    peak_megabytes: float | None


def measure(tasks: int, iterations: int, seed: int = 0) -> Cost:
    """Time meta-iterations of EMRLD-WS on Point2D from an untrained policy.

    Episodes run their full 100 steps there; the dense reward makes every part of the update work.
    """
    config = TrainConfig(algorithm="emrld-ws", seed=seed)
    environment = make("point2d", reward="dense")
    goals = environment.sample_tasks(tasks, np.random.default_rng(seed))
    demonstrations = demonstrate(
        load_or_train_expert("point2d", "optimal"), "point2d", goals, "optimal", seed
    )
    start = initialise(environment.state_dim, environment.action_dim, seed)
    whole, parts, steps = [], [], 0.0
    for iteration in range(iterations + 1):
        timing.seconds.clear()
        began = time.perf_counter()
        _, _, before, after, _ = meta_iteration(
            start,
            None,
            environment,
            demonstrations,
            config.adaptation("optimal"),
            config,
            iteration_generator(seed, iteration),
        )
        if iteration > 0:  # the first one warms up
            whole.append(time.perf_counter() - began)
            parts.append({part: timing.seconds[part] for part in PARTS})
            steps = float(before.mask.sum() + after.mask.sum())
    medians = {part: statistics.median(row[part] for row in parts) for part in PARTS}
    return Cost(
        tasks=tasks,
        seconds=statistics.median(whole),
        fastest=min(whole),
        slowest=max(whole),
        parts=medians,
        steps_per_second=steps / medians["rollout"],
        peak_megabytes=peak_megabytes(),
    )


def peak_megabytes() -> float | None:
    """Return the process's peak resident memory in MB (10^6 bytes); None where the system won't say."""
    if resource is None:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6


def report(iterations: int, tasks: tuple[int, ...]) -> None:
    """Print the costs for each number of tasks, in growing order."""
    print(f"EMRLD-WS on Point2D, {torch.get_num_threads()} threads, {iterations} iterations a row;")
    print("medians; 20 episodes of 100 steps a task, before and again after adaptation\n")
    heads = ("tasks", "seconds", "(range)", *PARTS, "steps/s", "peak MB", "s/task")
    print("  ".join(f"{head:>{max(9, len(head))}}" for head in heads))
    for count in sorted(tasks):
        cost = measure(count, iterations)
        peak = "unknown" if cost.peak_megabytes is None else f"{cost.peak_megabytes:.0f}"
        cells = (
            str(count),
            f"{cost.seconds:.3f}",
            f"{cost.fastest:.2f}-{cost.slowest:.2f}",
            *(f"{cost.parts[part]:.3f}" for part in PARTS),
            f"{cost.steps_per_second:.0f}",
            peak,
            f"{cost.seconds / count:.4f}",
        )
        print(
            "  ".join(f"{c:>{max(9, len(h))}}" for c, h in zip(cells, heads, strict=True)),
            flush=True,
        )


class SteppingRate(NamedTuple):
    """Control steps a second of HalfCheetah: through our environment, and of bare ``mj_step``."""

    ours: float
    bare: float


def cheetah_rate(episodes: int = 200, seed: int = 0) -> SteppingRate:
    """Step the same random controls through the environment (one thread) and through bare MuJoCo."""
    environment = make("half_cheetah", threads=1)
    random = np.random.default_rng(seed)
    shape = (environment.horizon, 1, episodes, environment.action_dim)
    controls = random.uniform(-1.0, 1.0, shape).astype(np.float32)  # (time, task, episode, action)
    tasks = environment.training_tasks()[:1]
    states = environment.reset(tasks, episodes)
    began = time.perf_counter()
    with torch.inference_mode():
        for step, actions in enumerate(controls):
            states = environment.step(tasks, states, torch.from_numpy(actions), step).states
    ours = time.perf_counter() - began
    model = cheetah_model()
    bare = 0.0
    for episode in range(episodes):
        data = mujoco.MjData(model)
        began = time.perf_counter()
        for actions in controls[:, 0, episode]:
            data.ctrl[:] = actions
            mujoco.mj_step(model, data, nstep=FRAME_SKIP)
        bare += time.perf_counter() - began
    steps = episodes * environment.horizon
    return SteppingRate(steps / ours, steps / bare)


def report_cheetah(repeats: int = 5) -> None:
    """Print the environment's stepping rate against bare MuJoCo's, measured in turn."""
    rates = [cheetah_rate(seed=repeat) for repeat in range(repeats)]
    shares = sorted(rate.ours / rate.bare for rate in rates)
    print(
        f"half_cheetah, one thread: {statistics.median(rate.ours for rate in rates):,.0f} control "
        f"steps/s, {statistics.median(shares):.0%} of bare mj_step's rate "
        f"({shares[0]:.0%} to {shares[-1]:.0%} over {repeats} runs)"
    )

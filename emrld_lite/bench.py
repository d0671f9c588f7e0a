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
from .envs import ENVIRONMENTS, make
from .envs.cheetah_body import cheetah_model
from .envs.half_cheetah import FRAME_SKIP
from .evaluate import unseen_demonstrations
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


def measure(tasks: int, iterations: int, seed: int = 0, env: str = "point2d") -> Cost:
    """Time meta-iterations of EMRLD-WS from an untrained policy.

    Its episodes run their full 100 steps; the dense reward makes every part of the update work.
    """
    config = TrainConfig(env=env, algorithm="emrld-ws", seed=seed)
    environment = make(env, reward="dense")
    demonstrations = unseen_demonstrations(env, "optimal", tasks, seed)
    start = initialise(environment.state_dim, environment.action_dim, seed)
    whole, parts, steps = [], [], 0.0
    for iteration in range(iterations + 1):
        timing.seconds.clear()
        began = time.perf_counter()
        _, _, before, after, _ = meta_iteration(
            start,
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
    """Print the costs of each environment at its training size, then Point2D's for numbers of tasks."""
    print(f"EMRLD-WS, {torch.get_num_threads()} threads, {iterations} iterations a row; medians;")
    print("20 episodes of 100 steps a task, before and again after adaptation\n")
    heads = ("environment", "tasks", "seconds", "(range)", *PARTS, "steps/s", "peak MB", "s/task")
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
    """Print the environment's rate against bare MuJoCo's, in turn, and a whole iteration's cost in it."""
    rates = [cheetah_rate(seed=repeat) for repeat in range(repeats)]
    shares = sorted(rate.ours / rate.bare for rate in rates)
    print(
        f"half_cheetah, one thread: {statistics.median(rate.ours for rate in rates):,.0f} control "
        f"steps/s, {statistics.median(shares):.0%} of bare mj_step's rate "
        f"({shares[0]:.0%} to {shares[-1]:.0%} over {repeats} runs)"
    )
    torch.set_num_threads(1)
    ratios = []
    for repeat in range(3):
        bare, cost = cheetah_rate(seed=repeat).bare, measure(10, 1, env="half_cheetah")
        ratios.append(cost.seconds / (2 * 10 * 20 * 100 / bare))
    print(
        f"a whole meta-iteration of half_cheetah, one thread: {statistics.median(ratios):.2f} times the "
        f"seconds bare mj_step needs for its steps ({min(ratios):.2f} to {max(ratios):.2f})"
    )

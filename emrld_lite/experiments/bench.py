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

import mujoco
import numpy as np
import torch

from ..config import AlgorithmName, TrainConfig
from ..demonstrations import load_demonstrations
from ..demonstrators.recipes import unseen_demonstrations
from ..envs import ENVIRONMENTS, make
from ..envs.cheetah_body import cheetah_model
from ..envs.half_cheetah import FRAME_SKIP
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


class SteppingRate(NamedTuple):
    """Control steps per second of HalfCheetah: through our environment, and of bare ``mj_step``."""

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


class RobotRate(NamedTuple):
    """What the simulated robot costs, and whether it stands it."""

    seconds: float
    """Of all episodes."""
    fallen: int
    """Robots that fell over, or whose simulation broke."""
    farthest: float
    """The largest distance from the start that any of them reached, metres."""


def robot_rate(episodes: int = 1000, seed: int = 0) -> RobotRate:
    """Drive the simulated TurtleBot with random commands for whole episodes, and look how it ends."""
    robot = make("turtlebot")
    random = torch.Generator().manual_seed(seed)
    tasks = torch.linspace(-1.3, 1.3, 10)[:, None]
    began = time.perf_counter()
    states, farthest = robot.reset(tasks, episodes // 10, random), 0.0
    with torch.inference_mode():
        for step in range(robot.horizon):
            actions = 3.0 * torch.randn(*states.shape[:2], robot.action_dim, generator=random)
            states = robot.step(tasks, states, actions, step).states
            farthest = max(farthest, float(states[..., 3:5].norm(dim=-1).max()))
    return RobotRate(time.perf_counter() - began, robot.fallen, farthest)


def report_robot() -> None:
    """Print how long a thousand episodes of the simulated robot take, and how many of them broke."""
    rate = robot_rate()
    print(
        f"turtlebot, {torch.get_num_threads()} threads: 1,000 episodes of random commands in "
        f"{rate.seconds:.0f} s; {rate.fallen} fell over or broke; none went farther than "
        f"{rate.farthest:.2f} m"
    )

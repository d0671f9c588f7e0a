"""What the simulated bodies cost: HalfCheetah beside bare MuJoCo, and the TurtleBot for whole episodes."""

from __future__ import annotations

import statistics
import time
from typing import NamedTuple

import mujoco
import numpy as np
import torch

from ..envs import make
from ..envs.cheetah_body import cheetah_model
from ..envs.half_cheetah import FRAME_SKIP
from .bench import measure


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

"""The commands for a TurtleBot over ROS: a simulated one, and driving it or a real one with a stored run."""

from __future__ import annotations

import logging
from pathlib import Path

import torch

from ... import demonstrations as demonstration_files
from ...adapt import adapt, warm_start
from ...demonstrations import Demonstrations
from ...demonstrators import recipes
from ...envs.two_wheeled_drift import ROBOT_DRIFT, ROBOT_TRIALS, TwoWheeledDrift
from ...policy import take_params
from ...rollout import Rollout, episode_returns
from ...storage import check_target
from ...validation import InputError, ends_in, positive_count, seed_number
from .. import machine, runs


def robot_node(
    bias: float = ROBOT_DRIFT,
    pace: float = 1.0,
    seconds: float | None = None,
    seed: int = 0,
    quiet: bool = False,
) -> None:
    """Run a simulated TurtleBot on ROS: it publishes /odom and takes /cmd_vel; Ctrl-C ends it.

    Args:
        bias: rad/s by which it turns by itself while it is driven
        pace: simulated seconds per second
        seconds: simulated seconds to live; by default until it is stopped
        seed: seed of the odometry's errors
        quiet: do not say why the robot stopped
    """
    from ...robot.node import RobotNode  # MuJoCo and ROS are only needed here  # noqa: PLC0415
    from ...robot.simulated import SimulatedRobot  # noqa: PLC0415

    machine.use_threads(1)
    if not quiet:
        logging.basicConfig(format="%(message)s")
    node = RobotNode(SimulatedRobot(bias=bias, seed=seed), pace)
    print("a simulated TurtleBot: /odom and /cmd_vel", flush=True)
    try:
        node.run(seconds)
    finally:
        node.close()


def robot_drive(
    run: Path,
    out: Path,
    demos: Path | None = None,
    episodes: int = ROBOT_TRIALS,
    seed: int = 0,
    bias: float = 0.0,
    carry: bool = False,
    patience: float = 3.0,
) -> None:
    """Drive a TurtleBot over ROS with a stored meta-policy, adapt it to what it met, drive with that.

    Stopped by a robot that fails, the same command goes on after the episodes that are kept.

    Args:
        run: folder of a stored run of two_wheeled_drift
        out: folder for the episodes: before.npz by the meta-policy, after.npz by the adapted one
        demos: a demonstration file of one task; by default the workbook's expert under a drift of -0.65
        episodes: episodes before and after
        seed: seed of every draw
        bias: rad/s to add to every angular velocity, for a real robot, which does not drift by itself
        carry: wait before each episode for a person to carry the robot to its start
        patience: seconds to wait for the robot
    """
    from ...robot.collect import collect_driven  # MuJoCo and ROS are only needed here  # noqa: PLC0415
    from ...robot.driver import Driver, Limits  # noqa: PLC0415

    machine.use_threads(1)
    positive_count("episodes", episodes)
    seed_number("seed", seed)
    check_target("out", out, folder=True)
    stored = runs.load_run(run)
    world = stored.config.environment()
    if not isinstance(world, TwoWheeledDrift):
        raise InputError(f"{run}: expected a run of two_wheeled_drift, got {stored.config.env}")
    shown = _demonstration(stored, demos, seed).seen_in(world)
    rule, score = stored.config.adaptation(shown.quality), stored.config.score()
    random = torch.Generator().manual_seed(seed)
    start = take_params(warm_start(stored.meta_params, shown, rule), slice(0, 1))
    limits = Limits(patience=patience)
    driver = Driver(world, limits, bias, _wait_for_a_person if carry else None)
    try:
        before = collect_driven(driver, start, episodes, out / "before.npz", random)
        print(_told("before adaptation", before), flush=True)
        adapted = adapt(stored.meta_params, score(before), shown, rule)
        after = collect_driven(driver, adapted, episodes, out / "after.npz", random)
    finally:
        driver.close()
    print(_told("after one step", after))
    print(f"{out}: both sets of episodes")


def robot_study(out: Path, runs_folder: Path = runs.SHIPPED, threads: int = 1) -> None:
    """Drive a simulated TurtleBot with every stored run of changing dynamics, in all cases of the study.

    Without ROS. The table grows run by run: the same command goes on where it was stopped.

    Args:
        out: table to write, .csv
        runs_folder: folder of the stored runs
        threads: native threads that step the robots
    """
    from .. import robot_study as study  # MuJoCo is only needed here  # noqa: PLC0415

    machine.use_threads(threads)
    ends_in("out", check_target("out", out), ".csv")
    for name in study.study(runs_folder, out):
        print(name, flush=True)
    print(f"{out}: every case of every run")


def _demonstration(stored: runs.Run, demos: Path | None, seed: int) -> Demonstrations:
    """Return the demonstration of one task, from a file or the workbook's expert in simulation."""
    env = stored.config.env
    if demos is None:
        quality = stored.load_demonstrations().quality
        expert = recipes.load_or_train_expert(env, quality)
        wanted = torch.tensor([[ROBOT_DRIFT]])
        recipe = recipes.recipe_for(env, quality)
        return recipes.demonstrate(expert, env, wanted, quality, seed, recipe)
    loaded = demonstration_files.load(demos, env)
    if len(loaded.tasks) != 1:
        raise InputError(f"{demos}: expected demonstrations of one task, got {len(loaded.tasks)}")
    return loaded


def _wait_for_a_person() -> None:
    """Wait until the robot stands at its start."""
    input("carry the robot to its start, looking along x, then press Enter: ")


def _told(what: str, rollout: Rollout) -> str:
    """Return what became of the episodes in one line."""
    returns = ", ".join(f"{value:.1f}" for value in episode_returns(rollout)[0].tolist())
    reached = int(rollout.success.sum())
    return f"{what}: {reached} of {rollout.success.numel()} reached the goal; returns {returns}"

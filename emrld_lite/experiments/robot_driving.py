"""Stored policies drive the simulated TurtleBot, adapt, and drive again: Section 4.2's experiment.

A meta-policy drives the robot for five trajectories, sees one simulated demonstration, takes one step,
and drives again.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from ..adapt import adapt, warm_start
from ..demonstrations import Demonstrations
from ..demonstrators import recipes
from ..envs.base import Actions, Dynamics, States, Tasks, Transition
from ..envs.turtlebot import TurtleBot
from ..envs.turtlebot_body import Hardware
from ..envs.two_wheeled import TIME_STEP
from ..envs.two_wheeled_drift import DRIFT_GOAL, ROBOT_TRIALS, TwoWheeledDrift
from ..policy import per_task
from ..rollout import Rollout, collect, follow
from ..validation import InputError
from .runs import Run
from .textbook import GAIN, aim

EPISODES = 4  # that measure a policy


class Driven(NamedTuple):
    """Episodes on the robot, and where it really was."""

    rollout: Rollout
    """What the policy saw and did, (task, episode, time)."""
    truth: Float[Tensor, "task episode time 3"]
    """True x, y and heading after each step, zero after the end."""
    truly: Bool[Tensor, "task episode"]
    """Whether the robot itself, whatever its odometry said, stood in the goal's box at the end."""


class Witness(Dynamics):
    """A robot whose true places are written down while a policy drives it."""

    def __init__(self, robot: TurtleBot) -> None:
        self.robot, self.visited = robot, list[States]()
        self.horizon, self.state_dim, self.action_dim = (
            robot.horizon,
            robot.state_dim,
            robot.action_dim,
        )

    def reset(self, tasks: Tasks, episodes: int, random: torch.Generator | None = None) -> States:
        """Begin anew."""
        self.visited = []
        return self.robot.reset(tasks, episodes, random)

    def observe(self, states: Float[Tensor, "*at inside"]) -> Float[Tensor, "*at state"]:
        """Return what a policy sees."""
        return self.robot.observe(states)

    def step(self, tasks: Tasks, states: States, actions: Actions, time: int) -> Transition:
        """Step the robot and write down where it is."""
        moved = self.robot.step(tasks, states, actions, time)
        self.visited.append(moved.states)
        return moved

    def driven(self, tasks: Tasks, rollout: Rollout) -> Driven:
        """Return the episodes with the places of the last rollout."""
        states = torch.stack(self.visited, dim=2)  # (task, episode, time, 6)
        last = rollout.mask.sum(-1).long() - 1  # (task, episode)
        index = last[..., None, None].expand(*last.shape, 1, states.shape[-1])
        ends = states.gather(2, index).squeeze(2)
        truth = states[..., 3:] * rollout.mask[..., None]
        return Driven(rollout, truth, self.robot.truly_reached(tasks, ends) & rollout.success)


def robot_bias(world: TwoWheeledDrift, drifts: Float[Tensor, "task 1"]) -> Float[Tensor, "task 1"]:
    """Return by how many rad/s a robot must turn by itself to drift as ``world`` does.

    The literal reading of the paper's formula adds a drift to the heading in every step of half a second.
    """
    return world.drift_per_step(drifts) / TIME_STEP


def robot_for(world: TwoWheeledDrift, hardware: Hardware | None = None) -> TurtleBot:
    """Return the robot for a policy that was trained in ``world``: it sees a heading if that one did."""
    return TurtleBot(heading=world.heading, hardware=hardware or Hardware())


def simulated_demonstrations(
    run: Run, drifts: Float[Tensor, "task 1"], seed: int = 0
) -> Demonstrations:
    """Return one demonstration per drift by the workbook's expert, in the world that trained ``run``."""
    quality = run.load_demonstrations().quality
    expert = recipes.load_or_train_expert(run.config.env, quality)
    shown = recipes.demonstrate(expert, run.config.env, drifts, quality, seed)
    return shown.seen_in(run.config.environment())


class Adapted(NamedTuple):
    """The experiment of Section 4.2: driving before, the trajectories adapted on, driving after."""

    before: Driven
    trial: Driven
    after: Driven


def adapt_on_robot(
    run: Run,
    drifts: Float[Tensor, "task 1"],
    hardware: Hardware | None = None,
    episodes: int = EPISODES,
    seed: int = 0,
) -> Adapted:
    """Drive with the meta-policy, adapt it to five trajectories and a demonstration, drive again.

    One task per drift, in the unit of the environment of ``run``; another environment raises InputError.
    """
    world = run.config.environment()
    if not isinstance(world, TwoWheeledDrift):
        raise InputError(f"{run.config.env}: expected a run of changing dynamics")
    tasks, robot = robot_bias(world, drifts), Witness(robot_for(world, hardware))
    shown = simulated_demonstrations(run, drifts, seed)
    rule = run.config.adaptation(shown.quality)
    random = torch.Generator().manual_seed(seed)
    meta_params = per_task(run.meta_params, len(drifts))
    before = robot.driven(tasks, collect(robot, tasks, meta_params, episodes, random))
    start = warm_start(meta_params, shown, rule)
    trial = robot.driven(tasks, collect(robot, tasks, start, ROBOT_TRIALS, random))
    adapted = adapt(meta_params, run.config.score()(trial.rollout), shown, rule)
    after = robot.driven(tasks, collect(robot, tasks, adapted, episodes, random))
    return Adapted(before, trial, after)


def controller_on_robot(
    biases: Float[Tensor, "task 1"],
    hardware: Hardware | None = None,
    episodes: int = EPISODES,
    seed: int = 0,
    gain: float = GAIN,
) -> Driven:
    """Drive with the textbook controller, which is told the goal and not the bias."""
    bot = TurtleBot(hardware=hardware or Hardware())
    robot, act = Witness(bot), aim(torch.tensor([DRIFT_GOAL]), bot.omega_limit, gain)
    random = torch.Generator().manual_seed(seed)
    return robot.driven(biases, follow(robot, biases, act, episodes, random))

"""TwoWheeled Locomotion: a robot that must turn before it can drive to an unseen goal, and its drift."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from matplotlib.axes import Axes

from ..validation import known, positive_count, shaped
from .base import Environment, Transition, refuse_wrong
from .drawing import box_goal, path, robot
from .goals import check_goals, goal_distance, sample_goals, spread_goals

HORIZON = 100  # steps, appendix B
TIME_STEP = 0.5  # dT, seconds
ARENA = 2.5  # |x| and |y| beyond which the episode ends
NEAR = 0.5  # inside, the reward is one minus the distance
DRIFT_GOAL = (2.0, 1.0)
DRIFT_LIMIT = 0.8  # rad/s; the paper names one value, -0.65


def velocities(actions: torch.Tensor, v_limit: float, omega_limit: float) -> torch.Tensor:
    """Turn actions (..., 2) in [-1, 1] into v in [0, v_limit] and omega in +-omega_limit, (..., 2)."""
    clipped = actions.clamp(-1.0, 1.0)
    v = (clipped[..., 0] + 1.0) * (0.5 * v_limit)
    omega = clipped[..., 1] * omega_limit
    return torch.stack([v, omega], dim=-1)


def drive(states: torch.Tensor, v: torch.Tensor, turn: torch.Tensor) -> torch.Tensor:
    """Return (x, y, theta) after one step: straight ahead for v dT, then a turn by ``turn`` radians.

    x' = x + v cos(theta) dT, y' = y + v sin(theta) dT, theta' = theta + turn. Appendix B.
    """
    x, y, theta = states.unbind(-1)
    ahead = v * TIME_STEP
    return torch.stack([x + ahead * theta.cos(), y + ahead * theta.sin(), theta + turn], dim=-1)


def sparse_reward(
    states: torch.Tensor, goals: torch.Tensor, time: int, reached_box: float
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the paper's reward and whether the goal's box is reached, both (...). Appendix B."""
    distance = goal_distance(states, goals)
    dx = (states[..., 0] - goals[..., 0]).abs()
    dy = (states[..., 1] - goals[..., 1]).abs()
    reached = (dx <= reached_box) & (dy <= reached_box)
    near = torch.where(distance <= NEAR, 1.0 - distance, torch.zeros_like(distance))
    remaining = torch.full_like(distance, HORIZON - time - 1)
    return torch.where(reached, remaining, near), reached


@dataclass(frozen=True)
class _Wheeled(Environment):
    """What both wheeled families share: states, start, step, arena."""

    reward: Literal["sparse", "dense"] = "sparse"
    """The paper's sparse reward, or minus the distance to the goal, which the experts learn from."""

    horizon = HORIZON
    state_dim = 3
    action_dim = 2
    v_limit = 0.22
    omega_limit = 2.84
    reached_box = 0.2

    def __post_init__(self) -> None:
        known("reward", self.reward, ("sparse", "dense"))

    @property
    def observation_high(self) -> tuple[float, ...]:  # type: ignore[override]
        """The arena and a step beyond it; the heading is never wrapped."""
        edge = ARENA + self.v_limit * TIME_STEP
        return (edge, edge, HORIZON * self._largest_turn())

    @property
    def observation_low(self) -> tuple[float, ...]:  # type: ignore[override]
        """The same downwards."""
        return tuple(-bound for bound in self.observation_high)

    def _largest_turn(self) -> float:
        return self.omega_limit * TIME_STEP

    def reset(self, tasks: torch.Tensor, episodes: int) -> torch.Tensor:
        """Return the origin, heading along x, for every episode, (task, episode, 3)."""
        return torch.zeros(len(tasks), positive_count("episodes", episodes), 3, device=tasks.device)

    def step(
        self, tasks: torch.Tensor, states: torch.Tensor, actions: torch.Tensor, time: int
    ) -> Transition:
        """Drive every robot and pay its reward; outside the arena the episode ends."""
        v, omega = velocities(actions, self.v_limit, self.omega_limit).unbind(-1)
        moved = drive(states, v, self._turn(tasks, omega))  # (task, episode, 3)
        goals = self._goals(tasks)[:, None]
        rewards, reached = sparse_reward(moved, goals, time, self.reached_box)
        if self.reward == "dense":
            rewards = -goal_distance(moved, goals)
        outside = (moved[..., :2].abs() > ARENA).any(-1)
        return Transition(moved, rewards, reached | outside, reached)

    def distance_to_reward(self, tasks: torch.Tensor, states: torch.Tensor) -> torch.Tensor:
        """Return the distance to the disc of radius 0.5 around the goal."""
        return goal_distance(states, self._goals(tasks)[:, None]) - NEAR

    def draw(self, axes: Axes, task: torch.Tensor, states: torch.Tensor) -> None:
        """Draw the goal's box and ring, the way so far, and the robot at its end."""
        goal = self._goals(task[None])[0].tolist()
        box_goal(axes, goal, NEAR, self.reached_box)
        path(axes, states)
        robot(axes, states[-1].tolist())
        axes.set(xlim=(-ARENA, ARENA), ylim=(-ARENA, ARENA))

    def _turn(self, tasks: torch.Tensor, omega: torch.Tensor) -> torch.Tensor:
        """Return the change of heading in radians, (task, episode)."""
        return omega * TIME_STEP

    def _goals(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return the goal of each task, (task, 2)."""
        return tasks


@dataclass(frozen=True)
class TwoWheeled(_Wheeled):
    """The paper's TwoWheeled Locomotion (appendix B, Environments).

    =========== ===== ==========================================================================
    Observation 0, 1  x and y of the robot, in length units; starts at the origin
    Observation 2     heading theta in radians, not wrapped; starts at 0, along x
    Action      0     linear velocity: [-1, 1] stands for v from 0 to 0.22 length units a second
    Action      1     angular velocity: [-1, 1] stands for omega from -2.84 to 2.84 rad a second
    Task        0, 1  x and y of the goal, on the upper semicircle of radius 2
    =========== ===== ==========================================================================

    A step lasts dT = 0.5 s. The state has a heading, which the paper's R^2 leaves out, and the arena
    is |x|, |y| <= 2.5: a square of side 2.5 would shut the goals out. Raises InputError for an
    unknown reward.
    """

    name = "two_wheeled"
    task_dim = 2

    def training_tasks(self) -> torch.Tensor:
        """Return 24 goals, evenly spread over the semicircle with both its ends, (24, 2)."""
        return spread_goals(24)

    def sample_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return goals drawn uniformly from the semicircle, (count, 2)."""
        return sample_goals(count, random)

    def check_tasks(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return goals (task, 2) unless one lies off the upper semicircle of radius 2."""
        return check_goals("TwoWheeled", tasks)


@dataclass(frozen=True)
class TwoWheeledDrift(_Wheeled):
    """The paper's TwoWheeled Locomotion with changing dynamics (appendix B, Environments).

    =========== ===== ==========================================================================
    Observation 0, 1  x and y of the robot, in length units; starts at the origin
    Observation 2     heading theta in radians, not wrapped; starts at 0, along x
    Action      0     linear velocity: [-1, 1] stands for v from 0 to 0.15 length units a second
    Action      1     angular velocity: [-1, 1] stands for omega from -1.5 to 1.5 rad a second
    Task        0     residual angular velocity omega_g, within 0.8 rad a second of 0
    =========== ===== ==========================================================================

    The goal is (2, 1) for every task. Raises InputError for an unknown reward or drift rule.
    """

    drift_rule: Literal["rate", "literal"] = "rate"
    """"rate": theta' = theta + (omega + omega_g) dT; "literal": theta + omega_g + omega dT, as printed."""

    name = "two_wheeled_drift"
    task_dim = 1
    v_limit = 0.15
    omega_limit = 1.5
    reached_box = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        known("drift rule", self.drift_rule, ("rate", "literal"))

    def training_tasks(self) -> torch.Tensor:
        """Return 9 residual angular velocities, evenly spread from -0.8 to 0.8 rad/s, (9, 1)."""
        return torch.linspace(-DRIFT_LIMIT, DRIFT_LIMIT, 9)[:, None]

    def sample_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return residual angular velocities drawn uniformly within the same limits, (count, 1)."""
        drawn = random.uniform(-DRIFT_LIMIT, DRIFT_LIMIT, (positive_count("tasks", count), 1))
        return torch.tensor(drawn, dtype=torch.float32)

    def check_tasks(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return drifts (task, 1) unless one is larger than 0.8 rad/s."""
        shaped("TwoWheeledDrift drifts", tasks, ("task", 1))
        wrong = tasks[:, 0].abs() > DRIFT_LIMIT + 1e-6
        expected = f"a residual angular velocity within {DRIFT_LIMIT} rad/s of 0"
        return refuse_wrong("TwoWheeledDrift", tasks, wrong, expected)

    def _largest_turn(self) -> float:
        drift = DRIFT_LIMIT * (TIME_STEP if self.drift_rule == "rate" else 1.0)
        return self.omega_limit * TIME_STEP + drift

    def _turn(self, tasks: torch.Tensor, omega: torch.Tensor) -> torch.Tensor:
        drift = tasks[:, :1]  # (task, 1), broadcast over episodes
        if self.drift_rule == "literal":
            return drift + omega * TIME_STEP
        return (omega + drift) * TIME_STEP

    def _goals(self, tasks: torch.Tensor) -> torch.Tensor:
        goal = torch.tensor(DRIFT_GOAL, dtype=tasks.dtype, device=tasks.device)
        return goal.expand(len(tasks), 2)

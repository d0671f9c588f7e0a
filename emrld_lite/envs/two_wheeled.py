"""TwoWheeled Locomotion: a robot that must turn before it can drive to an unseen goal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import get_args

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from ..validation import check_choice, positive_count, true_or_false
from .base import (
    Actions,
    Axes,
    Environment,
    PerEpisode,
    Reward,
    States,
    Tasks,
    Transition,
)
from .goals import Goals, check_goals, goal_distance, sample_goals, spread_goals

HORIZON = 100  # steps, appendix B
TIME_STEP = 0.5  # dT, seconds
ARENA = 2.5  # |x| and |y| beyond which the episode ends
NEAR = 0.5  # inside, the reward is one minus the distance


def velocities(
    actions: Float[Tensor, "*at 2"], v_limit: float, omega_limit: float
) -> Float[Tensor, "*at 2"]:
    """Turn actions in [-1, 1] into v in [0, v_limit] and omega in +-omega_limit."""
    clipped = actions.clamp(-1.0, 1.0)
    v = (clipped[..., 0] + 1.0) * (0.5 * v_limit)
    omega = clipped[..., 1] * omega_limit
    return torch.stack([v, omega], dim=-1)


def drive(
    states: Float[Tensor, "*at 3"], v: Float[Tensor, "*at"], turn: Float[Tensor, "*at"]
) -> Float[Tensor, "*at 3"]:
    """Return (x, y, theta) after one step: straight ahead for v dT, then a turn by ``turn`` radians.

    x' = x + v cos(theta) dT, y' = y + v sin(theta) dT, theta' = theta + turn. Appendix B.
    """
    x, y, theta = states.unbind(-1)
    ahead = v * TIME_STEP
    return torch.stack([x + ahead * theta.cos(), y + ahead * theta.sin(), theta + turn], dim=-1)


def sparse_reward(
    states: Float[Tensor, "*at 3"], goals: Float[Tensor, "*#at 2"], time: int, reached_box: float
) -> tuple[Float[Tensor, "*at"], Bool[Tensor, "*at"]]:
    """Return the paper's reward and whether the goal's box is reached. Appendix B."""
    distance = goal_distance(states, goals)
    dx = (states[..., 0] - goals[..., 0]).abs()
    dy = (states[..., 1] - goals[..., 1]).abs()
    reached = (dx <= reached_box) & (dy <= reached_box)
    near = torch.where(distance <= NEAR, 1.0 - distance, torch.zeros_like(distance))
    remaining = torch.full_like(distance, HORIZON - time - 1)
    return torch.where(reached, remaining, near), reached


def pose(states: Float[Tensor, "time state"]) -> list[float]:
    """Return the last x, y and heading; a heading that is not in the states, from the way driven."""
    if states.shape[-1] == 3:
        return states[-1].tolist()
    dx, dy = (states[-1] - states[max(0, len(states) - 2)]).tolist()
    return [*states[-1].tolist(), math.atan2(dy, dx)]


@dataclass(frozen=True)
class Wheeled(Environment):
    """What both wheeled families share: states, start, step, arena."""

    reward: Reward = Environment.reward
    """The paper's sparse reward, or minus the distance to the goal, which the experts learn from."""
    heading: bool = True
    """Whether a policy sees the heading; without it, the paper's state in R^2, only x and y."""

    horizon = HORIZON
    action_dim = 2
    v_limit = 0.22
    omega_limit = 2.84
    reached_box = 0.2
    idle_action = (-1.0, 0.0)

    def __post_init__(self) -> None:
        check_choice("reward", self.reward, get_args(Reward))
        true_or_false("heading", self.heading)

    @property
    def state_dim(self) -> int:  # type: ignore[override]
        """x, y and, where it is seen, the heading."""
        return 3 if self.heading else 2

    def observe(self, states: Float[Tensor, "*at inside"]) -> Float[Tensor, "*at state"]:
        """Return (x, y, theta), or x and y alone."""
        return states[..., : self.state_dim]

    @property
    def observation_high(self) -> tuple[float, ...]:  # type: ignore[override]
        """The arena and a step beyond it; the heading is never wrapped."""
        edge = ARENA + self.v_limit * TIME_STEP
        return (edge, edge, HORIZON * self._largest_turn())[: self.state_dim]

    @property
    def observation_low(self) -> tuple[float, ...]:  # type: ignore[override]
        """Minus the upper bounds."""
        return tuple(-bound for bound in self.observation_high)

    def _largest_turn(self) -> float:
        return self.omega_limit * TIME_STEP

    def reset(self, tasks: Tasks, episodes: int, random: torch.Generator | None = None) -> States:
        """Return the origin, heading along x, for every episode."""
        return torch.zeros(len(tasks), positive_count("episodes", episodes), 3, device=tasks.device)

    def step(self, tasks: Tasks, states: States, actions: Actions, time: int) -> Transition:
        """Drive every robot and pay its reward; outside the arena the episode ends."""
        v, omega = velocities(actions, self.v_limit, self.omega_limit).unbind(-1)
        moved = drive(states, v, self._turn(tasks, omega))  # (task, episode, 3)
        goals = self._goals(tasks)[:, None]
        rewards, reached = sparse_reward(moved, goals, time, self.reached_box)
        if self.reward == "dense":
            rewards = -goal_distance(moved, goals)
        outside = (moved[..., :2].abs() > ARENA).any(-1)
        return Transition(moved, rewards, reached | outside, reached)

    def distance_to_reward(self, tasks: Tasks, states: States) -> PerEpisode:
        """Return the distance to the disc of radius 0.5 around the goal."""
        return goal_distance(states, self._goals(tasks)[:, None]) - NEAR

    def draw(
        self, axes: Axes, task: Float[Tensor, " task_dim"], states: Float[Tensor, "time state"]
    ) -> None:
        """Draw the goal's box and ring, the way so far, and the robot at its end."""
        from .drawing import box_goal, path, robot

        goal = self._goals(task[None])[0].tolist()
        box_goal(axes, goal, NEAR, self.reached_box)
        path(axes, states)
        robot(axes, pose(states))
        axes.set(xlim=(-ARENA, ARENA), ylim=(-ARENA, ARENA))

    def draw_tasks(self, axes: Axes, tasks: Tasks) -> None:
        """Draw the start, and each goal with the disc that pays."""
        from .drawing import goals_in_the_plane

        goals_in_the_plane(axes, self._goals(tasks), NEAR)

    def track(self, states: Float[Tensor, "time state"]) -> Float[Tensor, "2 time"]:
        """Return x and y."""
        return states[:, :2].T

    def _turn(self, tasks: Tasks, omega: PerEpisode) -> PerEpisode:
        """Return the change of heading in radians."""
        return omega * TIME_STEP

    def _goals(self, tasks: Tasks) -> Goals:
        """Return the goal of each task."""
        return tasks


@dataclass(frozen=True)
class TwoWheeled(Wheeled):
    """The paper's TwoWheeled Locomotion (appendix B, Environments).

    ## Description
    A robot that can turn and drive ahead, not sideways, goes to a goal that it does not see. A step
    lasts dT = 0.5 s. The state has a heading, which the paper's R^2 leaves out.

    ## Observation space
    === ============================= ====== ===== =============
    Num Observation                   Min    Max   Unit
    === ============================= ====== ===== =============
    0   x of the robot                -2.61  2.61  length units
    1   y of the robot                -2.61  2.61  length units
    2   heading theta, not wrapped    -142   142   radians
    === ============================= ====== ===== =============

    ## Action space
    === ======================== === === ======================================
    Num Action                   Min Max Stands for
    === ======================== === === ======================================
    0   linear velocity v        -1  1   0 to 0.22 length units per second
    1   angular velocity omega   -1  1   -2.84 to 2.84 radians per second
    === ======================== === === ======================================

    ## Rewards
    With d the distance to the goal after a step: 1 - d where d <= 0.5; the number of steps that are
    left where |x| and |y| are both within 0.2 of the goal's; 0 elsewhere. ``reward="dense"``: -d.

    ## Starting state
    The origin, heading along x.

    ## Episode end
    Terminated within 0.2 of the goal in x and in y, and outside the arena |x|, |y| <= 2.5 (a square
    of side 2.5 would shut the goals out); truncated after 100 steps.

    ## Tasks and options
    A task is the goal's x and y, on the upper semicircle of radius 2: 24 to train on, evenly spread,
    others drawn uniformly. ``reward`` and ``heading`` as below; InputError for unknown ones.
    """

    name = "two_wheeled"
    task_dim = 2

    def training_tasks(self) -> Tasks:
        """Return 24 goals, evenly spread over the semicircle with both its ends."""
        return spread_goals(24)

    def sample_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return goals drawn uniformly from the semicircle."""
        return sample_goals(count, random)

    def check_tasks(self, tasks: Tensor) -> Tasks:
        """Return goals (task, 2) unless one lies off the upper semicircle of radius 2."""
        return check_goals("TwoWheeled", tasks)

"""Point2D Navigation: reach an unseen goal on a semicircle, rewarded only next to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from matplotlib.axes import Axes

from ..validation import known, positive_count
from .base import Environment, Transition
from .drawing import path, round_goal
from .goals import check_goals, goal_distance, sample_goals, spread_goals

HORIZON = 100  # steps, appendix B
STEP_LIMIT = 0.1  # dx^2 + dy^2 <= 0.1^2
NEAR = 0.2  # D_1: inside, the reward is one minus the distance
REACHED = 0.02  # D_2: inside, the remaining steps are paid out and the episode ends


def displacement(actions: torch.Tensor, step_rule: str) -> torch.Tensor:
    """Turn actions (..., 2) into displacements (..., 2).

    "at-most" is the paper's rule, a norm of at most 0.1; "exact" is the released code's, where
    every step has a norm of exactly 0.1 (so a point next to its goal must jump over it).
    """
    moves = actions.clamp(-1.0, 1.0) * STEP_LIMIT
    dx, dy = moves[..., 0], moves[..., 1]
    norm = (dx * dx + dy * dy).sqrt()
    if step_rule == "exact":
        scale = STEP_LIMIT / norm.clamp_min(1e-12)
    else:
        scale = STEP_LIMIT / norm.clamp_min(STEP_LIMIT)
    return moves * scale[..., None]


def sparse_reward(distance: torch.Tensor, time: int) -> torch.Tensor:
    """Return the paper's reward (appendix B) for distances after the step of time index ``time``."""
    near = torch.where(distance <= NEAR, 1.0 - distance, torch.zeros_like(distance))
    return torch.where(distance <= REACHED, torch.full_like(distance, HORIZON - time - 1), near)


@dataclass(frozen=True)
class Point2D(Environment):
    """The paper's Point2D Navigation (appendix B, Environments).

    =========== ===== ============================================================
    Observation 0, 1  x and y of the point, in length units; starts at the origin
    Action      0, 1  dx and dy in units of 0.1 length units, clipped to [-1, 1]
    Task        0, 1  x and y of the goal, on the upper semicircle of radius 2
    =========== ===== ============================================================

    Raises InputError for an unknown reward or step rule.
    """

    reward: Literal["sparse", "dense"] = "sparse"
    """The paper's sparse reward, or minus the distance to the goal, which the experts learn from."""
    step_rule: Literal["at-most", "exact"] = "at-most"
    """The paper's rule for the length of a step, or the released code's."""

    name = "point2d"
    horizon = HORIZON
    state_dim = 2
    action_dim = 2
    task_dim = 2
    observation_low = (-HORIZON * STEP_LIMIT,) * 2
    observation_high = (HORIZON * STEP_LIMIT,) * 2

    def __post_init__(self) -> None:
        known("reward", self.reward, ("sparse", "dense"))
        known("step rule", self.step_rule, ("at-most", "exact"))

    def training_tasks(self) -> torch.Tensor:
        """Return 12 goals, evenly spread over the semicircle with both its ends, (12, 2)."""
        return spread_goals(12)

    def sample_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return goals drawn uniformly from the semicircle, (count, 2)."""
        return sample_goals(count, random)

    def check_tasks(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return goals (task, 2) unless one lies off the upper semicircle of radius 2."""
        return check_goals("Point2D", tasks)

    def reset(self, tasks: torch.Tensor, episodes: int) -> torch.Tensor:
        """Return the origin for every episode, (task, episode, 2)."""
        return torch.zeros(len(tasks), positive_count("episodes", episodes), 2, device=tasks.device)

    def step(
        self, tasks: torch.Tensor, states: torch.Tensor, actions: torch.Tensor, time: int
    ) -> Transition:
        """Move every point and pay its reward; see the module's functions for the formulas."""
        moved = states + displacement(actions, self.step_rule)  # (task, episode, 2)
        distance = goal_distance(moved, tasks[:, None])  # (task, episode)
        reached = distance <= REACHED
        rewards = -distance if self.reward == "dense" else sparse_reward(distance, time)
        return Transition(moved, rewards, reached, reached)

    def distance_to_reward(self, tasks: torch.Tensor, states: torch.Tensor) -> torch.Tensor:
        """Return the distance to the disc of radius 0.2 around the goal."""
        return goal_distance(states, tasks[:, None]) - NEAR

    def draw(self, axes: Axes, task: torch.Tensor, states: torch.Tensor) -> None:
        """Draw the goal's disc, the way so far, and the point at its end."""
        round_goal(axes, task.tolist(), NEAR)
        path(axes, states)
        axes.plot(*states[-1].tolist(), marker="o", color="black", markersize=5, linestyle="none")
        axes.set(xlim=(-2.6, 2.6), ylim=(-2.6, 2.6))

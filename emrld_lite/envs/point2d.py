"""Point2D Navigation: reach an unseen goal on a semicircle, rewarded only next to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch

from ..validation import InputError, known, positive_count, real_number, shaped
from .base import Environment, Transition

HORIZON = 100  # steps, appendix B
GOAL_RADIUS = 2.0  # distance of every goal from the start
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


def goal_distance(states: torch.Tensor, goals: torch.Tensor) -> torch.Tensor:
    """Return Euclidean distances, (...) from states (..., 2) and goals (..., 2)."""
    dx = states[..., 0] - goals[..., 0]
    dy = states[..., 1] - goals[..., 1]
    return (dx * dx + dy * dy).sqrt()


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
        return goals_at(np.linspace(0.0, math.pi, 12))

    def sample_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return goals drawn uniformly from the semicircle, (count, 2)."""
        return goals_at(random.uniform(0.0, math.pi, positive_count("tasks", count)))

    def check_tasks(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return goals (task, 2) unless one lies off the upper semicircle of radius 2."""
        shaped("Point2D goals", tasks, ("task", 2))
        radius = goal_distance(tasks, torch.zeros(2, device=tasks.device))
        wrong = ((radius - GOAL_RADIUS).abs() > 1e-3) | (tasks[:, 1] < -1e-3)
        if wrong.any():
            task = int(wrong.nonzero()[0])
            raise InputError(
                f"Point2D task {task}: expected a goal on the upper semicircle of radius "
                f"{GOAL_RADIUS}, got {tuple(round(v, 4) for v in tasks[task].tolist())}"
            )
        return tasks

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


def goals_at(angles: np.ndarray) -> torch.Tensor:
    """Return points on the circle of radius 2 at ``angles`` in radians, (angle, 2), float32."""
    for angle in np.atleast_1d(angles):
        real_number("goal angle in radians", float(angle))
    goals = GOAL_RADIUS * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return torch.tensor(goals, dtype=torch.float32)

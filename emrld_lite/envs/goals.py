"""Goals on the semicircle: what Point2D and TwoWheeled share."""

from __future__ import annotations

import math

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from ..validation import positive_count, real_number, shaped
from .base import refuse_wrong

GOAL_RADIUS = 2.0  # distance of every goal from the start

Goals = Float[Tensor, "task 2"]


def goals_at(angles: np.ndarray) -> Goals:
    """Return points on the circle of radius 2 at ``angles`` in radians, float32."""
    for angle in np.atleast_1d(angles):
        real_number("goal angle in radians", float(angle))
    goals = GOAL_RADIUS * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return torch.tensor(goals, dtype=torch.float32)


def spread_goals(count: int) -> Goals:
    """Return ``count`` goals, evenly spread over the upper semicircle with both its ends."""
    return goals_at(np.linspace(0.0, math.pi, count))


def sample_goals(count: int, random: np.random.Generator) -> Goals:
    """Return goals drawn uniformly from the upper semicircle."""
    return goals_at(random.uniform(0.0, math.pi, positive_count("tasks", count)))


def check_goals(name: str, goals: Tensor) -> Goals:
    """Return goals (task, 2) unless one lies off the upper semicircle; then raise InputError."""
    shaped(f"{name} goals", goals, ("task", 2))
    radius = goal_distance(goals, torch.zeros(2, device=goals.device))
    wrong = ((radius - GOAL_RADIUS).abs() > 1e-3) | (goals[:, 1] < -1e-3)
    expected = f"a goal on the upper semicircle of radius {GOAL_RADIUS}"
    return refuse_wrong(name, goals, wrong, expected)


def goal_distance(
    states: Float[Tensor, "... state"], goals: Float[Tensor, "... 2"]
) -> Float[Tensor, ...]:
    """Return Euclidean distances of the states' x and y, their first two numbers, from the goals."""
    dx = states[..., 0] - goals[..., 0]
    dy = states[..., 1] - goals[..., 1]
    return (dx * dx + dy * dy).sqrt()

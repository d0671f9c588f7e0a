"""The textbook controller: aim at the goal, which it is told, and drive. No learning; the yardstick."""

from __future__ import annotations

import math
from collections.abc import Callable

import torch
from jaxtyping import Float
from torch import Tensor

from ..envs.base import Actions, States
from ..envs.two_wheeled import TIME_STEP
from ..validation import real_number

GAIN = 1.0 / TIME_STEP  # rad/s per rad: one step turns the robot by as much as it is off


def bearing(
    states: Float[Tensor, "*at state"], goals: Float[Tensor, "*#at 2"]
) -> Float[Tensor, "*at"]:
    """Return how far a goal lies to the left of the robot's nose, the short way round, in radians.

    ``states`` begin with x, y and heading.
    """
    dx, dy = (goals - states[..., :2]).unbind(-1)
    off = torch.atan2(dy, dx) - states[..., 2]
    return off - 2.0 * math.pi * torch.round(off / (2.0 * math.pi))


def aim(
    goals: Float[Tensor, "task 2"], omega_limit: float, gain: float = GAIN
) -> Callable[[States, int], Actions]:
    """Return what turns towards the goal at ``gain`` times the bearing, and drives as far as it looks there.

    v = v_limit max(0, cos(bearing)), omega = gain * bearing within its limits; as actions in [-1, 1].
    A proportional controller: a steady drift of b rad/s leaves it b / gain radians off its aim. Siegwart,
    Nourbakhsh and Scaramuzza (2011), Introduction to Autonomous Mobile Robots, section 3.6. The states
    must hold the heading; a gain below 0 or above 20 raises InputError.
    """
    real_number("gain", gain, 0.0, 20.0)

    def act(seen: States, time: int) -> Actions:
        off = bearing(seen, goals[:, None])
        ahead = 2.0 * off.cos().clamp_min(0.0) - 1.0
        return torch.stack([ahead, (gain * off / omega_limit).clamp(-1.0, 1.0)], dim=-1)

    return act

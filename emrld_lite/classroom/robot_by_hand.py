"""What takes a student's own parts of a robot: a ride by wheel speeds, and what its sensors said.

Until a part is written, the one below of its name stands for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from ..adapt import Adaptation, adapt, warm_start
from ..advantage import Score
from ..demonstrations import Demonstrations
from ..envs.turtlebot import CONTROL_STEPS, READING_STEPS
from ..envs.turtlebot_body import (
    BASE_POSE,
    HALF_TRACK,
    OMEGA_MAX,
    V_MAX,
    WHEEL_RADIUS,
    Hardware,
    pose_of,
    turtlebot_model,
)
from ..envs.two_wheeled import velocities
from ..envs.two_wheeled_drift import ROBOT_TRIALS, TwoWheeledDrift
from ..policy import Params
from ..rollout import Rollout
from .checks.notebook_09 import exact_largest_gain
from .checks.values import as_tensor

WheelCommand = Callable[[Tensor, float], Any]
Drive = Callable[[Params, int], Rollout]


class Ride(NamedTuple):
    """What one ride's sensors said, and what was so, from the start on, 40 readings per second."""

    angles: Float[Tensor, "reading 2"]
    """How far the left and the right wheel have turned, rad."""
    headings: Float[Tensor, " reading"]
    """Where the gyroscope believes to look, within half a turn, rad."""
    truth: Float[Tensor, "reading 3"]
    """x, y and heading, metres and rad; the heading within half a turn."""


def ride(
    command: WheelCommand,
    actions: Sequence[Sequence[float]],
    bias: float = 0.0,
    hardware: Hardware | None = None,
) -> Ride:
    """Let a robot without delay hold the wheel speeds of ``command`` for half a second per action."""
    model = turtlebot_model(hardware or Hardware())
    data = mujoco.MjData(model)
    readings = [_reading(data)]
    for action in actions:
        answer = command(torch.tensor(action, dtype=torch.float32), bias)
        data.ctrl[:] = as_tensor(answer, (2,), "two wheel speeds").numpy()
        for _ in range(CONTROL_STEPS // READING_STEPS):
            mujoco.mj_step(model, data, nstep=READING_STEPS)
            readings.append(_reading(data))
    angles, truth = (torch.tensor(np.array(part)) for part in zip(*readings, strict=True))
    return Ride(angles, truth[:, 2].clone(), truth)


def _reading(data: mujoco.MjData) -> tuple[np.ndarray, np.ndarray]:
    """Return the wheels' angles and the true pose."""
    return data.qpos[BASE_POSE:].copy(), pose_of(data.qpos)


def wheel_command(action: Tensor, bias: float) -> Float[Tensor, " 2"]:
    """Return the speeds of the left and the right wheel for an action and a bias, rad/s."""
    if not torch.isfinite(action).all():
        return torch.zeros(2)
    v, omega = velocities(action, TwoWheeledDrift.v_limit, TwoWheeledDrift.omega_limit)
    omega = (omega + bias).clamp(-OMEGA_MAX, OMEGA_MAX)
    across = HALF_TRACK * omega
    ahead = v.clamp(-V_MAX, V_MAX)
    return torch.stack([ahead - across, ahead + across]) / WHEEL_RADIUS


def odometry(
    angles: Float[Tensor, "reading 2"], headings: Float[Tensor, " reading"], radius: float
) -> Float[Tensor, "reading 3"]:
    """Return x, y and heading at every reading; the first is the origin."""
    turned = headings.diff()
    turned = turned - 2.0 * math.pi * torch.round(turned / (2.0 * math.pi))
    heading = torch.cat([headings.new_zeros(1), turned.cumsum(0)])
    driven = radius * angles.diff(dim=0).mean(-1)
    middle = heading[:-1] + 0.5 * turned
    steps = torch.stack([driven * middle.cos(), driven * middle.sin()], dim=-1)
    places = torch.cat([steps.new_zeros(1, 2), steps.cumsum(0)])
    return torch.cat([places, heading[:, None]], dim=-1)


def one_adaptation(
    meta_params: Params, drive: Drive, demonstration: Demonstrations, rule: Adaptation, score: Score
) -> Params:
    """Return the policy after Section 4.2's one adaptation step on a robot."""
    start = warm_start(meta_params, demonstration, rule)
    return adapt(meta_params, score(drive(start, ROBOT_TRIALS)), demonstration, rule)


largest_gain = exact_largest_gain

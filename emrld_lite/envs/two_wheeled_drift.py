"""TwoWheeled Locomotion with changing dynamics: the same robot turns by itself, unseen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import torch
from torch import Tensor

from ..validation import positive_count, real_number, shaped
from .base import PerEpisode, Tasks, refuse_wrong
from .goals import Goals
from .two_wheeled import TIME_STEP, Wheeled

DRIFT_GOAL = (2.0, 1.0)
DRIFT_LIMIT = 0.8  # rad/s; the paper names one value, its robot's
ROBOT_DRIFT, ROBOT_TRIALS = -0.65, 5  # Section 4.2's robot: its drift, its trajectories to adapt on
LITERAL_LIMIT = 0.7  # rad per step; at 0.75 the drift turns the robot as fast as it can steer

Drift = TypeVar("Drift", float, Tensor)


@dataclass(frozen=True)
class TwoWheeledDrift(Wheeled):
    """The paper's TwoWheeled Locomotion with changing dynamics (appendix B, Environments).

    ## Description
    The same robot, slower, with one goal at (2, 1) for all tasks; what changes, and is not seen, is
    how fast it turns by itself. A step lasts dT = 0.5 s.

    ## Observation space
    === ============================= ======= ====== =============
    Num Observation                   Min     Max    Unit
    === ============================= ======= ====== =============
    0   x of the robot                -2.575  2.575  length units
    1   y of the robot                -2.575  2.575  length units
    2   heading theta, not wrapped    -115    115    radians
    === ============================= ======= ====== =============

    ## Action space
    === ======================== === === ======================================
    Num Action                   Min Max Stands for
    === ======================== === === ======================================
    0   linear velocity v        -1  1   0 to 0.15 length units per second
    1   angular velocity omega   -1  1   -1.5 to 1.5 radians per second
    === ======================== === === ======================================

    ## Rewards
    As in TwoWheeled, with 0.1 in place of 0.2.

    ## Starting state
    The origin, heading along x.

    ## Episode end
    Terminated within 0.1 of the goal in x and in y, and outside the arena |x|, |y| <= 2.5; truncated
    after 100 steps.

    ## Tasks and options
    A task is the residual angular velocity omega_g, at most 0.8 radians per second either way: 9
    to train on, evenly spread (the paper names none of its nine), others drawn uniformly. ``reward``,
    ``heading`` and ``largest_drift`` as below; InputError for what cannot be used.
    """

    largest_drift: float = DRIFT_LIMIT
    """The largest drift of any task, either way."""

    name = "two_wheeled_drift"
    task_dim = 1
    v_limit = 0.15
    omega_limit = 1.5
    reached_box = 0.1
    drift_limit = DRIFT_LIMIT
    drift_unit = "rad/s"

    def __post_init__(self) -> None:
        super().__post_init__()
        real_number("largest_drift", self.largest_drift, 0.0, self.drift_limit)

    def training_tasks(self) -> Tasks:
        """Return 9 residual angular velocities, evenly spread from the largest to its opposite."""
        return torch.linspace(-self.largest_drift, self.largest_drift, 9)[:, None]

    def sample_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return residual angular velocities drawn uniformly within the same limits."""
        limits = (-self.largest_drift, self.largest_drift)
        drawn = random.uniform(*limits, (positive_count("tasks", count), 1))
        return torch.tensor(drawn, dtype=torch.float32)

    def check_tasks(self, tasks: Tensor) -> Tasks:
        """Return drifts (task, 1) unless one is larger than the largest of the environment."""
        name = type(self).__name__
        shaped(f"{name} drifts", tasks, ("task", 1))
        wrong = tasks[:, 0].abs() > self.largest_drift + 1e-6
        expected = f"a residual angular velocity within {self.largest_drift} {self.drift_unit} of 0"
        return refuse_wrong(name, tasks, wrong, expected)

    def _largest_turn(self) -> float:
        return self.omega_limit * TIME_STEP + self.drift_per_step(self.drift_limit)

    def _turn(self, tasks: Tasks, omega: PerEpisode) -> PerEpisode:
        return omega * TIME_STEP + self.drift_per_step(tasks[:, :1])  # the same for all episodes

    def drift_per_step(self, drift: Drift) -> Drift:
        """Return by how much a drift turns the robot in one step, radians."""
        return drift * TIME_STEP

    def _goals(self, tasks: Tasks) -> Goals:
        goal = torch.tensor(DRIFT_GOAL, dtype=tasks.dtype, device=tasks.device)
        return goal.expand(len(tasks), 2)


@dataclass(frozen=True)
class TwoWheeledLiteralDrift(TwoWheeledDrift):
    """The same with the formula as it is printed: theta' = theta + omega_g + omega dT.

    ## Description
    The units clash: a velocity is added to an angle. Read literally the drift acts in full in every
    step of half a second, twice as strongly as a rate; -0.65 takes 0.65 of the 0.75 radians that a
    step can steer.

    ## Observation space
    As in TwoWheeledDrift; the heading's bounds are -145 and 145.

    ## Action space
    As in TwoWheeledDrift.

    ## Rewards
    As in TwoWheeledDrift.

    ## Starting state
    The origin, heading along x.

    ## Episode end
    As in TwoWheeledDrift.

    ## Tasks and options
    A task is the turn omega_g per step, at most 0.7 radians either way: beyond 0.75 no steering can
    hold against it. Options as in TwoWheeledDrift.
    """

    largest_drift: float = LITERAL_LIMIT
    """The largest drift of any task, either way."""

    name = "two_wheeled_literal_drift"
    drift_limit = LITERAL_LIMIT
    drift_unit = "rad per step"

    def drift_per_step(self, drift: Drift) -> Drift:
        return drift

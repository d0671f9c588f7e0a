"""TwoWheeled Locomotion with changing dynamics: the same robot turns by itself, unseen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import torch
from torch import Tensor

from ..validation import check_choice, positive_count, shaped
from .base import PerEpisode, Tasks, refuse_wrong
from .goals import Goals
from .two_wheeled import TIME_STEP, Wheeled

DRIFT_GOAL = (2.0, 1.0)
DRIFT_LIMIT = 0.8  # rad/s; the paper names one value, -0.65

DriftRule = Literal["rate", "literal"]


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

    With ``drift_rule="literal"`` the heading's bounds are -155 and 155.

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
    A task is the residual angular velocity omega_g, within 0.8 radians per second of 0: 9 to train
    on, evenly spread (the paper names none of its nine), others drawn uniformly. ``reward`` and
    ``drift_rule`` as below; InputError for unknown ones.
    """

    drift_rule: DriftRule = "rate"
    """"rate": theta' = theta + (omega + omega_g) dT; "literal": theta + omega_g + omega dT, as printed."""

    name = "two_wheeled_drift"
    task_dim = 1
    v_limit = 0.15
    omega_limit = 1.5
    reached_box = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        check_choice("drift rule", self.drift_rule, get_args(DriftRule))

    def training_tasks(self) -> Tasks:
        """Return 9 residual angular velocities, evenly spread from -0.8 to 0.8 rad/s."""
        return torch.linspace(-DRIFT_LIMIT, DRIFT_LIMIT, 9)[:, None]

    def sample_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return residual angular velocities drawn uniformly within the same limits."""
        drawn = random.uniform(-DRIFT_LIMIT, DRIFT_LIMIT, (positive_count("tasks", count), 1))
        return torch.tensor(drawn, dtype=torch.float32)

    def check_tasks(self, tasks: Tensor) -> Tasks:
        """Return drifts (task, 1) unless one is larger than 0.8 rad/s."""
        shaped("TwoWheeledDrift drifts", tasks, ("task", 1))
        wrong = tasks[:, 0].abs() > DRIFT_LIMIT + 1e-6
        expected = f"a residual angular velocity within {DRIFT_LIMIT} rad/s of 0"
        return refuse_wrong("TwoWheeledDrift", tasks, wrong, expected)

    def _largest_turn(self) -> float:
        drift = DRIFT_LIMIT * (TIME_STEP if self.drift_rule == "rate" else 1.0)
        return self.omega_limit * TIME_STEP + drift

    def _turn(self, tasks: Tasks, omega: PerEpisode) -> PerEpisode:
        drift = tasks[:, :1]  # (task, 1), broadcast over episodes
        if self.drift_rule == "literal":
            return drift + omega * TIME_STEP
        return (omega + drift) * TIME_STEP

    def _goals(self, tasks: Tasks) -> Goals:
        goal = torch.tensor(DRIFT_GOAL, dtype=tasks.dtype, device=tasks.device)
        return goal.expand(len(tasks), 2)

"""Checks of the exercises, one module a notebook: ``check.<exercise>(student_function)``."""

from .notebook_01 import advantages, discounted_returns, log_density, reinforce_loss
from .notebook_04 import (
    assumption_numbers,
    break_the_substitution,
    likelihood_distance,
    performance_difference,
    visitation,
)
from .notebook_06 import adaptation_step, surrogate, warm_start_step

__all__ = [
    "adaptation_step",
    "advantages",
    "assumption_numbers",
    "break_the_substitution",
    "discounted_returns",
    "likelihood_distance",
    "log_density",
    "performance_difference",
    "reinforce_loss",
    "surrogate",
    "visitation",
    "warm_start_step",
]

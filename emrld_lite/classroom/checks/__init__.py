"""Checks of the exercises, one module per notebook: ``check.<exercise>(student_function)``."""

from .grades import require
from .notebook_01 import advantages, discounted_returns, log_density
from .notebook_01_gradient import best_constant, compare_baselines, policy_gradient
from .notebook_02 import episodes_needed, loitering_gain, point_step
from .notebook_02_experiments import agreement, steer
from .notebook_03 import misleading, nearest_distance, steps_before_reward, with_task
from .notebook_04 import assumption_numbers, performance_difference, visitation
from .notebook_04_designs import break_the_substitution, tight_step
from .notebook_05 import meta_gradient, supervised_meta_loss
from .notebook_05_trust_region import conjugate_gradient, full_step
from .notebook_06 import adaptation_step, surrogate
from .notebook_06_experiment import what_parts_add
from .notebook_06_iteration import meta_loss
from .notebook_07 import false_ahead_rate, seeds_needed
from .notebook_07_ranks import rank_interval
from .notebook_07_reading import hidden_by_mean, read_curves
from .notebook_08 import clean_pairs, own_experiment, which_sentence
from .notebook_09 import largest_gain, odometry, wheel_command
from .notebook_09_adaptation import one_adaptation
from .values import agree

__all__ = [
    "adaptation_step",
    "advantages",
    "agree",
    "agreement",
    "assumption_numbers",
    "best_constant",
    "break_the_substitution",
    "clean_pairs",
    "compare_baselines",
    "conjugate_gradient",
    "discounted_returns",
    "episodes_needed",
    "false_ahead_rate",
    "full_step",
    "hidden_by_mean",
    "largest_gain",
    "log_density",
    "loitering_gain",
    "meta_gradient",
    "meta_loss",
    "misleading",
    "nearest_distance",
    "odometry",
    "one_adaptation",
    "own_experiment",
    "performance_difference",
    "point_step",
    "policy_gradient",
    "rank_interval",
    "read_curves",
    "require",
    "seeds_needed",
    "steer",
    "steps_before_reward",
    "supervised_meta_loss",
    "surrogate",
    "tight_step",
    "visitation",
    "what_parts_add",
    "wheel_command",
    "which_sentence",
    "with_task",
]

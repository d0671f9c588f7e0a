"""The three losses: RL, behaviour cloning, and TRPO's surrogate; one number per task each."""

from __future__ import annotations

from typing import Literal

import torch

from .demonstrations import Demonstrations
from .policy import Gaussian, LogDensity, Params, distribution, log_density
from .rollout import PerStep, PerTask, Rollout

Reduction = Literal["mean", "sum"]
REDUCTION: Reduction = "mean"  # of the cloning loss, unless told otherwise


def task_mean(values: PerStep, mask: PerStep) -> PerTask:
    """Return the mean over each task's taken steps."""
    return (values * mask).sum((1, 2)) / mask.sum((1, 2))


def rl_loss(params: Params, rollout: Rollout, density: LogDensity = "joint") -> PerTask:
    """Return L^RL_i = -mean(log pi(a|s) A): its gradient is minus the policy gradient without gamma^t.

    ``rollout`` must carry advantages. Section 2, "Gradient-based meta-reinforcement learning".
    """
    log_prob = log_density(distribution(params, rollout.states), rollout.actions, density)
    return -task_mean(log_prob * rollout.advantages, rollout.mask)


def bc_loss(
    params: Params,
    demonstrations: Demonstrations,
    reduction: Reduction = REDUCTION,
    density: LogDensity = "joint",
) -> PerTask:
    """Return L^BC_i = -mean log pi(a|s) over task i's demonstration. Section 3.

    The paper writes a sum over the data (``reduction="sum"``), the released code takes the mean.
    """
    gaussian = distribution(params, demonstrations.states)
    log_prob = log_density(gaussian, demonstrations.actions, density)
    if reduction == "sum":
        return -(log_prob * demonstrations.mask).sum((1, 2))
    return -task_mean(log_prob, demonstrations.mask)


def surrogate_loss(new: Gaussian, old: Gaussian, rollout: Rollout) -> PerTask:
    """Return TRPO's surrogate -mean(pi_new/pi_old A) (Schulman et al., 2015)."""
    ratio = torch.exp(log_density(new, rollout.actions) - log_density(old, rollout.actions))
    return -task_mean(ratio * rollout.advantages, rollout.mask)

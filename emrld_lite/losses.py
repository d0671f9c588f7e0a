"""The three losses: RL, behaviour cloning, and TRPO's surrogate; one number a task each."""

from __future__ import annotations

import torch

from .demonstrations import Demonstrations
from .policy import Gaussian, Params, distribution, log_density
from .rollout import Rollout


def task_mean(values: torch.Tensor, mask: torch.Tensor) -> torch.Tensor:
    """Return the mean over each task's taken steps, (task,) from values (task, episode, time)."""
    return (values * mask).sum((1, 2)) / mask.sum((1, 2))


def rl_loss(params: Params, rollout: Rollout) -> torch.Tensor:
    """Return L^RL_i = -mean(log pi(a|s) A), (task,): its gradient is minus the policy gradient.

    ``rollout`` must carry advantages. Section 2, "Gradient-based meta-reinforcement learning".
    """
    log_prob = log_density(distribution(params, rollout.states), rollout.actions)
    return -task_mean(log_prob * rollout.advantages, rollout.mask)


def bc_loss(
    params: Params, demonstrations: Demonstrations, reduction: str = "mean"
) -> torch.Tensor:
    """Return L^BC_i = -mean log pi(a|s) over task i's demonstration, (task,). Section 3.

    The paper writes a sum over the data (``reduction="sum"``), the released code takes the mean.
    """
    log_prob = log_density(
        distribution(params, demonstrations.states), demonstrations.actions
    )  # (task, 1, time)
    if reduction == "sum":
        return -(log_prob * demonstrations.mask).sum((1, 2))
    return -task_mean(log_prob, demonstrations.mask)


def surrogate_loss(new: Gaussian, old: Gaussian, rollout: Rollout) -> torch.Tensor:
    """Return TRPO's surrogate -mean(pi_new/pi_old A), (task,) (Schulman et al., 2015)."""
    ratio = torch.exp(log_density(new, rollout.actions) - log_density(old, rollout.actions))
    return -task_mean(ratio * rollout.advantages, rollout.mask)

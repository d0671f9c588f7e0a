"""From rewards to advantages: returns, the linear baseline, GAE, normalisation.

All of it runs once per iteration: advantages do not depend on the policy's parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from .rollout import PerStep, Rollout
from .validation import real_number

RIDGE = 1e-5  # of the mean squared feature: small, yet enough for collinear features


def discounted_returns(rewards: PerStep, discount: float) -> PerStep:
    """Return G_t = R_t + discount G_{t+1}."""
    returns = torch.zeros_like(rewards)
    running = torch.zeros_like(rewards[..., 0])
    for time in reversed(range(rewards.shape[-1])):
        running = rewards[..., time] + discount * running
        returns[..., time] = running
    return returns


def baseline_features(rollout: Rollout) -> Float[Tensor, "task episode time feature"]:
    """Return (s, s*s, 0.01 t, (0.01 t)^2, (0.01 t)^3, 1), appendix C: 2 state + 4 features.

    ``t`` is the time index within the episode. Float64; zero where the mask is zero.
    """
    states = rollout.states.double()
    time = 0.01 * torch.arange(states.shape[2], device=states.device, dtype=torch.float64)
    clock = torch.stack([time, time**2, time**3, torch.ones_like(time)], dim=-1)
    clock = clock.expand(*states.shape[:3], 4)
    features = torch.cat([states, states * states, clock], dim=-1)
    return features * rollout.mask[..., None]


def fit_baseline(
    features: Float[Tensor, "task episode time feature"],
    returns: PerStep,
) -> Float[Tensor, "task feature"]:
    """Return each task's ridge least-squares weights, float64.

    Solved by QR on the features with the ridge's rows appended, which is as accurate as the data
    allow.
    """
    design = features.flatten(1, 2)  # (task, sample, feature)
    target = returns.double().flatten(1, 2)[..., None]  # (task, sample, 1)
    size = design.shape[-1]
    strength = (RIDGE * design.square().sum((1, 2)) / size).clamp_min(RIDGE).sqrt()  # (task,)
    ridge = strength[:, None, None] * torch.eye(size, dtype=design.dtype, device=design.device)
    design = torch.cat([design, ridge], dim=1)
    target = torch.cat([target, target.new_zeros(len(target), size, 1)], dim=1)
    return torch.linalg.lstsq(design, target, driver="gels").solution[..., 0]


def linear_baseline(rollout: Rollout, discount: float) -> PerStep:
    """Return the fitted values V(s_t), zero where the mask is zero."""
    features = baseline_features(rollout)
    weights = fit_baseline(features, discounted_returns(rollout.rewards, discount))
    return torch.einsum("netf,nf->net", features, weights).to(rollout.rewards.dtype)


def generalised_advantage(
    rewards: PerStep,
    values: PerStep,
    discount: float,
    gae_lambda: float,
) -> PerStep:
    """Return GAE (Schulman et al., 2016).

    ``values`` must be zero after an episode's end: nothing is bootstrapped past the last step.
    """
    following = torch.cat([values[..., 1:], torch.zeros_like(values[..., :1])], dim=-1)
    residuals = rewards + discount * following - values
    return discounted_returns(residuals, discount * gae_lambda)


def normalise(values: PerStep, mask: PerStep) -> PerStep:
    """Return values with mean 0 and standard deviation 1 over each task's steps; all zeros stay zero."""
    count = mask.sum((1, 2), keepdim=True)
    mean = (values * mask).sum((1, 2), keepdim=True) / count
    centred = (values - mean) * mask
    deviation = (centred.square().sum((1, 2), keepdim=True) / count).sqrt()
    return centred / (deviation + 1e-8)


@dataclass(frozen=True)
class Score:
    """From rewards to the advantages that learning sees; the defaults are Table 1's.

    Raises InputError for numbers that cannot be used.
    """

    discount: float = 0.95
    """gamma (Table 1)."""
    gae_lambda: float = 1.0
    """GAE's lambda, which Table 1 calls tau."""
    normalise: bool = True
    """Whether each task's advantages are scaled to mean 0 and deviation 1."""
    reward_elsewhere: float = 0.0
    """What learning sees in place of a reward of zero (released code: 1e-5)."""

    def __post_init__(self) -> None:
        real_number("discount", self.discount, 0.0, 1.0)
        real_number("gae_lambda", self.gae_lambda, 0.0, 1.0)
        real_number("reward_elsewhere", self.reward_elsewhere)

    def __call__(self, rollout: Rollout) -> Rollout:
        """Return the rollout with its advantage estimates, zero after the end; its rewards stay."""
        seen = rollout
        if self.reward_elsewhere:
            unpaid = (rollout.rewards == 0.0) * rollout.mask
            seen = rollout._replace(rewards=rollout.rewards + self.reward_elsewhere * unpaid)
        values = linear_baseline(seen, self.discount)
        raw = generalised_advantage(seen.rewards, values, self.discount, self.gae_lambda)
        raw = raw * rollout.mask
        return rollout._replace(advantages=normalise(raw, rollout.mask) if self.normalise else raw)

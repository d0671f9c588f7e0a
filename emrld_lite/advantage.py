"""From rewards to advantages: returns, the linear baseline, GAE, normalisation.

All of it runs once an iteration: advantages do not depend on the policy's parameters.
"""

from __future__ import annotations

import torch

from .rollout import Rollout

RIDGE = 1e-5  # of the mean squared feature: small, yet enough for collinear features


def discounted_returns(rewards: torch.Tensor, discount: float) -> torch.Tensor:
    """Return G_t = R_t + discount G_{t+1}, (task, episode, time), from rewards of the same shape."""
    returns = torch.zeros_like(rewards)
    running = torch.zeros_like(rewards[..., 0])
    for time in reversed(range(rewards.shape[-1])):
        running = rewards[..., time] + discount * running
        returns[..., time] = running
    return returns


def baseline_features(rollout: Rollout) -> torch.Tensor:
    """Return (s, s*s, 0.01 t, (0.01 t)^2, (0.01 t)^3, 1), appendix C; (task, episode, time, 2 state + 4).

    ``t`` is the time index within the episode. Float64; zero where the mask is zero.
    """
    states = rollout.states.double()
    time = 0.01 * torch.arange(states.shape[2], device=states.device, dtype=torch.float64)
    clock = torch.stack([time, time**2, time**3, torch.ones_like(time)], dim=-1)
    clock = clock.expand(*states.shape[:3], 4)
    features = torch.cat([states, states * states, clock], dim=-1)
    return features * rollout.mask[..., None]


def fit_baseline(features: torch.Tensor, returns: torch.Tensor) -> torch.Tensor:
    """Return each task's ridge least-squares weights, (task, feature), float64.

    Solved by QR on the features with the ridge's rows appended, which is as accurate as the data
    allow; ``features`` is (task, episode, time, feature), ``returns`` (task, episode, time).
    """
    design = features.flatten(1, 2)  # (task, sample, feature)
    target = returns.double().flatten(1, 2)[..., None]  # (task, sample, 1)
    size = design.shape[-1]
    strength = (RIDGE * design.square().sum((1, 2)) / size).clamp_min(RIDGE).sqrt()  # (task,)
    ridge = strength[:, None, None] * torch.eye(size, dtype=design.dtype, device=design.device)
    design = torch.cat([design, ridge], dim=1)
    target = torch.cat([target, target.new_zeros(len(target), size, 1)], dim=1)
    return torch.linalg.lstsq(design, target, driver="gels").solution[..., 0]


def linear_baseline(rollout: Rollout, discount: float) -> torch.Tensor:
    """Return the fitted values V(s_t), (task, episode, time), zero where the mask is zero."""
    features = baseline_features(rollout)
    weights = fit_baseline(features, discounted_returns(rollout.rewards, discount))
    return torch.einsum("netf,nf->net", features, weights).to(rollout.rewards.dtype)


def generalised_advantage(
    rewards: torch.Tensor, values: torch.Tensor, discount: float, gae_lambda: float
) -> torch.Tensor:
    """Return GAE (Schulman et al., 2016), (task, episode, time).

    ``values`` must be zero after an episode's end: nothing is bootstrapped past the last step.
    """
    following = torch.cat([values[..., 1:], torch.zeros_like(values[..., :1])], dim=-1)
    residuals = rewards + discount * following - values
    return discounted_returns(residuals, discount * gae_lambda)


def normalise(values: torch.Tensor, mask: torch.Tensor) -> torch.Tensor:
    """Return values with mean 0 and standard deviation 1 over each task's steps; all zeros stay zero."""
    count = mask.sum((1, 2), keepdim=True)
    mean = (values * mask).sum((1, 2), keepdim=True) / count
    centred = (values - mean) * mask
    deviation = (centred.square().sum((1, 2), keepdim=True) / count).sqrt()
    return centred / (deviation + 1e-8)


def with_advantages(
    rollout: Rollout, discount: float, gae_lambda: float, normalised: bool = True
) -> Rollout:
    """Return the rollout with its advantage estimates, (task, episode, time), zero after the end."""
    values = linear_baseline(rollout, discount)
    raw = generalised_advantage(rollout.rewards, values, discount, gae_lambda) * rollout.mask
    return rollout._replace(advantages=normalise(raw, rollout.mask) if normalised else raw)

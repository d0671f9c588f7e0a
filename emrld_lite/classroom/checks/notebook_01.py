"""Checks of notebook 01: policies."""

from __future__ import annotations

import math

import torch

from .answers import Student, Wrong, answered, as_tensor, close, draws


@answered
def log_density(student: Student) -> None:
    """Check log N(a; mu, sigma) of a joint action: f(mean, log_sigma, actions) -> (...)."""
    normal = draws(1)
    mean, log_sigma, actions = normal(5, 3), 0.5 * normal(5, 3), normal(5, 3)
    got = student(mean, log_sigma, actions)
    if isinstance(got, torch.Tensor) and got.shape == (5, 3):
        raise Wrong(
            "you return one number per action dimension. The dimensions are independent, so the "
            "joint log-density is their sum over the last axis."
        )
    got = as_tensor(got, (5,), "one log-density per sample")
    squared = ((actions - mean) / log_sigma.exp()) ** 2
    constant = 0.5 * math.log(2 * math.pi)
    each = -0.5 * squared - log_sigma - constant
    if close(got, each.sum(-1)):
        return
    if close(got, each.mean(-1)):
        raise Wrong("you average over the action dimensions; a product of densities sums its logs.")
    if close(got, (each + constant).sum(-1)):
        raise Wrong("the constant -log(2 pi)/2 of each dimension is missing.")
    if close(got, (each + log_sigma).sum(-1)):
        raise Wrong("the normaliser -log sigma is missing: wide distributions are lower.")
    if close(got, (-0.5 * (actions - mean) ** 2 / log_sigma.exp() - log_sigma - constant).sum(-1)):
        raise Wrong("you divide the squared distance by sigma; it is sigma squared.")
    if close(got, each.sum(-1).exp()):
        raise Wrong("that is the density itself; return its logarithm.")
    raise Wrong("the numbers differ. Write the density of one dimension on paper, then take logs.")


@answered
def discounted_returns(student: Student) -> None:
    """Check G_t of ragged episodes: f(rewards (episode, time), discount) -> (episode, time)."""
    rewards, discount = draws(2)(4, 7), 0.9
    kept = rewards.clone()
    got = as_tensor(student(rewards, discount), (4, 7), "one return per step")
    if not torch.equal(rewards, kept):
        raise Wrong("your function changed the rewards it was given. Write into a new tensor.")
    powers = discount ** torch.arange(7, dtype=torch.float64)
    expected = torch.stack([(rewards[:, t:] * powers[: 7 - t]).sum(-1) for t in range(7)], dim=1)
    if close(got, expected):
        return
    if close(got, torch.stack([(rewards * powers)[:, t:].sum(-1) for t in range(7)], dim=1)):
        raise Wrong("you discount from the episode's start; G_t discounts from time t on.")
    if close(got, rewards.flip(-1).cumsum(-1).flip(-1)):
        raise Wrong("these are undiscounted sums: where does gamma come in?")
    if close(got, torch.stack([(rewards[:, : t + 1]).sum(-1) for t in range(7)], dim=1)):
        raise Wrong("you sum the past; G_t sums the future, from t to the end.")
    if close(got[:, :-1], discount * expected[:, 1:]) and close(got[:, -1:], 0 * got[:, -1:]):
        raise Wrong("the reward R_t itself is missing: your sum starts at t + 1.")
    raise Wrong("the numbers differ. Try one episode by hand: rewards (0, 0, 1), gamma 0.9.")


@answered
def reinforce_loss(student: Student) -> None:
    """Check -mean(log pi * G): f(log_probs (episode, time), returns, mask) -> scalar, and its gradient."""
    normal = draws(3)
    log_probs, returns = normal(3, 5).requires_grad_(), normal(3, 5)
    mask = torch.tensor([[1, 1, 1, 1, 1], [1, 1, 0, 0, 0], [1, 0, 0, 0, 0]], dtype=torch.float64)
    got = student(log_probs, returns, mask)
    value = as_tensor(got, (), "a single number")
    if got.grad_fn is None:
        raise Wrong("the loss has no gradient: is there a `.detach()` or `.item()` in it?")
    gradient = torch.autograd.grad(got, log_probs)[0]
    expected = -(returns * mask) / mask.sum()
    total = (log_probs.detach() * returns * mask).sum()
    if close(gradient, expected) and close(value, -total / mask.sum()):
        return
    if close(gradient, -expected):
        raise Wrong("the sign is turned: a loss goes down, and the return is to go up.")
    if close(gradient, -returns / returns.numel()):
        raise Wrong("steps after an episode's end count too: use the mask.")
    if close(gradient, -(returns * mask) / mask.numel()):
        raise Wrong("you divide by all entries; the mean is over the steps that were taken.")
    if close(gradient, -(returns * mask)):
        raise Wrong("you return the sum; the workbook's losses are means over the steps taken.")
    raise Wrong(
        "the numbers differ. It is one line: a masked mean of log pi times G, with a minus."
    )


@answered
def advantages(student: Student) -> None:
    """Check GAE: f(rewards, values, discount, gae_lambda), all (episode, time), -> (episode, time)."""
    normal = draws(4)
    rewards, values = normal(3, 6), normal(3, 6)
    discount, gae_lambda = 0.9, 0.7
    got = as_tensor(
        student(rewards, values, discount, gae_lambda), (3, 6), "one advantage per step"
    )
    following = torch.cat([values[:, 1:], torch.zeros(3, 1, dtype=torch.float64)], dim=1)

    def summed(residuals: torch.Tensor, rate: float) -> torch.Tensor:
        powers = rate ** torch.arange(6, dtype=torch.float64)
        parts = [(residuals[:, t:] * powers[: 6 - t]).sum(-1) for t in range(6)]
        return torch.stack(parts, dim=1)

    residuals = rewards + discount * following - values
    if close(got, summed(residuals, discount * gae_lambda)):
        return
    if close(got, summed(residuals, gae_lambda)):
        raise Wrong("the residuals are summed with (gamma lambda)^k, not with lambda^k.")
    if close(got, summed(residuals, discount)):
        raise Wrong("lambda is missing: that is the case lambda = 1.")
    if close(got, residuals):
        raise Wrong("these are the one-step residuals, the case lambda = 0; sum them up.")
    if close(got, summed(rewards + following - values, discount * gae_lambda)):
        raise Wrong("the next state's value must be discounted in each residual.")
    wrapped = torch.cat([values[:, 1:], values[:, :1]], dim=1)
    if close(got, summed(rewards + discount * wrapped - values, discount * gae_lambda)):
        raise Wrong("after the last step the value is 0; yours comes from the episode's start.")
    raise Wrong("the numbers differ. Check the residual R_t + gamma V(s_{t+1}) - V(s_t) first.")

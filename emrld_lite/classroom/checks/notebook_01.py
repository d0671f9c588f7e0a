"""Checks of notebook 01: density, returns and GAE, in single precision, as the notebook's numbers are."""

from __future__ import annotations

import math

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_graph, as_tensor, close, draws, judge, pulled_back

SINGLE = torch.float32
CONSTANT = 0.5 * math.log(2 * math.pi)


@answered
def log_density(student: Student) -> None:
    """Check log N(a; mu, sigma) of a joint action: f(mean, log_sigma, actions) -> (...)."""
    for seed, shape in enumerate(((5, 3), (2, 4, 2), (6, 1), (3, 3)), start=1):
        normal = draws(seed, SINGLE)
        given = normal(*shape), 0.5 * normal(*shape), normal(*shape)
        got = ask(student, *given).answer
        if isinstance(got, torch.Tensor) and got.shape == shape:
            raise Wrong(
                "you return one number per action dimension. The dimensions are independent, so "
                "the joint log-density is their sum over the last axis."
            )
        value = as_tensor(got, shape[:-1], "one log-density per sample")
        _judge_log_density(value, *(part.double() for part in given))
        _log_density_gradient(student, given)


def _judge_log_density(
    value: torch.Tensor, mean: torch.Tensor, log_sigma: torch.Tensor, actions: torch.Tensor
) -> None:
    """Compare the log-density; name the mistake that it equals."""
    gap = actions - mean
    each = -0.5 * (gap / log_sigma.exp()) ** 2 - log_sigma - CONSTANT
    mistakes = {
        "you average over the action dimensions; a product of densities sums its logs.": (
            each.mean(-1)
        ),
        "the constant -log(2 pi)/2 of each dimension is missing.": (each + CONSTANT).sum(-1),
        "the constant is subtracted once for each dimension, not once in all.": (
            (each + CONSTANT).sum(-1) - CONSTANT
        ),
        "the constant is half of log(2 pi), with a minus.": (each - CONSTANT).sum(-1),
        "the constant -log(2 pi)/2 has the wrong sign.": (each + 2 * CONSTANT).sum(-1),
        "the normaliser -log sigma is missing: wide distributions are lower.": (
            (each + log_sigma).sum(-1)
        ),
        "the sign of log sigma is turned: wide distributions are lower.": (
            (each + 2 * log_sigma).sum(-1)
        ),
        "you divide the squared distance by sigma; it is sigma squared.": (
            (-0.5 * gap**2 / log_sigma.exp() - log_sigma - CONSTANT).sum(-1)
        ),
        "you are given the logarithm of sigma: take its exponential before you divide.": (
            (-0.5 * (gap / log_sigma) ** 2 - log_sigma - CONSTANT).sum(-1)
        ),
        "the half in front of the squared distance is missing.": (
            (each - 0.5 * (gap / log_sigma.exp()) ** 2).sum(-1)
        ),
        "the squared distance lowers the density: its sign is turned.": (
            (each + (gap / log_sigma.exp()) ** 2).sum(-1)
        ),
        "that is the density itself; return its logarithm.": each.sum(-1).exp(),
        "the sign is turned: that is minus the log-density.": -each.sum(-1),
    }
    hint = "the numbers differ. Write the density of one dimension on paper, then take logs."
    judge(value, each.sum(-1), mistakes, hint)


def _log_density_gradient(student: Student, given: tuple[torch.Tensor, ...]) -> None:
    """Compare the gradient by mean and log sigma, which every loss needs."""
    leaves = tuple(part.clone().requires_grad_() for part in given[:2])
    asked = ask(student, *leaves, given[2])
    weights = draws(99)(*given[0].shape[:-1])
    output = as_graph(asked.answer, tuple(weights.shape), "one log-density per sample")
    mean, log_sigma, actions = (part.double() for part in given)
    standardised = (actions - mean) / log_sigma.exp()
    exact = (standardised / log_sigma.exp(), standardised**2 - 1)
    for leaf, slope, name in zip(asked.given, exact, ("mean", "log sigma"), strict=False):
        cut = f"right numbers, but without a gradient by the {name}: is there a `.detach()` in it?"
        if not close(pulled_back(output, leaf, weights, cut), slope * weights[..., None]):
            raise Wrong(
                f"right numbers, but the gradient by the {name} is off: is a part detached?"
            )


@answered
def discounted_returns(student: Student) -> None:
    """Check G_t of whole episodes: f(rewards (episode, time), discount) -> (episode, time)."""
    for seed, (episodes, horizon, discount) in enumerate(
        ((4, 7, 0.9), (3, 14, 0.97), (2, 5, 0.6), (5, 5, 1.0), (1, 1, 0.8)), start=2
    ):
        rewards = draws(seed, SINGLE)(episodes, horizon)
        got = ask(student, rewards, discount).answer
        value = as_tensor(got, (episodes, horizon), "one return per step")
        _judge_returns(value, rewards.double(), discount)


def _to_come(values: torch.Tensor, rate: float) -> torch.Tensor:
    """Return the sums of values from each step on, discounted from there, (episode, time)."""
    horizon = values.shape[1]
    powers = rate ** torch.arange(horizon, dtype=torch.float64)
    parts = [(values[:, t:] * powers[: horizon - t]).sum(-1) for t in range(horizon)]
    return torch.stack(parts, dim=1)


def _judge_returns(value: torch.Tensor, rewards: torch.Tensor, discount: float) -> None:
    """Compare the returns; name the mistake that they equal."""
    expected = _to_come(rewards, discount)
    powers = discount ** torch.arange(rewards.shape[1], dtype=torch.float64)
    nothing = torch.zeros_like(rewards[:, :1])
    after = torch.cat([expected[:, 1:], nothing], dim=1)
    mistakes = {
        "you discount from the episode's start; G_t discounts from time t on.": (
            _to_come(rewards * powers, 1.0)
        ),
        "these are undiscounted sums: where does gamma come in?": _to_come(rewards, 1.0),
        "you sum the past; G_t sums the future, from t to the end.": rewards.cumsum(-1),
        "you discount the past; G_t sums the future, from t to the end.": (
            _to_come(rewards.flip(1), discount).flip(1)
        ),
        "the reward R_t itself is missing: your sum starts at t + 1.": discount * after,
        "the reward R_t itself is missing, your sum starts at t + 1.": after,
        "the reward R_t itself is not discounted: gamma multiplies what follows.": (
            discount * expected
        ),
        "only the next reward is added: G_{t+1}, the whole return that follows, belongs there.": (
            rewards + discount * torch.cat([rewards[:, 1:], nothing], dim=1)
        ),
    }
    hint = "the numbers differ. Try one episode by hand: rewards (0, 0, 1), gamma 0.9."
    judge(value, expected, mistakes, hint)


@answered
def advantages(student: Student) -> None:
    """Check GAE: f(rewards, values, discount, gae_lambda), all (episode, time), -> (episode, time)."""
    for seed, (episodes, horizon, discount, gae_lambda) in enumerate(
        ((3, 6, 0.9, 0.7), (4, 9, 0.8, 0.95), (2, 3, 0.95, 1.0), (5, 5, 0.7, 0.3)), start=4
    ):
        normal = draws(seed, SINGLE)
        rewards, values = normal(episodes, horizon), normal(episodes, horizon)
        got = ask(student, rewards, values, discount, gae_lambda).answer
        value = as_tensor(got, (episodes, horizon), "one advantage per step")
        _judge_advantages(value, rewards.double(), values.double(), discount, gae_lambda)


def _judge_advantages(
    got: torch.Tensor,
    rewards: torch.Tensor,
    values: torch.Tensor,
    discount: float,
    gae_lambda: float,
) -> None:
    """Compare the advantages; name the mistake that they equal."""

    def ahead(last: torch.Tensor) -> torch.Tensor:
        return torch.cat([values[:, 1:], last], dim=1)

    def summed(following: torch.Tensor, own: torch.Tensor = values) -> torch.Tensor:
        return _to_come(rewards + discount * following - own, discount * gae_lambda)

    following = ahead(torch.zeros_like(values[:, :1]))
    residuals = rewards + discount * following - values
    before = torch.cat([torch.zeros_like(values[:, :1]), values[:, :-1]], dim=1)
    mistakes = {
        "the residuals are summed with (gamma lambda)^k, not with lambda^k.": (
            _to_come(residuals, gae_lambda)
        ),
        "lambda is missing: that is the case lambda = 1.": _to_come(residuals, discount),
        "the residuals are summed with (gamma lambda)^k; you add them undamped.": (
            _to_come(residuals, 1.0)
        ),
        "these are the one-step residuals, the case lambda = 0; sum them up.": residuals,
        "the next state's value must be discounted in each residual.": (
            _to_come(rewards + following - values, discount * gae_lambda)
        ),
        "after the last step the value is 0; yours comes from the episode's start.": (
            summed(ahead(values[:, :1]))
        ),
        "after the last step the value is 0; yours repeats the last state's.": (
            summed(ahead(values[:, -1:]))
        ),
        "the state's own value must be taken away in each residual.": (
            summed(following, torch.zeros_like(values))
        ),
        "the next state's value is missing in each residual.": summed(torch.zeros_like(values)),
        "the value that follows is V(s_{t+1}); yours is the one before.": summed(before),
        "the sign is turned: what happens less what was expected.": -summed(following),
    }
    hint = "the numbers differ. Check the residual R_t + gamma V(s_{t+1}) - V(s_t) first."
    judge(got, summed(following), mistakes, hint)

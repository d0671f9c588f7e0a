"""Checks of the exercises: each compares with its own reference on random inputs, and answers in a sentence.

A check never trusts the student's objects and never changes them. It raises nothing: the answer is
printed, and returned as True or False.
"""

from __future__ import annotations

import functools
import math
import traceback
from collections.abc import Callable
from typing import Any

import torch

Student = Callable[..., Any]


class Wrong(Exception):
    """A wrong answer, with the sentence that says so."""


def answered(check: Callable[[Student], None]) -> Callable[[Student], bool]:
    """Turn a check that raises Wrong into one that prints its verdict and returns it."""

    @functools.wraps(check)
    def verdict(student: Student) -> bool:
        try:
            check(student)
        except Wrong as wrong:
            print(f"Not yet: {wrong}")
            return False
        except NotImplementedError:
            print("Not yet: the function is still blank. Replace `raise NotImplementedError`.")
            return False
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            print(
                f"Not yet: your function stopped with {type(error).__name__}: {error} "
                f"(line: {where.line})"
            )
            return False
        print(f"Correct: {check.__name__.replace('_', ' ')}.")
        return True

    return verdict


def as_tensor(value: Any, shape: tuple[int, ...], what: str) -> torch.Tensor:
    """Return the student's value if it is a tensor of ``shape``; otherwise raise Wrong."""
    if value is None:
        raise Wrong(f"your function returned None. Does it end with `return`? Expected {what}.")
    if not isinstance(value, torch.Tensor):
        raise Wrong(f"expected {what} as a tensor, got {type(value).__name__}.")
    if value.shape != shape:
        raise Wrong(f"expected {what} of shape {tuple(shape)}, got {tuple(value.shape)}.")
    return value.detach().double()


def close(one: torch.Tensor, other: torch.Tensor, tolerance: float = 1e-6) -> bool:
    """Return whether two tensors of one shape agree to ``tolerance``, relative to their size."""
    scale = max(1.0, float(other.abs().max()))
    return bool(torch.isfinite(one).all()) and float((one - other).abs().max()) <= tolerance * scale


def draws(seed: int) -> Callable[..., torch.Tensor]:
    """Return a function that draws standard normal float64 tensors."""
    random = torch.Generator().manual_seed(seed)
    return lambda *shape: torch.randn(*shape, generator=random, dtype=torch.float64)


# --- notebook 01 ----------------------------------------------------------------------------------


@answered
def log_density(student: Student) -> None:
    """Check log N(a; mu, sigma) of a joint action: f(mean, log_sigma, actions) -> (...)."""
    normal = draws(1)
    mean, log_sigma, actions = normal(5, 3), 0.5 * normal(5, 3), normal(5, 3)
    got = student(mean, log_sigma, actions)
    if isinstance(got, torch.Tensor) and got.shape == (5, 3):
        raise Wrong(
            "you return one number an action dimension. The dimensions are independent, so the "
            "joint log-density is their sum over the last axis."
        )
    got = as_tensor(got, (5,), "one log-density a sample")
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
    got = as_tensor(student(rewards, discount), (4, 7), "one return a step")
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
    got = as_tensor(student(rewards, values, discount, gae_lambda), (3, 6), "one advantage a step")
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


# --- notebook 06 ----------------------------------------------------------------------------------


def _quadratic(normal: Callable[..., torch.Tensor]) -> tuple[Callable, Callable, torch.Tensor]:
    """Return two random quadratic losses on 4 parameters, and a point."""
    matrices = [m @ m.T / 4 for m in (normal(4, 4), normal(4, 4))]
    offsets = [normal(4), normal(4)]

    def loss(which: int) -> Callable[[torch.Tensor], torch.Tensor]:
        return lambda theta: 0.5 * theta @ matrices[which] @ theta + offsets[which] @ theta

    return loss(0), loss(1), normal(4)


@answered
def adaptation_step(student: Student) -> None:
    """Check equation (adapt_rl_bc): f(theta, rl_loss, bc_loss, w_rl, w_bc, alpha) -> theta_i."""
    rl_loss, bc_loss, start = _quadratic(draws(5))
    theta = start.clone().requires_grad_()
    w_rl, w_bc, alpha = 0.3, 0.8, 0.1
    got = student(theta, rl_loss, bc_loss, w_rl, w_bc, alpha)
    value = as_tensor(got, (4,), "the adapted parameters")

    def stepped(one: float, other: float) -> torch.Tensor:
        point = start.clone().requires_grad_()
        total = one * rl_loss(point) + other * bc_loss(point)
        return start - alpha * torch.autograd.grad(total, point)[0]

    expected = stepped(w_rl, w_bc)
    if not torch.equal(theta.detach(), start):
        raise Wrong("you changed theta in place; every task must start from the same theta.")
    if not close(value, expected):
        if close(value, 2 * start - expected):
            raise Wrong("you climb the loss: the step goes against the gradient.")
        if close(value, stepped(w_bc, w_rl)):
            raise Wrong("the weights are swapped: w_rl belongs to the RL loss.")
        if close(value, stepped(1.0, 1.0)):
            raise Wrong("the weights w_rl and w_bc are missing.")
        if close(value, start - (start - expected) / alpha):
            raise Wrong("the learning rate alpha is missing.")
        raise Wrong("the numbers differ. Take one gradient of the weighted sum, at theta.")
    if got.grad_fn is None:
        raise Wrong("right numbers, but cut from theta: the meta-gradient could not flow back.")
    direction = torch.ones(4, dtype=torch.float64)
    through = torch.autograd.grad(got @ direction, theta)[0]
    if close(through, direction):
        raise Wrong(
            "right numbers, but the meta-gradient is first-order: it does not see that the "
            "adaptation's own gradient depends on theta. Use create_graph=True."
        )


@answered
def warm_start_step(student: Student) -> None:
    """Check EMRLD-WS: f(theta, rl_loss, bc_loss, w_rl, w_bc, alpha) -> theta_i, two steps in a row."""
    rl_loss, bc_loss, start = _quadratic(draws(6))
    theta = start.clone().requires_grad_()
    w_rl, w_bc, alpha = 0.3, 0.8, 0.1
    got = student(theta, rl_loss, bc_loss, w_rl, w_bc, alpha)
    value = as_tensor(got, (4,), "the adapted parameters")

    def gradient(loss: Callable, at: torch.Tensor) -> torch.Tensor:
        point = at.clone().requires_grad_()
        return torch.autograd.grad(loss(point), point)[0]

    def both(theta: torch.Tensor) -> torch.Tensor:
        return w_rl * rl_loss(theta) + w_bc * bc_loss(theta)

    warm = start - alpha * gradient(bc_loss, start)
    if close(value, warm - alpha * gradient(both, warm)):
        if got.grad_fn is None:
            raise Wrong("right numbers, but cut from theta: the meta-gradient could not flow back.")
        return
    if close(value, start - alpha * gradient(both, start)):
        raise Wrong("that is EMRLD: the cloning step that comes first is missing.")
    if close(value, warm):
        raise Wrong("that is the warm start alone: the adaptation step must follow it.")
    if close(value, start - alpha * gradient(both, warm)):
        raise Wrong("the second step must start from the warm-started parameters, not from theta.")
    if close(value, warm - alpha * gradient(both, start)):
        raise Wrong("the second gradient must be taken at the warm-started parameters.")
    weighted = start - alpha * w_bc * gradient(bc_loss, start)
    if close(value, weighted - alpha * gradient(both, weighted)):
        raise Wrong("the paper's warm start has no weight: one plain step on L^BC.")
    raise Wrong("the numbers differ. First one step on L^BC alone, then the step of EMRLD.")


@answered
def surrogate(student: Student) -> None:
    """Check TRPO's surrogate: f(new_log_prob, old_log_prob, advantages, mask) -> scalar loss."""
    normal = draws(7)
    old = normal(3, 5)
    new = (old + 0.3 * normal(3, 5)).requires_grad_()
    advantage = normal(3, 5)
    mask = torch.tensor([[1, 1, 1, 1, 1], [1, 1, 1, 0, 0], [1, 0, 0, 0, 0]], dtype=torch.float64)
    got = student(new, old, advantage, mask)
    value = as_tensor(got, (), "a single number")
    ratio = (new.detach() - old).exp()
    expected = -(ratio * advantage * mask).sum() / mask.sum()
    if close(value, expected):
        if got.grad_fn is None:
            raise Wrong("right number, but it has no gradient: is there a `.detach()` in it?")
        return
    if close(value, -expected):
        raise Wrong("the sign is turned: the surrogate loss is minus the weighted advantage.")
    if close(value, -((new.detach() - old) * advantage * mask).sum() / mask.sum()):
        raise Wrong("the ratio of densities is the exponential of the difference of their logs.")
    if close(value, -(advantage * mask / ratio).sum() / mask.sum()):
        raise Wrong("the ratio is upside down: new over old.")
    if close(value, -(ratio * advantage).mean()):
        raise Wrong("steps after an episode's end count too: use the mask.")
    raise Wrong("the numbers differ. The ratio pi_new/pi_old weighs each advantage.")

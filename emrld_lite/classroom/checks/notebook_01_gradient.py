"""Checks of notebook 01: the policy gradient, its noise under several baselines, the best constant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number, as_parts, as_tensor, close, draws, judge

SINGLE = torch.float32


@answered
def policy_gradient(student: Student) -> None:
    """Check dJ/dmu per episode: f(actions (episode, time), returns, mean, sigma, discount)."""
    for seed, (episodes, horizon, mean, sigma, discount) in enumerate(
        ((4, 6, 0.3, 0.7, 0.9), (3, 9, -0.8, 1.6, 0.6), (5, 2, 0.0, 1.0, 0.5), (2, 4, 0.4, 2.0, 1)),
        start=11,
    ):
        normal = draws(seed, SINGLE)
        actions, returns = mean + sigma * normal(episodes, horizon), normal(episodes, horizon) - 0.5
        got = ask(student, actions, returns, mean, sigma, discount).answer
        value = as_tensor(got, (episodes,), "one estimate per episode")
        _judge_gradient(value, actions.double(), returns.double(), mean, sigma, discount)


def _judge_gradient(
    value: torch.Tensor,
    actions: torch.Tensor,
    returns: torch.Tensor,
    mean: float,
    sigma: float,
    discount: float,
) -> None:
    """Compare the estimates; name the mistake that they equal."""
    powers = discount ** torch.arange(actions.shape[1], dtype=torch.float64)  # gamma^t
    score = (actions - mean) / sigma**2
    expected = (powers * returns * score).sum(1)
    mistakes = {
        "gamma^t is missing: G_t discounts from time t on, the objective from time 0.": (
            (returns * score).sum(1)
        ),
        "every score is weighed by G_0; the rewards before t drop out of what a_t gets.": (
            returns[:, 0] * score.sum(1)
        ),
        "the score is (a - mu) / sigma^2: you divide by sigma once.": sigma * expected,
        "the score is (a - mu) / sigma^2: you do not divide by sigma.": sigma**2 * expected,
        "the mean is missing in the score: (a - mu) / sigma^2.": (
            (powers * returns * actions).sum(1) / sigma**2
        ),
        "the sign is turned: the gradient goes uphill, and log N rises towards the action.": (
            -expected
        ),
        "you average over time; the gradient is the sum over the steps.": (
            expected / actions.shape[1]
        ),
        "that is the score's derivative by sigma; the question is mu.": (
            (powers * returns * (((actions - mean) / sigma) ** 2 - 1)).sum(1) / sigma
        ),
        "the returns are missing: each score is weighed by what follows.": (powers * score).sum(1),
    }
    judge(
        value,
        expected,
        mistakes,
        "the numbers differ. Differentiate log N(a; mu, sigma) by mu on paper first.",
    )


class _Batches:
    """Batches for an experiment, which count how many were drawn."""

    def __init__(self, seed: int, samples: int) -> None:
        self.normal, self.samples, self.drawn = draws(seed), samples, 0

    def __call__(self) -> torch.Tensor:
        """Return a new batch, (sample, 3)."""
        self.drawn += 1
        return self.normal(self.samples, 3)


def _estimate(batch: torch.Tensor, values: torch.Tensor) -> torch.Tensor:
    """Return a gradient estimate, (2,): scores times what the first column leaves over ``values``."""
    return (batch[:, 1:] * (4 + batch[:, :1] - values[:, None])).mean(0)


BASELINES: Mapping[str, Callable[[torch.Tensor], torch.Tensor]] = {
    "nothing": lambda batch: torch.zeros_like(batch[:, 0]),
    "half": lambda batch: torch.full_like(batch[:, 0], 2.0),
    "all": lambda batch: 4 + 0.8 * batch[:, 0],
}


@answered
def compare_baselines(student: Student) -> None:
    """Check the variance experiment: f(draw, estimate, baselines, batches) -> {name: (estimates, noise)}."""
    for seed, (samples, batches, names) in enumerate(
        ((5, 8, ("nothing", "half", "all")), (9, 13, ("all", "nothing"))), start=21
    ):
        chosen = {name: BASELINES[name] for name in names}
        draw = _Batches(seed, samples)
        found = ask(student, draw, _estimate, chosen, batches).answer
        if found is None:
            raise Wrong("your function returned None. Does it end with `return`?")
        if not isinstance(found, Mapping) or list(found) != list(names):
            raise Wrong("expected a dictionary with the names of the baselines that you are given.")
        parts = {name: as_parts(found[name], 2, f"estimates and noise of {name}") for name in names}
        _judge_design(draw, seed, {name: part[0] for name, part in parts.items()}, batches)
        for estimates, noise in parts.values():
            of_each = as_tensor(estimates, (batches, 2), "one estimate per batch")
            _judge_noise(as_number(noise, "the noise as one number"), of_each)


def _judge_design(draw: _Batches, seed: int, estimates: dict[str, Any], batches: int) -> None:
    """Compare the estimates with those of fresh batches that every baseline shares."""
    for name, found in estimates.items():
        fresh = _Batches(seed, draw.samples)
        seen = [fresh() for _ in range(batches)]
        expected = torch.stack([_estimate(batch, BASELINES[name](batch)) for batch in seen])
        if draw.drawn == batches * len(estimates):
            raise Wrong(
                "each baseline gets batches of its own, so that luck of the draw is in the "
                "comparison: draw a batch once and give it to all of them."
            )
        if draw.drawn == 1 and batches > 1:
            raise Wrong("you draw a single batch: noise is what changes from batch to batch.")
        if draw.drawn != batches:
            raise Wrong(f"expected {batches} batches to be drawn, got {draw.drawn}.")
        mistakes = {
            "the baseline's values are left out: give them to `estimate`.": torch.stack(
                [_estimate(batch, torch.zeros_like(batch[:, 0])) for batch in seen]
            ),
        }
        value = as_tensor(found, (batches, 2), "one estimate per batch")
        judge(value, expected, mistakes, "the estimates differ: estimate(batch, baseline(batch)).")


def _judge_noise(got: float, estimates: torch.Tensor) -> None:
    """Compare the noise; name the mistake that it equals."""
    gaps = estimates - estimates.mean(0)
    squares = gaps.square().sum(1)  # (batch,)
    number, unbiased = squares.mean().sqrt(), (squares.sum() / (len(squares) - 1)).sqrt()
    value = torch.tensor(got, dtype=torch.float64)
    if close(value, unbiased):
        return  # divided by one less than the number of batches: right as well
    mistakes = {
        "that is the mean squared distance: take its root.": squares.mean(),
        "you measure the distance from zero; noise is the distance from the estimates' mean.": (
            estimates.square().sum(1).mean().sqrt()
        ),
        "you average over the parameters; the squared distance is their sum.": (
            gaps.square().mean().sqrt()
        ),
        "square the distances before you average them, and take the root at last.": (
            squares.sqrt().mean()
        ),
        "that is the length of the mean estimate, not how far the others lie from it.": (
            estimates.mean(0).norm()
        ),
        "take the mean over the batches: your noise grows with their number.": squares.sum().sqrt(),
    }
    judge(value, number, mistakes, "the noise differs: root, mean, squared distance from the mean.")


@answered
def best_constant(student: Student) -> None:
    """Check the constant that makes the estimate least noisy: f(scores (sample, parameter), returns)."""
    for seed, (samples, parameters) in enumerate(((40, 2), (25, 1), (60, 5)), start=31):
        normal = draws(seed, SINGLE)
        scores = normal(samples, parameters)
        returns = -((normal(samples) - 1) ** 2) + scores[:, 0]
        got = as_number(ask(student, scores, returns).answer, "one number")
        _judge_constant(got, scores.double(), returns.double())


def _judge_constant(got: float, scores: torch.Tensor, returns: torch.Tensor) -> None:
    """Compare the constant; name the mistake that it equals."""
    squared = scores.square().sum(1)  # (sample,)
    lengths = squared.sqrt()
    mistakes = {
        "that is the mean return; samples with a long score weigh more.": returns.mean(),
        "you weigh by the score's length; the variance has its square.": (
            (lengths * returns).sum() / lengths.sum()
        ),
        "the weights do not add up to one: divide by the mean squared score.": (
            (squared * returns).mean()
        ),
        "you divide by the mean squared score but sum above it, or the other way round.": (
            (squared * returns).sum() / squared.mean()
        ),
        "you divide by the number of returns in place of the scores' squares.": (
            (squared * returns).sum()
        ),
        "the sign is turned.": -(squared * returns).sum() / squared.sum(),
    }
    value = torch.tensor(got, dtype=torch.float64)
    judge(
        value,
        (squared * returns).sum() / squared.sum(),
        mistakes,
        "the number differs. Write E[|score|^2 (G - b)^2] as a quadratic in b and set its slope to 0.",
    )

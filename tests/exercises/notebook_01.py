"""Notebook 01: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import numpy as np
import torch

from .draw import Draw, Question, Questions, episodes, gaussians, shaped


class Batches:
    """Batches (sample, 3) one after the other, the same ones for every copy."""

    def __init__(self, draw: Draw) -> None:
        samples = draw.whole(2, 9)
        self.batches, self.drawn = [draw.normal(samples, 3) for _ in range(100)], 0

    def __call__(self) -> torch.Tensor:
        self.drawn += 1
        return self.batches[self.drawn - 1]


def _estimate(batch: torch.Tensor, values: torch.Tensor) -> torch.Tensor:
    return (batch[:, 1:] * (3 * batch[:, :1] - values[:, None])).mean(0)


def _experiment(draw: Draw) -> Question:
    slope = draw.between(0, 3)
    baselines = {"none": lambda b: 0 * b[:, 0], "linear": lambda b: slope * b[:, 0]}
    return Batches(draw), _estimate, baselines, draw.whole(2, 12)


def _actions(draw: Draw) -> Question:
    shape = episodes(draw)
    numbers = draw.between(-1, 1), draw.between(0.3, 2), draw.between(0.3, 1)
    return draw.normal(*shape), draw.normal(*shape), *numbers


def _scores(draw: Draw) -> Question:
    samples = draw.whole(3, 30)
    return draw.normal(samples, draw.whole(1, 5)), draw.normal(samples)


QUESTIONS: Questions = {
    "log_density": lambda draw: gaussians(draw, True),
    "discounted_returns": lambda draw: (draw.normal(*episodes(draw)), draw.between(0.3, 1)),
    "policy_gradient": _actions,
    "compare_baselines": _experiment,
    "best_constant": _scores,
    "advantages": lambda draw: (
        *shaped("normal", "normal")(draw),
        draw.between(0.3, 1),
        draw.between(0.2, 1),
    ),
}


def log_density__distribution(mean, log_sigma, actions):
    return torch.distributions.Normal(mean, log_sigma.exp()).log_prob(actions).sum(dim=-1)


def log_density__double(mean, log_sigma, actions):
    return log_density__distribution(mean.double(), log_sigma.double(), actions.double())


def discounted_returns__lists(rewards, discount):
    return [
        [sum(discount**k * float(r) for k, r in enumerate(row[t:])) for t in range(len(row))]
        for row in rewards
    ]


def discounted_returns__double(rewards, discount):
    returns = torch.zeros(rewards.shape, dtype=torch.float64)
    for t in range(rewards.shape[1] - 1, -1, -1):
        after = returns[:, t + 1] if t + 1 < rewards.shape[1] else 0.0
        returns[:, t] = rewards[:, t] + discount * after
    return returns


def discounted_returns__matrix(rewards, discount):
    steps = torch.arange(rewards.shape[1])
    later = steps[:, None] - steps[None]  # (later time, time)
    return rewards @ torch.where(later >= 0, discount ** later.clamp(min=0).float(), 0.0)


def advantages__columns(rewards, values, discount, gae_lambda):
    columns, running, after = [], 0.0, 0.0
    for t in reversed(range(rewards.shape[1])):
        running = rewards[:, t] + discount * after - values[:, t] + discount * gae_lambda * running
        after = values[:, t]
        columns.insert(0, running)
    return torch.stack(columns, 1)


def advantages__numpy(rewards, values, discount, gae_lambda):
    return advantages__columns(rewards, values, discount, gae_lambda).double().numpy()


def policy_gradient__loop(actions, returns, mean, sigma, discount):
    found = []
    for row, following in zip(actions.tolist(), returns.tolist(), strict=True):
        steps = enumerate(zip(row, following, strict=True))
        found.append(sum(discount**t * g * (a - mean) / sigma**2 for t, (a, g) in steps))
    return found


def policy_gradient__double(actions, returns, mean, sigma, discount):
    powers = torch.tensor([discount**t for t in range(actions.shape[1])], dtype=torch.float64)
    return (
        torch.einsum("et,et,t->e", (actions - mean).double(), returns.double(), powers) / sigma**2
    )


def policy_gradient__numpy(actions, returns, mean, sigma, discount):
    powers = float(discount) ** np.arange(actions.shape[1])
    return (powers * returns.numpy() * (actions.numpy() - mean)).sum(1) / sigma**2


def compare_baselines__batch_by_batch(draw, estimate, baselines, batches):
    estimates = {name: [] for name in baselines}
    for _ in range(batches):
        batch = draw()
        for name in baselines:
            estimates[name].append(estimate(batch, baselines[name](batch)))
    stacked = {name: torch.stack(each) for name, each in estimates.items()}
    return {name: (each, each.var(0, correction=0).sum().sqrt()) for name, each in stacked.items()}


def compare_baselines__numpy(draw, estimate, baselines, batches):
    seen = [draw() for _ in range(batches)]
    found = {}
    for name, baseline in baselines.items():
        estimates = np.stack([estimate(batch, baseline(batch)).numpy() for batch in seen])
        found[name] = [estimates, np.sqrt(estimates.var(axis=0).sum())]
    return found


def compare_baselines__one_less(draw, estimate, baselines, batches):
    found = compare_baselines__batch_by_batch(draw, estimate, baselines, batches)
    return {name: (each, float(each.var(0).sum() ** 0.5)) for name, (each, _) in found.items()}


def best_constant__average(scores, returns):
    return np.average(returns.numpy(), weights=(scores.numpy() ** 2).sum(1))


def best_constant__float(scores, returns):
    squared = (scores * scores).sum(dim=1).double()
    return float(squared @ returns.double() / squared.sum())


def best_constant__one_element(scores, returns):
    weights = scores.norm(dim=1, keepdim=True) ** 2
    return (weights.T @ returns[:, None] / weights.sum()).reshape(1)

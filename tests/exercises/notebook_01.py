"""Notebook 01: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import numpy as np
import torch

from .draw import Questions, episodes, gaussians, shaped

QUESTIONS: Questions = {
    "log_density": lambda draw: gaussians(draw, True),
    "discounted_returns": lambda draw: (draw.normal(*episodes(draw)), draw.between(0.3, 1)),
    "reinforce_loss": shaped("leaf", "normal", "mask"),
    "advantages": lambda draw: (
        *shaped("normal", "normal")(draw),
        draw.between(0.3, 1),
        draw.between(0.2, 1),
    ),
}


def log_density__distribution(mean, log_sigma, actions):
    return torch.distributions.Normal(mean, log_sigma.exp()).log_prob(actions).sum(dim=-1)


def log_density__numpy(mean, log_sigma, actions):
    mean, log_sigma, actions = (part.detach().numpy() for part in (mean, log_sigma, actions))
    each = -((actions - mean) ** 2) / (2 * np.exp(2 * log_sigma)) - log_sigma
    return (each - 0.5 * np.log(2 * np.pi)).sum(axis=-1)


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


def reinforce_loss__boolean_mask(log_probs, returns, mask):
    taken = mask.bool()
    return -(log_probs[taken] * returns[taken]).mean()


def reinforce_loss__one_element(log_probs, returns, mask):
    return (log_probs * -returns * mask).sum().reshape(1) / mask.sum()


def reinforce_loss__double(log_probs, returns, mask):
    return (
        -torch.einsum("et,et,et->", *(x.double() for x in (log_probs, returns, mask))) / mask.sum()
    )


def advantages__columns(rewards, values, discount, gae_lambda):
    columns, running, after = [], 0.0, 0.0
    for t in reversed(range(rewards.shape[1])):
        running = rewards[:, t] + discount * after - values[:, t] + discount * gae_lambda * running
        after = values[:, t]
        columns.insert(0, running)
    return torch.stack(columns, 1)


def advantages__numpy(rewards, values, discount, gae_lambda):
    return advantages__columns(rewards, values, discount, gae_lambda).double().numpy()

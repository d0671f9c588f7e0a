"""Notebook 08: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import math

import numpy as np
import torch

from .draw import Draw, Question, Questions, gaussians


def _dicts(draw: Draw) -> Question:
    seeds = [draw.random.permutation(7)[: draw.whole(2, 7)].tolist() for _ in range(2)]
    return tuple({seed: draw.between(-9, 9) for seed in some} for some in seeds)


def _plan(draw: Draw) -> Question:
    letters = "abcdefg"
    control = {letter: draw.whole(0, 5) for letter in letters[: draw.whole(1, 6)]}
    names = letters[: draw.whole(1, 4)]
    return control, {name: {draw.random.choice(list(letters)): draw.whole(5, 9)} for name in names}


QUESTIONS: Questions = {
    "one_at_a_time": _plan,
    "seed_differences": _dicts,
    "averaged_log_density": lambda draw: gaussians(draw, False),
}


def one_at_a_time__loop(control, changes):
    runs = {"control": dict(control)}
    for name in changes:
        runs[name] = {**control, **changes[name]}
    return runs


def seed_differences__sorted(control, switched):
    return {
        seed: np.float32(switched[seed] - control[seed])
        for seed in sorted(control)
        if seed in switched
    }


def seed_differences__tensors(control, switched):
    common = set(control).intersection(switched)
    return {seed: torch.tensor(switched[seed]) - control[seed] for seed in common}


def averaged_log_density__distribution(mean, sigma, action):
    return torch.distributions.Normal(mean, sigma).log_prob(action).mean(dim=-1)


def averaged_log_density__sum(mean, sigma, action):
    each = -((action - mean) ** 2) / (2 * sigma**2) - torch.log(sigma * math.sqrt(2 * math.pi))
    return each.double().sum(-1) / action.shape[-1]

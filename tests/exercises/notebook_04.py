"""Notebook 04: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import torch

from .draw import Draw, Question, Questions


def _policies(draw: Draw) -> Question:
    states, actions = draw.whole(2, 5), draw.whole(2, 5)
    return (
        draw.normal(states, actions), draw.table(states), draw.table(states),
        draw.table(states, actions), draw.table(states, actions), draw.between(0.3, 0.95),
    )  # fmt: skip


def _world(draw: Draw) -> Question:
    states, actions = draw.whole(2, 6), draw.whole(2, 5)
    return (
        draw.table(states, actions, states), draw.table(states), draw.table(states, actions),
        draw.between(0.3, 0.95),
    )  # fmt: skip


def _assumption(draw: Draw) -> Question:
    shape = draw.whole(1, 4), draw.whole(2, 5), draw.whole(2, 5)
    return draw.normal(*shape) + draw.between(-1, 1), draw.table(*shape)


MANY_ANSWERS = ("break_the_substitution", "tight_step")
QUESTIONS: Questions = {
    "visitation": _world,
    "performance_difference": _policies,
    "assumption_numbers": _assumption,
}


def visitation__sum(transition, initial, policy, discount):
    step = (policy[:, :, None] * transition).sum(1)
    now, total = initial, torch.zeros_like(initial)
    for time in range(1500):
        total, now = total + (1 - discount) * discount**time * now, now @ step
    return total


def visitation__numpy(transition, initial, policy, discount):
    step = np.einsum("sa,sat->st", policy.numpy(), transition.numpy())
    inverse = np.linalg.inv(np.eye(len(step)) - discount * step)
    return ((1 - discount) * initial.numpy() @ inverse).astype(np.float32)


def performance_difference__float(advantage, visits_old, visits_new, old, new, discount):
    return float(torch.einsum("s,sa,sa->", visits_new, new, advantage)) / (1 - discount)


def performance_difference__relative(advantage, visits_old, visits_new, old, new, discount):
    return (visits_new @ ((new - old) * advantage).sum(1)).numpy() / (1 - discount)


def assumption_numbers__floats(advantage, demo):
    return float(advantage.abs().max()), float((demo * advantage).sum(2).min())


def assumption_numbers__list(advantage, demo):
    return [advantage.abs().amax(), torch.einsum("tsa,tsa->ts", demo, advantage).amin()]


def assumption_numbers__array(advantage, demo):
    return np.array(assumption_numbers__floats(advantage, demo), dtype=np.float32)


def break_the_substitution__list():
    return [np.float32(0.995), np.float64(0.04)]


def break_the_substitution__fractions():
    return Fraction(995, 1000), Fraction(1, 25)


def break_the_substitution__tensors():
    return torch.tensor(0.99), torch.tensor([0.05])


def tight_step__arrays():
    return np.array([0.6667, 0.3333, 0.0], dtype=np.float32), np.array([0.5, 0.3333, 0.1667])


def tight_step__the_demonstrator_itself():
    demo = torch.tensor([7 / 12, 1 / 3, 1 / 12])
    return [demo, demo.tolist()]


def tight_step__fractions():
    third = Fraction(1, 3)
    return (Fraction(1, 2), third, Fraction(1, 6)), (Fraction(9, 20), third, Fraction(13, 60))

"""Notebook 02: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import math

import numpy as np
import torch

from .draw import Draw, Question, Questions


def _step(draw: Draw) -> Question:
    position, move = draw.normal(2), 0.12 * draw.normal(2)
    away = math.exp(draw.between(-5, 1)) * draw.normal(2)
    goal = position + move * min(1, 0.1 / float(move.norm())) + away
    return position, move, goal, draw.whole(0, 100)


def _wheels(draw: Draw) -> Question:
    count = draw.whole(2, 6)
    return 2 * draw.normal(count, 3), draw.normal(count), draw.normal(count), draw.between(0.05, 2)


QUESTIONS: Questions = {
    "point_step": _step,
    "loitering_gain": lambda draw: (draw.whole(0, 100), draw.between(0.3, 1)),
    "wheeled_step": _wheels,
    "episodes_needed": lambda draw: (draw.between(0.01, 0.9), draw.between(0.1, 0.99)),
}


def point_step__tensors(position, move, goal, time):
    new = position + move * torch.clamp(0.1 / move.norm().clamp(min=1e-9), max=1.0)
    away = torch.dist(new, goal)
    paid = torch.where(away <= 0.02, torch.tensor(99.0 - time), (1 - away) * (away <= 0.2))
    return new, paid, away <= 0.02


def point_step__lists(position, move, goal, time):
    (x, y), (dx, dy), (gx, gy) = position.tolist(), move.tolist(), goal.tolist()
    length = math.hypot(dx, dy)
    if length > 0.1:
        dx, dy = 0.1 * dx / length, 0.1 * dy / length
    away = math.hypot(x + dx - gx, y + dy - gy)
    reward = 99 - time if away <= 0.02 else 1 - away if away <= 0.2 else 0
    return [[x + dx, y + dy], np.float32(reward), np.bool_(away <= 0.02)]


def loitering_gain__closed_form(time, discount):
    left = 100 - time
    waiting = left if discount == 1 else (1 - discount**left) / (1 - discount)
    return np.float64(0.98 * waiting - left + 1)


def loitering_gain__tensor(time, discount):
    return (0.98 * discount ** torch.arange(100 - time).double()).sum() - (99 - time)


def wheeled_step__columns(state, v, omega, dt):
    moved = state.clone()
    moved[:, 0] += v * dt * state[:, 2].cos()
    moved[:, 1] += v * dt * state[:, 2].sin()
    moved[:, 2] += omega * dt
    return moved


def wheeled_step__numpy(state, v, omega, dt):
    return wheeled_step__columns(state, v, omega, dt).double().numpy()


def episodes_needed__float(rate, confidence):
    return float(np.ceil(np.log(1 - confidence) / np.log(1 - rate)))


def episodes_needed__loop(rate, confidence):
    count, missed = 0, 1.0
    while 1 - missed < confidence:
        count, missed = count + 1, missed * (1 - rate)
    return np.int64(count)


def episodes_needed__tensor(rate, confidence):
    return torch.tensor(math.ceil(math.log(1 - confidence, 1 - rate)))


def episodes_needed__array(rate, confidence):
    return np.ceil(np.array([math.log(1 - confidence) / math.log(1 - rate)])).astype(int)

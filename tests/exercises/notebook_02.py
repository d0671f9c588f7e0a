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


QUESTIONS: Questions = {
    "point_step": _step,
    "loitering_gain": lambda draw: (draw.whole(0, 100), draw.between(0.3, 1)),
    "episodes_needed": lambda draw: (draw.between(0.01, 0.9), draw.between(0.1, 0.99)),
    "agreement": lambda draw: (draw.normal(draw.whole(2, 7), draw.whole(2, 12)),),
}
MANY_ANSWERS = {"steer"}


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


def steer__vectors(state, goal):
    ahead = torch.stack([state[2].cos(), state[2].sin()])
    way = goal - state[:2]
    left = ahead[0] * way[1] - ahead[1] * way[0]
    off = torch.atan2(left, ahead @ way)
    return torch.stack([0.22 * off.cos().clamp(min=0), (2 * off).clamp(-2.84, 2.84)])


def steer__numpy(state, goal):
    x, y, heading = state.numpy()
    off = np.arctan2(*(goal.numpy() - [x, y])[::-1]) - heading
    off = (off + np.pi) % (2 * np.pi) - np.pi
    return [np.float64(0.2 if abs(off) < 1 else 0.02), np.clip(off, -2.84, 2.84)]


def steer__three_commands(state, goal):
    x, y, heading = state.tolist()
    gap = math.atan2(float(goal[1]) - y, float(goal[0]) - x) - heading
    if math.cos(gap) > 0.99:
        return (0.22, 0)
    return (
        0.1 if math.cos(gap) > 0.9 else 0,
        math.copysign(min(abs(math.sin(gap)) + 0.1, 1), math.sin(gap)),
    )


def agreement__pairs(gradients):
    found = [
        float(one @ other / one.norm() / other.norm())
        for place, one in enumerate(gradients)
        for other in gradients[:place]
    ]
    return sum(found) / len(found)


def agreement__sum_of_directions(gradients):
    count = len(gradients)
    whole = torch.nn.functional.normalize(gradients, dim=1).sum(0)
    return (whole @ whole - count) / (count * (count - 1))


def agreement__numpy(gradients):
    angles = np.corrcoef(np.hstack([gradients.numpy(), -gradients.numpy()]))  # mean 0: cosines
    return angles[np.triu_indices(len(angles), 1)].mean()


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

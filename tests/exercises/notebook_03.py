"""Notebook 03: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import numpy as np
import torch

from .draw import Draw, Question, Questions, episodes


def _cut(draw: Draw) -> Question:
    return draw.normal(*episodes(draw)).abs().mul(8).round() / 8, draw.whole(1, 8) / 8


def _tasks(draw: Draw) -> Question:
    count = draw.whole(2, 5)
    return draw.normal(count, draw.whole(2, 5), draw.whole(1, 5)), draw.normal(
        count, draw.whole(1, 4)
    )


def _clouds(draw: Draw) -> Question:
    size = draw.whole(2, 4)
    return draw.normal(draw.whole(2, 6), size), draw.normal(draw.whole(2, 6), size)


QUESTIONS: Questions = {
    "with_task": _tasks,
    "steps_before_reward": _cut,
    "nearest_distance": _clouds,
}


def with_task__repeat(states, tasks):
    return torch.cat((states, tasks.unsqueeze(1).repeat(1, states.shape[1], 1)), 2)


def with_task__numpy(states, tasks):
    spread = np.repeat(tasks.numpy()[:, None], states.shape[1], axis=1)
    return np.concatenate([states.numpy(), spread], axis=-1)


def steps_before_reward__lists(distance, margin):
    counts = []
    for row in distance.tolist():
        close = [step for step, away in enumerate(row) if away <= margin]
        counts.append(close[0] if close else len(row))
    return counts


def steps_before_reward__stacked(distance, margin):
    return tuple(torch.tensor(float(n)) for n in steps_before_reward__lists(distance, margin))


def nearest_distance__broadcast(states, data):
    return (states[:, None] - data[None]).pow(2).sum(-1).sqrt().amin(1)


def nearest_distance__stacked(states, data):
    return torch.stack([(data - state).norm(dim=1).min() for state in states])


def nearest_distance__numpy(states, data):
    gaps = states.numpy()[:, None] - data.numpy()[None]
    return np.linalg.norm(gaps, axis=-1).min(axis=1)

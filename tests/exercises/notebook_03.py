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


MANY_ANSWERS = ("misleading",)
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


def _turned(goal, angle):
    x, y = goal.tolist()
    return [
        x * np.cos(angle) - y * np.sin(angle),
        x * np.sin(angle) + y * np.cos(angle),
    ]


def misleading__loops_in_double_precision(goal, walk):
    loop = [[0.3 * number for number in _turned(goal, angle)] for angle in (1.2, 2.2)]
    return ([walk(*[*loop, [0.0, 0.0]] * 2, goal).double()], "stays behind")


def misleading__beyond_the_goal_as_lists(goal, walk):
    beyond = 2 * torch.tensor(_turned(goal, 0.5))
    return [walk(beyond, goal).tolist()], "runs past"


def misleading__several_arrays(goal, walk):
    place = np.array(_turned(goal, 0.3))
    return [walk(1.5 * place, goal).numpy(), walk(1.6 * place, goal).numpy()], "runs past"


def misleading__a_loop_on_the_way(goal, walk):
    half = 0.5 * goal
    loop = [half + 0.3 * torch.tensor(_turned(goal, angle)) for angle in (1.2, 2.2)]
    return (walk(half, *[*loop, half] * 2, goal),), "stays behind"

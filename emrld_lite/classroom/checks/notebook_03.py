"""Checks of notebook 03: demonstrations."""

from __future__ import annotations

import torch

from .answers import Student, Wrong, answered, as_tensor, close, draws


@answered
def with_task(student: Student) -> None:
    """Check goal conditioning: f(states (task, episode, state), tasks (task, n)) -> states with tasks."""
    normal = draws(31)
    states, tasks = normal(4, 3, 5), normal(4, 2)
    got = student(states, tasks)
    if isinstance(got, torch.Tensor) and got.shape == (4, 3, 2):
        raise Wrong("that is the task alone; put it behind the state.")
    got = as_tensor(got, (4, 3, 7), "states with the task's numbers behind them")
    spread = tasks[:, None].expand(4, 3, 2)
    if close(got, torch.cat([states, spread], dim=-1)):
        return
    if close(got, torch.cat([spread, states], dim=-1)):
        raise Wrong("the paper appends: first the state, then the task.")
    if close(got[..., :5], states) and close(got[0, :, 5:], got[1, :, 5:]):
        raise Wrong("every task gets the same context; task i must see its own numbers.")
    raise Wrong("the numbers differ. Every episode of task i carries tasks[i] behind its state.")


@answered
def steps_before_reward(student: Student) -> None:
    """Check the cut: f(distance (task, time), margin) -> first steps that all stay away, (task,)."""
    distance = torch.tensor(
        [
            [2.0, 1.0, 0.5, 0.1, 0.0],
            [2.0, 0.1, 1.0, 2.0, 3.0],  # comes close, and leaves again
            [0.0, 1.0, 1.0, 1.0, 1.0],
            [2.0, 2.0, 2.0, 2.0, 2.0],
            [2.0, 1.5, 0.2, 0.2, 0.1],
        ],
        dtype=torch.float64,
    )
    got = as_tensor(student(distance.clone(), 0.2), (5,), "one number of steps per task")
    expected = torch.tensor([3, 1, 0, 5, 2], dtype=torch.float64)
    if close(got, expected):
        return
    far = distance > 0.2
    if close(got, far.sum(-1).double()):
        raise Wrong("count only up to the first step that comes close; what follows is cut too.")
    if close(got, (distance >= 0.2).long().cumprod(-1).sum(-1).double()):
        raise Wrong("at exactly the margin it has come too close: stay strictly beyond.")
    if close(got, (distance > 0).long().cumprod(-1).sum(-1).double()):
        raise Wrong("the margin is missing.")
    if close(got, expected + 1):
        raise Wrong("the step that comes close is itself cut: one too many.")
    if close(got, far.double().argmin(-1).double()):
        raise Wrong("a trajectory that never comes close keeps all its steps.")
    raise Wrong("the numbers differ. How many steps from the start on stay beyond the margin?")


@answered
def nearest_distance(student: Student) -> None:
    """Check the distance to the data: f(states (n, d), data (m, d)) -> nearest distance, (n,)."""
    normal = draws(33)
    states, data = normal(6, 3), normal(4, 3)
    got = student(states, data)
    if isinstance(got, torch.Tensor) and got.shape == (6, 4):
        raise Wrong("these are the distances to every data point; keep the smallest of each row.")
    got = as_tensor(got, (6,), "one distance per state")
    every = torch.stack([(states - point).square().sum(-1) for point in data], dim=1)  # (n, m)
    if close(got, every.min(1).values.sqrt()):
        return
    if close(got, every.min(1).values):
        raise Wrong("that is the squared distance; take the root.")
    if close(got, every.sqrt().mean(1)):
        raise Wrong("that is the mean distance to the data; the nearest point counts.")
    if close(got, every.max(1).values.sqrt()):
        raise Wrong("that is the farthest point of the data.")
    if close(got, (states - data.mean(0)).norm(dim=-1)):
        raise Wrong("that is the distance to the centre of the data.")
    raise Wrong(
        "the numbers differ. For each state: the smallest Euclidean distance to a data point."
    )

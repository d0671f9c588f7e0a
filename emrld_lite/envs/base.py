"""What every environment gives the algorithms: tasks, a reset and a step over (task, episode)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
import torch
from matplotlib.axes import Axes

from ..validation import InputError
from .drawing import pixels


class Transition(NamedTuple):
    """One step of every episode of every task.

    =========== ========================= =======================================
    Symbol      Shape                     Description
    =========== ========================= =======================================
    states      (task, episode, state)    states after the step
    rewards     (task, episode)           reward of the step
    terminated  (task, episode), bool     the episode ended with this step
    success     (task, episode), bool     the step reached the goal of its task
    =========== ========================= =======================================
    """

    states: torch.Tensor
    rewards: torch.Tensor
    terminated: torch.Tensor
    success: torch.Tensor


def refuse_wrong(
    name: str, tasks: torch.Tensor, wrong: torch.Tensor, expected: str
) -> torch.Tensor:
    """Return ``tasks`` unless one is marked in ``wrong`` (task,); then raise InputError naming it."""
    if wrong.any():
        task = int(wrong.nonzero()[0])
        got = tuple(round(value, 4) for value in tasks[task].tolist())
        raise InputError(f"{name} task {task}: expected {expected}, got {got}")
    return tasks


class Environment(ABC):
    """A family of tasks that share states and actions; every method works on all episodes at once.

    A policy acts in [-1, 1]: ``step`` clips what it is given and scales it to the action box.
    """

    name: str
    horizon: int
    state_dim: int
    action_dim: int
    task_dim: int
    observation_low: tuple[float, ...]
    observation_high: tuple[float, ...]

    @abstractmethod
    def training_tasks(self) -> torch.Tensor:
        """Return the paper's fixed training tasks, (task, task_dim)."""

    @abstractmethod
    def sample_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return ``count`` tasks from the test distribution, (task, task_dim)."""

    def test_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return ``count`` tasks to test on, (task, task_dim): drawn from the test distribution."""
        return self.sample_tasks(count, random)

    @abstractmethod
    def check_tasks(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return ``tasks`` if they belong to this environment; otherwise raise InputError."""

    @abstractmethod
    def reset(self, tasks: torch.Tensor, episodes: int) -> torch.Tensor:
        """Return the initial states, (task, episode, state)."""

    @abstractmethod
    def step(
        self, tasks: torch.Tensor, states: torch.Tensor, actions: torch.Tensor, time: int
    ) -> Transition:
        """Apply actions (task, episode, action) at time index ``time`` in 0 .. horizon - 1."""

    @abstractmethod
    def distance_to_reward(self, tasks: torch.Tensor, states: torch.Tensor) -> torch.Tensor:
        """Return how far states (task, episode, state) are from the region that pays, in length units.

        Negative inside the region; (task, episode).
        """

    @abstractmethod
    def draw(self, axes: Axes, task: torch.Tensor, states: torch.Tensor) -> None:
        """Draw one task (task_dim,) and an episode's states so far (time, state)."""

    def picture(self, task: torch.Tensor, states: torch.Tensor) -> np.ndarray:
        """Return the same as pixels, (480, 480, 3), uint8."""
        return pixels(lambda axes: self.draw(axes, task, states))

"""What every environment gives the algorithms: tasks, a reset and a step over (task, episode)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float
from torch import Generator, Tensor

from .. import first_calls  # noqa: F401  (its import makes MKL's first calls)
from ..validation import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
else:
    Axes = Any  # matplotlib is loaded by the first picture

Tasks = Float[Tensor, "task task_dim"]
States = Float[Tensor, "task episode state"]
Actions = Float[Tensor, "task episode action"]
PerEpisode = Float[Tensor, "task episode"]
Reward = Literal["sparse", "dense"]
Start = Literal["rest", "random"]  # of the cheetah, whose module would load MuJoCo
PaidSide = Literal["both", "correct"]


class Transition(NamedTuple):
    """One step of every episode of every task."""

    states: States
    """States after the step."""
    rewards: PerEpisode
    """Reward of the step."""
    terminated: Bool[Tensor, "task episode"]
    """Whether the episode ended with this step."""
    success: Bool[Tensor, "task episode"]
    """Whether the step reached the goal of its task."""


def refuse_wrong(name: str, tasks: Tasks, wrong: Bool[Tensor, " task"], expected: str) -> Tasks:
    """Return ``tasks`` unless one is marked in ``wrong``; then raise InputError naming it."""
    if wrong.any():
        task = int(wrong.nonzero()[0])
        got = tuple(round(value, 4) for value in tasks[task].tolist())
        raise InputError(f"{name} task {task}: expected {expected}, got {got}")
    return tasks


class Dynamics(ABC):
    """What a rollout needs: a start and a step, on all episodes of all tasks at once.

    A policy acts in [-1, 1]: ``step`` clips what it is given and scales it to the action box.
    """

    horizon: int
    state_dim: int
    """Dimensions of what a policy sees of a state."""
    action_dim: int

    @abstractmethod
    def reset(self, tasks: Tasks, episodes: int, random: Generator | None = None) -> States:
        """Return the initial states; ``random``, a CPU generator, is drawn from where they vary."""

    def observe(self, states: Float[Tensor, "*at inside"]) -> Float[Tensor, "*at state"]:
        """Return what a policy sees of states: by default all. What is seen already stays as it is."""
        return states

    @abstractmethod
    def step(self, tasks: Tasks, states: States, actions: Actions, time: int) -> Transition:
        """Apply ``actions`` at time index ``time`` in 0 .. horizon - 1."""


class Environment(Dynamics):
    """A family of tasks that share states and actions, and what pictures need to know of it."""

    name: str
    task_dim: int
    observation_low: tuple[float, ...]
    observation_high: tuple[float, ...]
    idle_action: tuple[float, ...]
    """The policy's action that moves nothing."""
    reward: Reward = "sparse"
    """The paper's sparse reward, or a dense one, which the experts learn from."""

    @abstractmethod
    def training_tasks(self) -> Tasks:
        """Return the paper's fixed training tasks."""

    @abstractmethod
    def sample_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return ``count`` tasks from the test distribution."""

    def test_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return ``count`` tasks to test on: drawn from the test distribution."""
        return self.sample_tasks(count, random)

    @abstractmethod
    def check_tasks(self, tasks: Tensor) -> Tasks:
        """Return ``tasks`` if they belong to this environment; otherwise raise InputError."""

    @abstractmethod
    def distance_to_reward(self, tasks: Tasks, states: States) -> PerEpisode:
        """Return how far states are from the region that pays, in length units; negative inside it."""

    @abstractmethod
    def draw(
        self, axes: Axes, task: Float[Tensor, " task_dim"], states: Float[Tensor, "time state"]
    ) -> None:
        """Draw one task and an episode's states so far."""

    @abstractmethod
    def draw_tasks(self, axes: Axes, tasks: Tasks) -> None:
        """Draw where episodes start and where each task pays; names the axes, with their units."""

    @abstractmethod
    def track(self, states: Float[Tensor, "time state"]) -> Float[Tensor, "2 time"]:
        """Return what the axes of ``draw_tasks`` show of an episode: horizontal, then vertical."""

    def picture(
        self, task: Float[Tensor, " task_dim"], states: Float[Tensor, "time state"]
    ) -> np.ndarray:
        """Return what ``draw`` draws as pixels, (480, 480, 3), uint8."""
        from .drawing import pixels

        return pixels(lambda axes: self.draw(axes, task, states))

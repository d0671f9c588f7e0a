"""Data sets that a reader designs: walks to a goal, played in Point2D, and what their copy does.

The copy here has no network: at every place it takes the average of the actions that were demonstrated
around there, which is what the likelihood asks of a copy that can bend as it likes. It is the same
on every machine, and made at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from ..demonstrations import Demonstrations, from_arrays
from ..envs import make
from ..envs.goals import GOAL_RADIUS
from ..envs.point2d import HORIZON, NEAR, STEP_LIMIT
from ..validation import InputError

Place = Float[Tensor, "2"]
Walk = Float[Tensor, "time 2"]
STAYS, RUNS_PAST, ARRIVES = "stays behind", "runs past", "arrives"
ROUNDING = 1e-4  # of a step: single precision must not add one


class Played(NamedTuple):
    """A walk as the environment shows it, up to the step that reaches the goal."""

    states: Float[Tensor, "time 2"]
    """Places before each step, and after the last one."""
    rewards: Float[Tensor, " step"]
    """Reward of each step."""
    reached: bool
    """Whether the goal was reached, which ends an episode."""

    @property
    def total(self) -> float:
        """Return the sum of the rewards."""
        return float(self.rewards.sum())


def walk(*places: Sequence[float] | Tensor) -> Walk:
    """Return the actions that go from the start through the given places, straight and in even steps.

    No step is longer than 0.1; raises InputError for a place that is not two numbers.
    """
    here, parts = torch.zeros(2, dtype=torch.float64), []
    for number, place in enumerate(places):
        target = torch.as_tensor(place, dtype=torch.float64)
        if target.shape != (2,) or not bool(torch.isfinite(target).all()):
            raise InputError(f"place {number}: expected x and y, got {tuple(target.tolist())}")
        way = target - here
        count = max(1, math.ceil(float(way.norm()) / STEP_LIMIT - ROUNDING))
        parts.append((way / count / STEP_LIMIT).expand(count, 2))
        here = target
    if not parts:
        raise InputError("places: expected at least one, got none")
    return torch.cat(parts).float()


def play(goal: Place, actions: Walk) -> Played:
    """Return what Point2D does with the actions, from the start to the goal or to the last of them."""
    return _episode(goal, lambda time, _: actions[time], min(len(actions), HORIZON))


def _episode(goal: Place, act: Callable[[int, Place], Place], steps: int) -> Played:
    """Return an episode in which ``act`` chooses the action from the time and the place."""
    environment = make("point2d")
    states = environment.reset(goal[None], 1)
    seen, rewards, reached = [states[0, 0]], [], False
    for time in range(steps):
        action = act(time, states[0, 0])
        moved = environment.step(goal[None], states, action[None, None], time)
        states, reached = moved.states, bool(moved.success)
        seen.append(states[0, 0])
        rewards.append(moved.rewards[0, 0])
        if reached:
            break
    return Played(torch.stack(seen), torch.stack(rewards), reached)


def as_demonstrations(goal: Place, walks: Sequence[Walk]) -> Demonstrations:
    """Return the walks as demonstrations of one task, states as Point2D shows them."""
    plays = [play(goal, actions) for actions in walks]
    lengths = [len(played.rewards) for played in plays]
    shape = (1, len(walks), max(lengths), 2)
    states, actions = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    for path, (played, count) in enumerate(zip(plays, lengths, strict=True)):
        states[0, path, :count] = played.states[:-1].numpy()
        actions[0, path, :count] = walks[path][:count].numpy()
    tasks, ends = goal[None].numpy(), np.array([lengths])
    return from_arrays(tasks, states, actions, ends, "point2d", "optimal", maker="a design")


def averaging_copy(data: Demonstrations, width: float) -> Played:
    """Return what a copy does that averages the demonstrated actions within about ``width``."""
    taken = data.mask[0].bool()
    known, shown = data.states[0][taken].double(), data.actions[0][taken].double()

    def average(_: int, here: Place) -> Place:
        nearness = -(known - here.double()).square().sum(-1) / (2 * width**2)
        return (nearness.softmax(0) @ shown).float()

    return _episode(data.tasks[0], average, HORIZON)


def outcome(goal: Place, played: Played, wanted: float) -> str:
    """Return "arrives", "stays behind" or "runs past": what became of a copy.

    It arrives when its return is a fifth of ``wanted`` or more; it stays behind when it never comes as
    far as the disc that pays; otherwise it runs past.
    """
    if played.total >= 0.2 * wanted:
        return ARRIVES
    farthest = float(played.states.norm(dim=-1).max())
    return STAYS if farthest < GOAL_RADIUS - NEAR else RUNS_PAST

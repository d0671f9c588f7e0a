"""Point2D Navigation: reach an unseen goal on a semicircle, rewarded only next to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from ..validation import check_choice, positive_count
from .base import Actions, Axes, Environment, PerEpisode, Reward, States, Tasks, Transition
from .goals import check_goals, goal_distance, sample_goals, spread_goals

HORIZON = 100  # steps, appendix B
STEP_LIMIT = 0.1  # dx^2 + dy^2 <= 0.1^2
NEAR = 0.2  # D_1: inside, the reward is one minus the distance
REACHED = 0.02  # D_2: inside, the remaining steps are paid out and the episode ends

StepRule = Literal["at-most", "exact"]


def displacement(actions: Float[Tensor, "*at 2"], step_rule: StepRule) -> Float[Tensor, "*at 2"]:
    """Turn actions into displacements.

    "at-most" is the paper's rule, a norm of at most 0.1; "exact" is the released code's, where
    every step has a norm of exactly 0.1 (so a point next to its goal must jump over it).
    """
    moves = actions.clamp(-1.0, 1.0) * STEP_LIMIT
    dx, dy = moves[..., 0], moves[..., 1]
    norm = (dx * dx + dy * dy).sqrt()
    if step_rule == "exact":
        scale = STEP_LIMIT / norm.clamp_min(1e-12)
    else:
        scale = STEP_LIMIT / norm.clamp_min(STEP_LIMIT)
    return moves * scale[..., None]


def sparse_reward(distance: Float[Tensor, "*at"], time: int) -> Float[Tensor, "*at"]:
    """Return the paper's reward (appendix B) for distances after the step of time index ``time``."""
    near = torch.where(distance <= NEAR, 1.0 - distance, torch.zeros_like(distance))
    return torch.where(distance <= REACHED, torch.full_like(distance, HORIZON - time - 1), near)


@dataclass(frozen=True)
class Point2D(Environment):
    """The paper's Point2D Navigation (appendix B, Environments).

    ## Description
    A point in the plane walks to a goal that it does not see: the goal is the task.

    ## Observation space
    === ================== ===== ==== =============
    Num Observation        Min   Max  Unit
    === ================== ===== ==== =============
    0   x of the point     -10   10   length units
    1   y of the point     -10   10   length units
    === ================== ===== ==== =============

    ## Action space
    === ======== === === ==============================================
    Num Action   Min Max Unit
    === ======== === === ==============================================
    0   dx       -1  1   0.1 length units; clipped, then shortened so
    1   dy       -1  1   that the step is at most 0.1 long (step_rule)
    === ======== === === ==============================================

    ## Rewards
    With d the distance to the goal after a step: 1 - d where d <= 0.2; the number of steps that are
    left where d <= 0.02; 0 elsewhere. ``reward="dense"``: -d.

    ## Starting state
    The origin.

    ## Episode end
    Terminated when d <= 0.02; truncated after 100 steps.

    ## Tasks and options
    A task is the goal's x and y, on the upper semicircle of radius 2: 12 to train on, evenly spread,
    others drawn uniformly. ``reward`` and ``step_rule`` as below; InputError for unknown ones.
    """

    reward: Reward = Environment.reward
    """The paper's sparse reward, or minus the distance to the goal, which the experts learn from."""
    step_rule: StepRule = "at-most"
    """The paper's rule for the length of a step, or the released code's."""

    name = "point2d"
    horizon = HORIZON
    state_dim = 2
    action_dim = 2
    task_dim = 2
    observation_low = (-HORIZON * STEP_LIMIT,) * 2
    observation_high = (HORIZON * STEP_LIMIT,) * 2
    idle_action = (0.0, 0.0)

    def __post_init__(self) -> None:
        check_choice("reward", self.reward, get_args(Reward))
        check_choice("step rule", self.step_rule, get_args(StepRule))

    def training_tasks(self) -> Tasks:
        """Return 12 goals, evenly spread over the semicircle with both its ends."""
        return spread_goals(12)

    def sample_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return goals drawn uniformly from the semicircle."""
        return sample_goals(count, random)

    def check_tasks(self, tasks: Tensor) -> Tasks:
        """Return goals (task, 2) unless one lies off the upper semicircle of radius 2."""
        return check_goals("Point2D", tasks)

    def reset(self, tasks: Tasks, episodes: int, random: torch.Generator | None = None) -> States:
        """Return the origin for every episode."""
        return torch.zeros(len(tasks), positive_count("episodes", episodes), 2, device=tasks.device)

    def step(self, tasks: Tasks, states: States, actions: Actions, time: int) -> Transition:
        """Move every point and pay its reward, by the formulas of ``displacement``, ``sparse_reward``."""
        moved = states + displacement(actions, self.step_rule)  # (task, episode, 2)
        distance = goal_distance(moved, tasks[:, None])  # (task, episode)
        reached = distance <= REACHED
        rewards = -distance if self.reward == "dense" else sparse_reward(distance, time)
        return Transition(moved, rewards, reached, reached)

    def distance_to_reward(self, tasks: Tasks, states: States) -> PerEpisode:
        """Return the distance to the disc of radius 0.2 around the goal."""
        return goal_distance(states, tasks[:, None]) - NEAR

    def draw(
        self, axes: Axes, task: Float[Tensor, " task_dim"], states: Float[Tensor, "time state"]
    ) -> None:
        """Draw the goal's disc, the way so far, and the point at its end."""
        from .drawing import path, round_goal

        round_goal(axes, task.tolist(), NEAR)
        path(axes, states)
        axes.plot(*states[-1].tolist(), marker="o", color="black", markersize=5, linestyle="none")
        axes.set(xlim=(-2.6, 2.6), ylim=(-2.6, 2.6))

    def draw_tasks(self, axes: Axes, tasks: Tasks) -> None:
        """Draw the start, and each goal with the disc that pays."""
        from .drawing import goals_in_the_plane

        goals_in_the_plane(axes, tasks, NEAR)

    def track(self, states: Float[Tensor, "time state"]) -> Float[Tensor, "2 time"]:
        """Return x and y."""
        return states.T

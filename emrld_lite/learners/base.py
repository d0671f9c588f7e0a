"""What a meta-update learns from, and what every learner can do."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import torch

from ..adapt import Adaptation, adapt, cloning_loss, task_slices
from ..demonstrations import Demonstrations
from ..policy import Gaussian, Params, detach, distribution
from ..rollout import Rollout, pack
from ..trpo import Step


class TaskData(NamedTuple):
    """What a meta-update learns from: D^tr and D^val with their advantages, and D^dem."""

    before: Rollout
    after: Rollout
    demonstrations: Demonstrations


def chunks(data: TaskData) -> list[TaskData]:
    """Return the data of a few tasks at a time, their steps packed.

    Meta-losses are means over tasks, so they can be summed up chunk by chunk: the memory of the
    work then does not grow with the number of tasks, only that of their episodes and samples.
    """
    before, after, demonstrations = data
    return [
        TaskData(pack(before.take(part)), pack(after.take(part)), demonstrations.take(part))
        for part in task_slices(len(before.rewards))
    ]


def policies_after(
    theta: Params, data: TaskData, rule: Adaptation, keep_graph: bool = False
) -> Gaussian:
    """Return pi_{theta_i}(. | s) at the states of D^val, where theta_i is theta adapted on D^tr and D^dem."""
    task_params = adapt(theta, data.before, data.demonstrations, rule, keep_graph)
    return distribution(task_params, data.after.states)


class Learner(ABC):
    """What changes the meta-policy; a column of the comparison's table says which one."""

    @abstractmethod
    def update(
        self, theta: Params, data: TaskData, rule: Adaptation, random: torch.Generator
    ) -> tuple[Params, Step]:
        """Return theta_{k+1} and what the step did; a step that is not finite leaves theta as it is."""

    def state(self) -> Params:
        """Return what the learner remembers, for a checkpoint: by default nothing."""
        return {}

    def load(self, state: Params) -> None:  # noqa: B027  (nothing to do is a fair answer)
        """Go on from the memory of a checkpoint; an empty one is a fresh start."""


def cloning_gradient(theta: Params, parts: list[TaskData], rule: Adaptation) -> Params:
    """Return the gradient of mean_i L^BC_i(theta_i) by the meta-policy, through the adaptation."""
    total = {name: torch.zeros_like(value) for name, value in theta.items()}
    tasks = sum(len(part.demonstrations.tasks) for part in parts)
    for before, _, demonstrations in parts:
        leaves = detach(theta, requires_grad=True)
        task_params = adapt(leaves, before, demonstrations, rule, keep_graph=True)
        loss = cloning_loss(task_params, demonstrations, rule).sum() / tasks
        gradients = torch.autograd.grad(loss, list(leaves.values()))
        total = {
            name: value + gradient
            for (name, value), gradient in zip(total.items(), gradients, strict=True)
        }
    return total

"""Task adaptation, equation (adapt_rl_bc): one gradient step from the meta-policy to every task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch

from .demonstrations import Demonstrations
from .losses import bc_loss, rl_loss
from .policy import Params, detach, has_task_axis, per_task, take_params
from .rollout import Rollout, take
from .validation import InputError, known, real_number

LARGEST = 1e6  # of a parameter with which a policy can act: its outputs then fit into float32
TASKS_AT_ONCE = 4  # measured: enough work for the cores, small enough for their caches
STEPS_AT_ONCE = 8000  # the same, counted in steps: four tasks of twenty full episodes


@dataclass(frozen=True)
class Adaptation:
    """The numbers in equation (adapt_rl_bc); raises InputError for one that cannot be used."""

    w_rl: float
    """Weight of the RL loss."""
    w_bc: float
    """Weight of the behaviour-cloning loss."""
    warm_start: bool = False
    """Whether one cloning step comes first (EMRLD-WS)."""
    adapt_lr: float = 0.01
    """alpha, the step length (Table 2)."""
    bc_reduction: str = "mean"
    """"mean" over the demonstration's steps (released code) or their "sum" (paper)."""
    second_order: bool = True
    """Whether the meta-gradient sees that the step's own gradient depends on where it is taken."""

    def __post_init__(self) -> None:
        real_number("w_rl", self.w_rl, minimum=0.0)
        real_number("w_bc", self.w_bc, minimum=0.0)
        real_number("adapt_lr", self.adapt_lr, minimum=0.0)
        known("bc_reduction", self.bc_reduction, ("mean", "sum"))
        if self.w_rl == 0.0 and self.w_bc == 0.0:
            raise InputError("w_rl and w_bc: expected one of them above 0, got 0 for both")


def gradient_step(
    loss: Callable[[Params], torch.Tensor],
    params: Params,
    learning_rate: float,
    keep_graph: bool,
    second_order: bool = True,
) -> Params:
    """Return params - learning_rate * gradient of ``loss``, for every task at once.

    ``loss`` maps ``task_params`` to one number a task, (task,). With ``keep_graph`` the result can
    be differentiated with respect to ``params``, second-order terms included unless they are not
    wanted; without it the result is cut from its history.
    """
    if not keep_graph:
        params = detach(params, requires_grad=True)
    with torch.enable_grad():
        gradients = torch.autograd.grad(
            loss(params).sum(), list(params.values()), create_graph=keep_graph and second_order
        )
    stepped = {
        name: value - learning_rate * gradient
        for (name, value), gradient in zip(params.items(), gradients, strict=True)
    }
    return stepped if keep_graph else detach(stepped)


def warm_start(
    params: Params,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    keep_graph: bool = False,
) -> Params:
    """Return the parameters that collect D^tr: EMRLD-WS's one cloning step, or ``params`` unchanged.

    Section 3, last paragraph: theta~ = theta - alpha grad L^BC.
    """
    if not adaptation.warm_start:
        return params

    def loss(task_params: Params) -> torch.Tensor:
        return bc_loss(task_params, demonstrations, adaptation.bc_reduction)

    start = per_task(params, len(demonstrations.tasks))
    return gradient_step(loss, start, adaptation.adapt_lr, keep_graph, adaptation.second_order)


def adapt(
    params: Params,
    rollout: Rollout,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    keep_graph: bool = False,
) -> Params:
    """Return ``task_params``: theta_i = theta - alpha grad(w_rl L^RL_i + w_bc L^BC_i), warm start first.

    ``rollout`` is D^tr with its advantages, collected with ``warm_start(params, ...)``. Tasks do not
    touch each other, so without a graph to keep they are worked off a few at a time: memory then
    does not grow with their number.
    """

    if keep_graph:
        return _adapt(params, rollout, demonstrations, adaptation, keep_graph=True)
    parts = [
        _adapt(
            take_params(params, tasks),
            take(rollout, tasks),
            demonstrations.take(tasks),
            adaptation,
            keep_graph=False,
        )
        for tasks in task_chunks(len(rollout.rewards), rollout.rewards[0].numel())
    ]
    return {name: torch.cat([part[name] for part in parts]) for name in params}


def _adapt(
    params: Params,
    rollout: Rollout,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    keep_graph: bool,
) -> Params:
    def loss(task_params: Params) -> torch.Tensor:
        total = rollout.rewards.new_zeros(len(rollout.rewards))  # (task,)
        if adaptation.w_rl:
            total = total + adaptation.w_rl * rl_loss(task_params, rollout)
        if adaptation.w_bc:
            cloning = bc_loss(task_params, demonstrations, adaptation.bc_reduction)
            total = total + adaptation.w_bc * cloning
        return total

    start = warm_start(params, demonstrations, adaptation, keep_graph)
    start = per_task(start, len(rollout.rewards))
    return gradient_step(loss, start, adaptation.adapt_lr, keep_graph, adaptation.second_order)


def usable(task_params: Params, fallback: Params) -> tuple[Params, int]:
    """Return policies that can act, and for how many tasks that is the ``fallback``.

    A task whose step led to a parameter that is not finite, or beyond LARGEST, keeps the policy that
    the step began with: one set for all tasks, or one a task.
    """
    if not has_task_axis(task_params):
        return task_params, 0
    sizes = [value.abs().flatten(1).amax(-1) for value in task_params.values()]  # (task,) each
    good = torch.stack(sizes).amax(0) <= LARGEST  # (task,); False where not a number
    if good.all():
        return task_params, 0
    tasks = len(good)
    kept = {
        name: torch.where(good.reshape(tasks, *(1,) * (value.dim() - 1)), task_params[name], value)
        for name, value in per_task(fallback, tasks).items()
    }
    return kept, int((~good).sum())


def task_chunks(tasks: int, steps: int = STEPS_AT_ONCE) -> list[slice]:
    """Return slices that cover ``tasks`` tasks of ``steps`` steps each: a few at once, more if short."""
    at_once = max(TASKS_AT_ONCE, STEPS_AT_ONCE // max(1, steps))
    return [slice(first, first + at_once) for first in range(0, tasks, at_once)]

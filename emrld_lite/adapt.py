"""Task adaptation, equation (adapt_rl_bc): one gradient step from the meta-policy to every task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import get_args

import torch
from jaxtyping import Bool
from torch import Tensor

from .demonstrations import Demonstrations
from .losses import REDUCTION, Reduction, bc_loss, rl_loss
from .policy import LogDensity, Params, detach, per_task, take_params
from .rollout import PerTask, Rollout
from .validation import InputError, check_choice, real_number

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
    """alpha, the adaptation's learning rate (Table 1)."""
    bc_reduction: Reduction = REDUCTION
    """Mean over the demonstration's steps (released code) or their sum (paper)."""
    log_density: LogDensity = "averaged"
    """Log-density in both losses: averaged over the action's dimensions (released code), or of the joint
    action (paper), which makes the step as many times longer as the action has dimensions."""
    second_order: bool = True
    """Whether the meta-gradient goes through the adaptation's gradient (paper) or stops at it."""

    def __post_init__(self) -> None:
        real_number("w_rl", self.w_rl, minimum=0.0)
        real_number("w_bc", self.w_bc, minimum=0.0)
        real_number("adapt_lr", self.adapt_lr, minimum=0.0)
        check_choice("bc_reduction", self.bc_reduction, get_args(Reduction))
        check_choice("log_density", self.log_density, get_args(LogDensity))
        if self.w_rl == 0.0 and self.w_bc == 0.0:
            raise InputError("w_rl and w_bc: expected one of them above 0, got 0 for both")


def adapt(
    params: Params,
    before: Rollout,
    demonstrations: Demonstrations,
    rule: Adaptation,
    keep_graph: bool = False,
) -> Params:
    """Return ``task_params``: theta_i = theta - alpha grad(w_rl L^RL_i + w_bc L^BC_i), warm start first.

    ``before`` is D^tr with its advantages, collected with ``warm_start(params, ...)``. With
    ``keep_graph`` the result can be differentiated with respect to ``params``. Tasks do not touch
    each other, so they are taken a few at a time.
    """
    parts = [
        adapt_together(
            take_params(params, tasks),
            before.take(tasks),
            demonstrations.take(tasks),
            rule,
            keep_graph,
        )
        for tasks in task_slices(len(before.rewards), before.rewards[0].numel())
    ]
    return {name: torch.cat([part[name] for part in parts]) for name in params}


def adapt_together(
    params: Params,
    before: Rollout,
    demonstrations: Demonstrations,
    rule: Adaptation,
    keep_graph: bool,
) -> Params:
    """Return what ``adapt`` returns, for all tasks in one batch."""

    def loss(task_params: Params) -> PerTask:
        total = before.rewards.new_zeros(len(before.rewards))
        if rule.w_rl:
            total = total + rule.w_rl * rl_loss(task_params, before, rule.log_density)
        if rule.w_bc:
            total = total + rule.w_bc * cloning_loss(task_params, demonstrations, rule)
        return total

    start = per_task(warm_start(params, demonstrations, rule, keep_graph), len(before.rewards))
    return gradient_step(loss, start, rule.adapt_lr, keep_graph, rule.second_order)


def warm_start(
    params: Params, demonstrations: Demonstrations, rule: Adaptation, keep_graph: bool = False
) -> Params:
    """Return the parameters that collect D^tr: EMRLD-WS's one cloning step, or ``params`` unchanged.

    Section 3, last paragraph: theta~ = theta - alpha grad L^BC.
    """
    if not rule.warm_start:
        return params

    def loss(task_params: Params) -> PerTask:
        return cloning_loss(task_params, demonstrations, rule)

    start = per_task(params, len(demonstrations.tasks))
    return gradient_step(loss, start, rule.adapt_lr, keep_graph, rule.second_order)


def cloning_loss(params: Params, demonstrations: Demonstrations, rule: Adaptation) -> PerTask:
    """Return L^BC_i, reduced over the steps and the action's dimensions as ``rule`` says."""
    return bc_loss(params, demonstrations, rule.bc_reduction, rule.log_density)


def gradient_step(
    loss: Callable[[Params], PerTask],
    task_params: Params,
    learning_rate: float,
    keep_graph: bool,
    second_order: bool,
) -> Params:
    """Return task_params - learning_rate * gradient of ``loss``, for every task at once.

    With ``keep_graph`` the result can be differentiated with respect to ``task_params``,
    second-order terms included unless they are not wanted; without it the result is cut from its
    history. A task whose step leads to a parameter that no policy can act with stays where it was.
    """
    if not keep_graph:
        task_params = detach(task_params, requires_grad=True)

    def stepped(start: Params) -> Params:
        with torch.enable_grad():
            gradients = torch.autograd.grad(
                loss(start).sum(), list(start.values()), create_graph=keep_graph and second_order
            )
        return {
            name: value - learning_rate * gradient
            for (name, value), gradient in zip(start.items(), gradients, strict=True)
        }

    moved = stepped(task_params)
    usable = usable_tasks(moved)
    if not usable.all():
        if keep_graph:  # again, the lost tasks cut off: their second derivatives may not be numbers
            moved = stepped(select_tasks(usable, task_params, detach(task_params)))
        moved = select_tasks(usable, moved, task_params)
    return moved if keep_graph else detach(moved)


def usable_tasks(task_params: Params) -> Bool[Tensor, " task"]:
    """Return for which tasks every parameter is a number of at most LARGEST in size."""
    sizes = [value.detach().abs().flatten(1).amax(-1) for value in task_params.values()]
    return torch.stack(sizes).amax(0) <= LARGEST  # False where not a number


def select_tasks(chosen: Bool[Tensor, " task"], task_params: Params, others: Params) -> Params:
    """Return the parameters of the ``chosen`` tasks from ``task_params``, the rest from ``others``."""
    return {
        name: torch.where(chosen.reshape(-1, *(1,) * (value.dim() - 1)), value, others[name])
        for name, value in task_params.items()
    }


def unmoved_tasks(start: Params, task_params: Params) -> int:
    """Return for how many tasks the adaptation left every parameter of ``start`` as it was."""
    start = per_task(start, len(next(iter(task_params.values()))))
    same = [(value == start[name]).flatten(1).all(-1) for name, value in task_params.items()]
    return int(torch.stack(same).all(0).sum())


def task_slices(tasks: int, steps: int = STEPS_AT_ONCE) -> list[slice]:
    """Return slices that cover ``tasks`` tasks of ``steps`` steps each: a few at once, more if short."""
    at_once = max(TASKS_AT_ONCE, STEPS_AT_ONCE // max(1, steps))
    return [slice(first, first + at_once) for first in range(0, tasks, at_once)]

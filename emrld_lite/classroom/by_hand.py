"""What takes a student's own parts: Algorithm 1 with every task alone, its losses functions of a vector.

The package takes all tasks in one batch; functions that are written for one parameter vector train the
same policy here, a task at a time. Until a part is written, the one below of its name stands for it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor

from ..adapt import Adaptation
from ..demonstrations import Demonstrations
from ..learners import TaskData, Trpo, policies_after
from ..losses import bc_loss, rl_loss
from ..policy import Gaussian, Params, Vector, distribution, from_vector, log_density
from ..rollout import Rollout
from ..trpo import Step, surrogate_and_kl, trpo_step
from .checks.values import as_graph

OfTheta = Callable[[Vector], Tensor]


class OneTask(NamedTuple):
    """One task's data of one iteration; what depends on a policy is a function of its vector."""

    rl_loss: OfTheta
    """L^RL on D^tr, a scalar."""
    bc_loss: OfTheta
    """L^BC on D^dem, a scalar."""
    log_prob: OfTheta | None = None
    """Log-densities of the actions in D^val, (episode, time)."""
    collected_with: Vector | None = None
    """theta_{k,i}, whose policy collected D^val."""
    advantages: Tensor | None = None
    """Advantages in D^val, (episode, time)."""
    mask: Tensor | None = None
    """1 where a step of D^val was taken, (episode, time)."""


def separate(
    like: Params, before: Rollout, demonstrations: Demonstrations, rule: Adaptation
) -> list[OneTask]:
    """Return the tasks of D^tr and D^dem, each alone; ``like`` gives the shapes of a policy."""

    def one_task(task: int) -> OneTask:
        part = slice(task, task + 1)
        episodes, shown = before.take(part), demonstrations.take(part)
        return OneTask(
            lambda theta: rl_loss(params_of(theta, like), episodes, rule.log_density)[0],
            lambda theta: bc_loss(
                params_of(theta, like), shown, rule.bc_reduction, rule.log_density
            )[0],
        )

    return [one_task(task) for task in range(len(before.rewards))]


def with_validation(
    tasks: Sequence[OneTask], like: Params, after: Rollout, adapted: Sequence[Vector]
) -> list[OneTask]:
    """Return the tasks with their D^val, which the policies ``adapted`` have collected."""

    def complete(task: OneTask, number: int) -> OneTask:
        states, actions = after.states[number][None], after.actions[number][None]
        return task._replace(
            log_prob=lambda theta: log_density(
                distribution(params_of(theta, like), states), actions
            )[0],
            collected_with=adapted[number].detach(),
            advantages=after.advantages[number],
            mask=after.mask[number],
        )

    return [complete(task, number) for number, task in enumerate(tasks)]


def params_of(theta: Vector, like: Params) -> Params:
    """Return a vector as parameters of a policy, in the precision of ``like`` and in theta's graph."""
    return from_vector(theta.to(next(iter(like.values())).dtype), like)


def together(vectors: Sequence[Vector], like: Params) -> Params:
    """Return the vectors of all tasks as ``task_params``."""
    each = [params_of(vector.detach(), like) for vector in vectors]
    return {name: torch.stack([params[name] for params in each]) for name in like}


def vectors(step: Callable[..., Any]) -> Callable[..., Vector]:
    """Return the step with its answer as a tensor in theta's precision, whatever held it."""

    def stepped(theta: Vector, *rest: Any) -> Vector:
        return as_graph(step(theta, *rest), theta.shape, "the adapted parameters").to(theta.dtype)

    return stepped


def adaptation_step(
    theta: Vector, rl_loss: OfTheta, bc_loss: OfTheta, w_rl: float, w_bc: float, alpha: float
) -> Vector:
    """Return theta_i of equation (adapt_rl_bc) for one task, in theta's graph."""
    loss = w_rl * rl_loss(theta) + w_bc * bc_loss(theta)
    (gradient,) = torch.autograd.grad(loss, theta, create_graph=True)
    return theta - alpha * gradient


def surrogate(new: Tensor, old: Tensor, advantages: Tensor, mask: Tensor) -> Tensor:
    """Return TRPO's surrogate of one task from log-densities, (episode, time)."""
    return -(torch.exp(new - old) * advantages * mask).sum() / mask.sum()


def meta_loss(
    theta: Vector,
    tasks: Sequence[OneTask],
    adapted: Callable[[Vector, OneTask], Vector],
    surrogate: Callable[..., Tensor],
) -> Tensor:
    """Return the mean over tasks of the surrogate after adaptation, a scalar in theta's graph."""
    losses = []
    for task in tasks:
        old = task.log_prob(task.collected_with)
        new = task.log_prob(adapted(theta, task))
        losses.append(surrogate(new, old, task.advantages, task.mask))
    return torch.stack(losses).mean()


def trust_region_step(
    learner: Trpo,
    params: Params,
    surrogate: float,
    gradient: Vector,
    data: TaskData,
    rule: Adaptation,
    random: torch.Generator,
) -> tuple[Params, Step]:
    """Return theta_{k+1}: the package's TRPO step along a meta-gradient that was computed elsewhere.

    Fisher matrix, conjugate gradient and line search are notebook 05's.
    """
    tasks = len(data.after.rewards)
    old = Gaussian(*(output.detach() for output in policies_after(params, data, rule)))

    def exact(trial: Params) -> tuple[float, float]:
        value, kl = surrogate_and_kl(policies_after(trial, data, rule), old, data.after)
        return value / tasks, kl / tasks

    product = learner.fisher(params, data, rule, random)
    region = learner.region.for_actions(data.after.actions.shape[-1])
    return trpo_step(params, surrogate, learner.smoothed(gradient), product, exact, region)


def what_parts_add(
    run: Callable[..., float], full: tuple[float, float, bool], seeds: Sequence[int]
) -> dict[str, tuple[float, float]]:
    """Return by how much the return falls without each part of the adaptation, and the error of that.

    ``run(w_rl, w_bc, warm, seed)`` gives a mean return; the error is the standard error over seeds.
    """
    w_rl, w_bc, _ = full
    settings = {
        "RL": (0.0, w_bc, True),
        "cloning": (w_rl, 0.0, True),
        "warm start": (w_rl, w_bc, False),
    }
    whole = torch.tensor([run(*full, seed) for seed in seeds])
    effects = {}
    for part, setting in settings.items():
        drops = whole - torch.tensor([run(*setting, seed) for seed in seeds])
        effects[part] = (float(drops.mean()), float(drops.std() / len(seeds) ** 0.5))
    return effects

"""Exact EMRLD on softmax tables: adaptation and meta-update with no estimator anywhere.

Both are differentiated through the linear solves of ``mdp``. A policy is a table of preferences
theta, (state, action), and pi = softmax(theta); one table per task is (task, state, action).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from ..adapt import Adaptation, gradient_step
from ..validation import InputError, check_choice, positive_count, real_number
from .mdp import TabularMDP, expect_shape, numbers, stack
from .theorem import (
    MetaStep,
    Policies,
    RelatedBounds,
    Theorem1,
    checked_policies,
    related_of,
    theorem_of,
)

INNER_LOSSES = ("exact", "log", "ratio")
HALVINGS = 20  # of the meta step before it is given up


@dataclass(frozen=True, eq=False)
class ExactMetaRL:
    """A task family with demonstrators, and how theta is adapted to each task."""

    mdps: Sequence[TabularMDP]
    """One MDP a task, of one shape and discount."""
    task_weights: Tensor
    """p(i), (task,)."""
    demo: Policies
    """The demonstrator of each task, (state, action)."""
    adaptation: Adaptation
    """Weights, step length and warm start of equation (adapt_rl_bc)."""
    inner_loss: str = "exact"
    """What the adaptation differentiates: "exact" is -J; "log" and "ratio" are the expectations of
    the sampled surrogates, whose first derivative is the same and whose second is not."""

    def __post_init__(self) -> None:
        check_choice("inner_loss", self.inner_loss, INNER_LOSSES)
        checked_policies("demo", self.demo, stack(self.mdps))
        for option in ("second_order", "bc_reduction"):
            chosen, usual = getattr(self.adaptation, option), getattr(Adaptation, option)
            if chosen != usual:
                raise InputError(
                    f"adaptation.{option}: expected {usual!r}, since exact losses are expectations "
                    f"and first_order_gradient is there for the other; got {chosen!r}"
                )
        step = MetaStep.of(self.mdps, self.task_weights, self.demo, self.demo, self.demo)
        object.__setattr__(self, "_solved", step)

    def rl_loss(self, task_theta: Tensor) -> Tensor:
        """Return L^RL = -J of each task, (task,), as ``inner_loss`` says. Section 2."""
        tasks, policy = self._solved.tasks, task_theta.softmax(-1)
        if self.inner_loss == "exact":
            return -tasks.objective(policy)
        frozen = policy.detach()
        score = task_theta.log_softmax(-1) if self.inner_loss == "log" else policy / frozen
        visits = tasks.visitation(frozen)[..., None] * frozen  # (task, state, action)
        total = (visits * tasks.advantage(frozen) * score).sum((-2, -1))
        return -total / (1 - tasks.discount)

    def bc_loss(self, task_theta: Tensor) -> Tensor:
        """Return L^BC = -E_{s ~ d^dem, a ~ dem} log pi(a|s) of each task, (task,). Section 3."""
        log_policy = task_theta.log_softmax(-1)
        visits = self._solved.visits_demo[..., None] * self._solved.demo
        return -(visits * log_policy).sum((-2, -1))

    def adapt(self, theta: Tensor, keep_graph: bool = False) -> Tensor:
        """Return theta_i = theta - alpha grad(w_rl L^RL_i + w_bc L^BC_i), (task, state, action)."""
        chosen = self.adaptation
        params = {"theta": theta.expand(len(self.mdps), *theta.shape)}

        def cloning(params: dict[str, Tensor]) -> Tensor:
            return self.bc_loss(params["theta"])

        def both(params: dict[str, Tensor]) -> Tensor:
            total = chosen.w_bc * self.bc_loss(params["theta"])
            if chosen.w_rl:
                total = total + chosen.w_rl * self.rl_loss(params["theta"])
            return total

        if chosen.warm_start:
            params = gradient_step(cloning, params, chosen.adapt_lr, keep_graph, second_order=True)
        return gradient_step(both, params, chosen.adapt_lr, keep_graph, second_order=True)["theta"]

    def meta_objective(self, theta: Tensor, keep_graph: bool = False) -> Tensor:
        """Return J_meta(theta) = E_{i ~ p} J_i(pi_{theta_i}). Section 3."""
        return self._solved.objective(self.adapt(theta, keep_graph).softmax(-1))

    def meta_gradient(self, theta: Tensor) -> Tensor:
        """Return the derivative of J_meta through the adaptation, (state, action)."""
        theta = self._table(theta).clone().requires_grad_()
        return torch.autograd.grad(self.meta_objective(theta, keep_graph=True), theta)[0]

    def first_order_gradient(self, theta: Tensor) -> Tensor:
        """Return the derivative of J_meta with the adaptation's Jacobian taken to be the identity."""
        task_theta = self.adapt(self._table(theta)).requires_grad_()
        total = self._solved.objective(task_theta.softmax(-1))
        return torch.autograd.grad(total, task_theta)[0].sum(0)

    def _table(self, theta: Tensor) -> Tensor:
        theta = numbers("theta", theta)
        expect_shape("theta", theta, self._solved.demo.shape[1:])
        return theta.detach()


class ExactIterate(NamedTuple):
    """The state before one exact meta-iteration, and what Theorem 1 says of the step."""

    iteration: int
    """Number of the meta-iteration, from 0."""
    theta: Tensor
    """Meta-parameter, (state, action)."""
    objective: float
    """J_meta(theta)."""
    demonstrator: float
    """The demonstrators' mean objective."""
    theorem: Theorem1
    """Theorem 1 for the step from this iterate to the next."""
    related: RelatedBounds
    """The bounds beside it."""


def exact_meta_train(
    problem: ExactMetaRL, meta_lr: float, iterations: int
) -> Iterator[ExactIterate]:
    """Yield the iterates of theta <- theta + beta grad J_meta(theta), from theta = 0.

    Equation (meta-update-emrld). beta is ``meta_lr``, halved until J_meta does not fall: the exact
    counterpart of TRPO's line search. Raises InputError for numbers that cannot be used.
    """
    real_number("meta_lr", meta_lr, minimum=0.0)
    positive_count("iterations", iterations)
    theta = torch.zeros_like(problem.mdps[0].reward)
    demonstrator = float(problem._solved.objective(problem._solved.demo))
    old = problem.adapt(theta).softmax(-1)
    for iteration in range(iterations):
        following, new = _meta_step(problem, theta, meta_lr)
        step = MetaStep.of(problem.mdps, problem.task_weights, old, new, problem.demo)
        yield ExactIterate(
            iteration,
            theta,
            float(step.objective(old)),
            demonstrator,
            theorem_of(step),
            related_of(step),
        )
        theta, old = following, new


def _meta_step(problem: ExactMetaRL, theta: Tensor, meta_lr: float) -> tuple[Tensor, Tensor]:
    """Return the next theta and its adapted policies, (task, state, action)."""
    gradient, before = problem.meta_gradient(theta), problem.meta_objective(theta)
    for halvings in range(HALVINGS):
        following = theta + meta_lr * 0.5**halvings * gradient
        new = problem.adapt(following).softmax(-1)
        if problem._solved.objective(new) >= before:
            return following, new
    return theta, problem.adapt(theta).softmax(-1)

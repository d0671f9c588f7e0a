"""Theorem 1 on finite task families: the paper's bound, its parts, and the bounds around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import torch
from torch import Tensor

from ..validation import InputError
from .mdp import TabularMDP, distributions, numbers, stack

Policies = Sequence[Tensor]


@dataclass(frozen=True, eq=False)
class MetaStep:
    """One meta-iteration, from the adapted policies pi_k,i to pi_k+1,i, on a whole task family.

    Leading axes are (task, ...), where (...) are families in a batch.
    """

    tasks: TabularMDP
    """All tasks, stacked along a leading task axis."""
    weights: Tensor
    """p(i), (task, ...)."""
    old: Tensor
    """pi_k,i, (task, ..., state, action)."""
    new: Tensor
    """pi_k+1,i, (task, ..., state, action)."""
    demo: Tensor
    """pi^dem_i, (task, ..., state, action)."""
    advantage: Tensor
    """A_i^{pi_k,i}, (task, ..., state, action)."""
    visits_old: Tensor
    """d_i^{pi_k,i}, (task, ..., state)."""
    visits_new: Tensor
    """d_i^{pi_k+1,i}, (task, ..., state)."""
    visits_demo: Tensor
    """d_i^{pi^dem_i}, (task, ..., state)."""

    @classmethod
    def of(
        cls,
        mdps: Sequence[TabularMDP],
        task_weights: Tensor,
        old: Policies,
        new: Policies,
        demo: Policies,
    ) -> MetaStep:
        """Solve the family for three policies per task; raises InputError that names the argument."""
        tasks = stack(mdps)
        weights = _task_weights(task_weights, tasks)
        policies = [
            checked_policies(name, given, tasks)
            for name, given in (("old", old), ("new", new), ("demo", demo))
        ]
        visits = [tasks.visitation(policy) for policy in policies]
        return cls(tasks, weights, *policies, tasks.advantage(policies[0]), *visits)

    @property
    def discount(self) -> Tensor:
        """gamma, () or (...)."""
        return self.tasks.discount[0] if self.tasks.discount.dim() else self.tasks.discount

    def mean(self, a_task: Tensor) -> Tensor:
        """Return E_{i ~ p}, (...), of numbers (task, ...)."""
        return (self.weights * a_task).sum(0)

    def under(self, visits: Tensor, a_state: Tensor) -> Tensor:
        """Return E_{i ~ p, s ~ visits}, (...), of numbers (task, ..., state)."""
        return self.mean((visits * a_state).sum(-1))

    def objective(self, policy: Tensor) -> Tensor:
        """Return J_meta, (...), of adapted policies (task, ..., state, action)."""
        return self.mean(self.tasks.objective(policy))


def _task_weights(task_weights: Tensor, tasks: TabularMDP) -> Tensor:
    weights = numbers("task_weights", task_weights)
    batch = tuple(tasks.reward.shape[:-2])  # (task, ...)
    if weights.dim() == 0 or tuple(weights.shape) not in (batch[:1], batch):
        raise InputError(
            f"task_weights: expected shape {batch[:1]}, one per task, got {tuple(weights.shape)}"
        )
    weights = distributions("task_weights", weights.movedim(0, -1)).movedim(-1, 0)
    return weights.reshape(weights.shape + (1,) * (len(batch) - weights.dim()))


def checked_policies(name: str, given: Policies, tasks: TabularMDP) -> Tensor:
    """Return one policy per task as (task, ..., state, action); raises InputError under ``name``."""
    given, shape = list(given), tuple(tasks.reward.shape)
    if len(given) != shape[0]:
        raise InputError(f"{name}: expected {shape[0]} policies, one per task, got {len(given)}")
    checked = []
    for task, policy in enumerate(given):
        policy = numbers(f"{name}[{task}]", policy)
        if tuple(policy.shape) != shape[1:]:
            raise InputError(
                f"{name}[{task}]: expected shape {shape[1:]}, got {tuple(policy.shape)}"
            )
        checked.append(distributions(f"{name}[{task}]", policy))
    return torch.stack(checked)


def total_variation(one: Tensor, other: Tensor) -> Tensor:
    """Return D_TV = 1/2 sum_a |one - other| in each state, (..., state). Section 2."""
    return 0.5 * (one - other).abs().sum(-1)


@dataclass(frozen=True, eq=False)
class Theorem1:
    """Every part of Theorem 1; all are (...), one number per family.

    ``improvement >= bound_average_delta >= bound_group_2 >= bound`` always holds.
    """

    improvement: Tensor
    """J_meta(pi_k+1) - J_meta(pi_k), what the theorem bounds from below."""
    surrogate: Tensor
    """E_{i, s ~ d^old} sum_a pi_k+1 A, the first term of group one, before its 1/(1 - gamma)."""
    c1: Tensor
    """C1 = max over tasks, states and actions of |A|."""
    delta: Tensor
    """The largest Delta that Assumption 1 allows: min over tasks and states of E_{a ~ dem} A."""
    average_delta: Tensor
    """E_{i, s ~ d^new, a ~ dem} A, all that the proof needs of Delta."""
    tv_old: Tensor
    """E_i D_TV^{pi_k,i}(pi_k+1,i, pi_k,i)."""
    tv_demo: Tensor
    """E_i D_TV^{pi_k+1,i}(pi_k+1,i, pi^dem_i)."""
    group_1: Tensor
    """(surrogate - 2 C1 tv_old) / (1 - gamma); never positive."""
    group_2: Tensor
    """(delta - 2 C1 tv_demo) / (1 - gamma)."""
    bound: Tensor
    """group_1 + group_2, the theorem as printed."""
    bound_group_2: Tensor
    """group_2 alone, a valid bound and never below the printed one."""
    bound_average_delta: Tensor
    """(average_delta - 2 C1 tv_demo) / (1 - gamma), the best of the three."""


def theorem_1(
    mdps: Sequence[TabularMDP], task_weights: Tensor, old: Policies, new: Policies, demo: Policies
) -> Theorem1:
    """Evaluate Theorem 1 exactly; raises InputError that names the argument.

    ``mdps``: one per task, of one shape and discount, each possibly a batch (...) of families.
    ``task_weights`` p(i): (task,) or (task, ...). ``old``, ``new``, ``demo``: one policy
    (..., state, action) per task. Section 3, Theorem 1.
    """
    return theorem_of(MetaStep.of(mdps, task_weights, old, new, demo))


def theorem_of(step: MetaStep) -> Theorem1:
    """Return Theorem 1 of a meta-step that is already solved."""
    c1 = step.advantage.abs().amax((-2, -1)).amax(0)
    demo_advantage = (step.demo * step.advantage).sum(-1)  # (task, ..., state)
    surrogate = step.under(step.visits_old, (step.new * step.advantage).sum(-1))
    delta = demo_advantage.amin(-1).amin(0)
    average_delta = step.under(step.visits_new, demo_advantage)
    tv_old = step.under(step.visits_old, total_variation(step.new, step.old))
    tv_demo = step.under(step.visits_new, total_variation(step.new, step.demo))
    horizon = 1 / (1 - step.discount)
    group_1 = horizon * (surrogate - 2 * c1 * tv_old)
    group_2 = horizon * (delta - 2 * c1 * tv_demo)
    return Theorem1(
        improvement=step.objective(step.new) - step.objective(step.old),
        surrogate=surrogate,
        c1=c1,
        delta=delta,
        average_delta=average_delta,
        tv_old=tv_old,
        tv_demo=tv_demo,
        group_1=group_1,
        group_2=group_2,
        bound=group_1 + group_2,
        bound_group_2=group_2,
        bound_average_delta=horizon * (average_delta - 2 * c1 * tv_demo),
    )


@dataclass(frozen=True, eq=False)
class RelatedBounds:
    """Bounds beside Theorem 1, all (...): one from the literature, and what the substitution makes."""

    trust_region: Tensor
    """Achiam et al. (2017), averaged over tasks: valid, and exact where nothing changes."""
    tv_demo_states: Tensor
    """E_i D_TV^{dem}(pi_k+1,i, pi^dem_i): under the demonstrator's states, as one can sample it."""
    substituted: Tensor
    """The printed bound with tv_demo_states for tv_demo; NOT valid in general."""
    substituted_group_2: Tensor
    """Its second group alone; NOT valid in general."""
    repaired: Tensor
    """(E_{dem} A - 2 C1 tv_demo_states / (1 - gamma)) / (1 - gamma), all under d^dem: valid."""


def related_bounds(
    mdps: Sequence[TabularMDP], task_weights: Tensor, old: Policies, new: Policies, demo: Policies
) -> RelatedBounds:
    """Evaluate the bounds beside Theorem 1, with the arguments of ``theorem_1``.

    Trust region: Achiam et al. (2017), Corollary 1 of Constrained Policy Optimization. The
    substitution: Section 3, after Theorem 1. Its repair is proved in notebook 04.
    """
    return related_of(MetaStep.of(mdps, task_weights, old, new, demo))


def related_of(step: MetaStep) -> RelatedBounds:
    """Return the bounds beside Theorem 1 of a meta-step that is already solved."""
    theorem = theorem_of(step)
    horizon = 1 / (1 - step.discount)
    new_advantage = (step.new * step.advantage).sum(-1)  # (task, ..., state)
    moved = (step.visits_old * total_variation(step.new, step.old)).sum(-1)  # (task, ...)
    price = 2 * step.discount * horizon * step.mean(new_advantage.abs().amax(-1) * moved)
    tv_demo_states = step.under(step.visits_demo, total_variation(step.new, step.demo))
    substituted_group_2 = horizon * (theorem.delta - 2 * theorem.c1 * tv_demo_states)
    demo_advantage = step.under(step.visits_demo, (step.demo * step.advantage).sum(-1))
    return RelatedBounds(
        trust_region=horizon * (theorem.surrogate - price),
        tv_demo_states=tv_demo_states,
        substituted=theorem.group_1 + substituted_group_2,
        substituted_group_2=substituted_group_2,
        repaired=horizon * (demo_advantage - 2 * theorem.c1 * horizon * tv_demo_states),
    )


def as_dict(result: Theorem1 | RelatedBounds) -> dict[str, Tensor]:
    """Return the fields of a result by name."""
    return {field.name: getattr(result, field.name) for field in fields(result)}

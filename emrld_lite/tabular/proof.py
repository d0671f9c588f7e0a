"""The proof of Theorem 1 (Appendix A): each line as two numbers and the relation between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from .mdp import TabularMDP, expect_shape, numbers
from .theorem import MetaStep, Policies, total_variation


@dataclass(frozen=True, eq=False)
class Claims:
    """What the proof takes for granted; each default is the truth, anything else breaks a move."""

    delta: float | None = None
    """Delta of Assumption 1; the truth is the demonstrator's least advantage over tasks and states."""
    c1: float | None = None
    """C1; the truth is the largest |A|."""
    value_error: Tensor | None = None
    """What a critic adds to the true V, (state,); the truth is nothing."""
    demonstrator_states: bool = False
    """Whether D_TV(pi_k+1, dem) is measured under d^dem, as in practice; the theorem has d^{pi_k+1}."""


class ProofLine(NamedTuple):
    """One line of the proof on one family (or a batch of them)."""

    name: str
    """What the line is called here and in the ledger."""
    left: Tensor
    """Left side: (...), or (task, ...) for a statement about every task."""
    relation: str
    """"=", ">=" or "<="."""
    right: Tensor
    """Right side, of the shape of the left one."""
    rule: str
    """The one rule that the line uses."""

    def holds(self, tolerance: float = 1e-9) -> bool:
        """Return whether the relation holds to ``tolerance``, relative to the size of the sides."""
        scale = torch.maximum(self.left.abs(), self.right.abs()).clamp(min=1.0)
        slack = (self.left - self.right) / scale
        if self.relation == "=":
            slack = -slack.abs()
        elif self.relation == "<=":
            slack = -slack
        return bool((slack >= -tolerance).all())


def proof_lines(
    mdps: Sequence[TabularMDP],
    task_weights: Tensor,
    old: Policies,
    new: Policies,
    demo: Policies,
    claims: Claims | None = None,
) -> list[ProofLine]:
    """Evaluate every line of Appendix A, in its order, both sides independently of each other.

    The arguments are those of ``theorem_1``; ``claims`` replaces what the proof takes for granted,
    so that one can see which line falls. Raises InputError that names the argument.
    """
    return lines_of(MetaStep.of(mdps, task_weights, old, new, demo), claims or Claims())


def lines_of(step: MetaStep, claims: Claims) -> list[ProofLine]:
    """Return the proof's lines for a meta-step that is already solved."""
    terms = _Terms(step, claims)
    return [*_performance_difference(step, terms), *_split(terms), *_bound(step, terms)]


class _Terms:
    """The sums that the lines share: advantages as claimed, and expectations under three visitations."""

    def __init__(self, step: MetaStep, claims: Claims) -> None:
        self.advantage = _claimed_advantage(step, claims)
        absolute = self.advantage.abs()
        demo_advantage = (step.demo * step.advantage).sum(-1)
        self.c1 = absolute.amax((-2, -1)).amax(0) if claims.c1 is None else _claim(claims.c1)
        self.delta = (
            demo_advantage.amin(-1).amin(0) if claims.delta is None else _claim(claims.delta)
        )
        self.gap = (1 - step.discount) * (step.objective(step.new) - step.objective(step.old))
        visits_tv = step.visits_demo if claims.demonstrator_states else step.visits_new
        self.tv_demo = step.under(visits_tv, total_variation(step.new, step.demo))
        self.tv_old = step.under(step.visits_old, total_variation(step.new, step.old))
        new_advantage = (step.new * self.advantage).sum(-1)  # (task, ..., state)
        self.new_under_new = step.under(step.visits_new, new_advantage)
        self.new_under_old = step.under(step.visits_old, new_advantage)
        self.second = step.under(step.visits_new - step.visits_old, new_advantage)
        self.demo_under_new = step.under(step.visits_new, (step.demo * self.advantage).sum(-1))
        self.from_demo = step.under(
            step.visits_new, ((step.new - step.demo) * self.advantage).sum(-1)
        )
        self.from_old = step.under(
            step.visits_old, ((step.new - step.old) * self.advantage).sum(-1)
        )
        self.old_under_old = step.under(step.visits_old, (step.old * self.advantage).sum(-1))
        self.size_from_demo = step.under(
            step.visits_new, ((step.new - step.demo).abs() * absolute).sum(-1)
        )
        self.size_from_old = step.under(
            step.visits_old, ((step.new - step.old).abs() * absolute).sum(-1)
        )


def _claim(value: float) -> Tensor:
    return torch.as_tensor(value, dtype=torch.float64)


def _claimed_advantage(step: MetaStep, claims: Claims) -> Tensor:
    """Return A (task, ..., state, action) as a critic with the claimed error would see it."""
    if claims.value_error is None:
        return step.advantage
    error = numbers("value_error", claims.value_error)
    expect_shape("value_error", error, (step.tasks.states,))
    following = (step.tasks.transition * error).sum(-1)
    return step.advantage + step.tasks.discount[..., None, None] * following - error[:, None]


def _performance_difference(step: MetaStep, terms: _Terms) -> list[ProofLine]:
    """Return Lemma 1 and the meta version, equation (meta-PDL)."""
    tasks, horizon = step.tasks, 1 / (1 - step.discount)
    earned = horizon * (step.visits_new * (step.new * tasks.reward).sum(-1)).sum(-1)
    by_task = tasks.objective(step.new) - tasks.objective(step.old)  # (task, ...)
    inner = (step.visits_new * (step.new * terms.advantage).sum(-1)).sum(-1)  # (task, ...)
    joint = step.weights[..., None, None] * step.visits_new[..., None] * step.new
    together = (joint * terms.advantage).sum((-2, -1)).sum(0)
    separate = step.mean(tasks.objective(step.new)) - step.mean(tasks.objective(step.old))
    scale = 1 - step.discount
    return [
        ProofLine(
            "objective",
            tasks.objective(step.new),
            "=",
            earned,
            "start values are discounted sums of rewards over the visits",
        ),
        ProofLine(
            "lemma_1",
            by_task,
            "=",
            horizon * inner,
            "performance difference lemma, in each task: the rewards telescope",
        ),
        ProofLine("meta_definition", terms.gap, "=", scale * separate, "definition of J_meta"),
        ProofLine(
            "meta_linearity",
            scale * separate,
            "=",
            scale * step.mean(by_task),
            "an expectation of a difference is the difference of expectations",
        ),
        ProofLine(
            "meta_lemma",
            scale * step.mean(by_task),
            "=",
            step.mean(inner),
            "Lemma 1 inside the expectation over tasks",
        ),
        ProofLine(
            "meta_joint", step.mean(inner), "=", together, "two expectations make one joint one"
        ),
    ]


def _split(terms: _Terms) -> list[ProofLine]:
    """Return equation (inter) and the four sums of its second term."""
    pieces = terms.demo_under_new + terms.from_demo - terms.from_old - terms.old_under_old
    return [
        ProofLine(
            "add_and_subtract",
            terms.gap,
            "=",
            terms.new_under_new - terms.new_under_old + terms.new_under_old,
            "add and subtract the same expectation under the old visits",
        ),
        ProofLine(
            "inter",
            terms.gap,
            "=",
            terms.new_under_old + terms.second,
            "collect the two expectations that share their actions",
        ),
        ProofLine(
            "second_term",
            terms.second,
            "=",
            pieces,
            "write new = demo + (new - demo) under the new visits, new = old + (new - old) under the old",
        ),
    ]


def _bound(step: MetaStep, terms: _Terms) -> list[ProofLine]:
    """Return (a) with its three facts, (b) with its two, and the theorem."""
    c1, delta = terms.c1, terms.delta
    after_a = delta - terms.size_from_demo - terms.size_from_old
    after_b = delta - 2 * c1 * terms.tv_demo - 2 * c1 * terms.tv_old
    horizon = 1 / (1 - step.discount)
    theorem = horizon * (terms.new_under_old + after_b)
    return [
        ProofLine(
            "a_assumption",
            terms.demo_under_new,
            ">=",
            delta.expand_as(terms.gap),
            "Assumption 1: a mean is at least the minimum",
        ),
        ProofLine(
            "a_zero",
            terms.old_under_old,
            "=",
            torch.zeros_like(terms.gap),
            "an advantage has mean 0 under its own policy",
        ),
        ProofLine(
            "a_absolute_demo",
            terms.from_demo,
            ">=",
            -terms.size_from_demo,
            "a sum is at least minus the sum of absolute values",
        ),
        ProofLine(
            "a_absolute_old",
            -terms.from_old,
            ">=",
            -terms.size_from_old,
            "the same under the old visits",
        ),
        ProofLine("a", terms.second, ">=", after_a, "the four facts above, added up"),
        ProofLine(
            "b_demo",
            terms.size_from_demo,
            "<=",
            2 * c1 * terms.tv_demo,
            "Hoelder: |A| <= C1, and the absolute differences sum to 2 D_TV",
        ),
        ProofLine(
            "b_old",
            terms.size_from_old,
            "<=",
            2 * c1 * terms.tv_old,
            "the same under the old visits",
        ),
        ProofLine("b", after_a, ">=", after_b, "both together (the paper writes =)"),
        ProofLine(
            "theorem",
            horizon * terms.gap,
            ">=",
            theorem,
            "insert (b) in (inter) and divide by 1 - gamma",
        ),
    ]

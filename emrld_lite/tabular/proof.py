"""The proof of Theorem 1 (Appendix A): each line as two numbers and the relation between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from .mdp import TabularMDP, expect_shape, numbers
from .theorem import MetaStep, Policies, total_variation

RULES = {
    "objective": "start values are discounted sums of rewards over the visits",
    "lemma_1": "performance difference lemma, in each task: the values telescope",
    "meta_definition": "definition of J_meta",
    "meta_linearity": "an expectation of a difference is the difference of expectations",
    "meta_lemma": "Lemma 1 inside the expectation over tasks",
    "meta_joint": "two expectations make one joint one",
    "add_and_subtract": "add and subtract the same expectation under the old visits",
    "inter": "collect the two expectations that share their actions",
    "second_term": "new = demo + (new - demo) under new visits, new = old + (new - old) under old",
    "a_assumption": "Assumption 1: a mean is at least the minimum",
    "a_zero": "an advantage has mean 0 under its own policy",
    "a_absolute_demo": "a sum is at least minus the sum of absolute values",
    "a_absolute_old": "the same under the old visits",
    "a": "the four facts above, added up",
    "b_demo": "Hoelder: |A| <= C1, and the absolute differences sum to 2 D_TV",
    "b_old": "the same under the old visits",
    "b": "both together (the paper writes =)",
    "theorem": "insert (b) in (inter) and divide by 1 - gamma",
}


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

    @property
    def slack(self) -> Tensor:
        """How far the relation holds, relative to the sides (or to 1); negative where it fails."""
        scale = torch.maximum(self.left.abs(), self.right.abs()).clamp(min=1.0)
        difference = (self.left - self.right) / scale
        return {"=": -difference.abs(), ">=": difference, "<=": -difference}[self.relation]

    def holds(self, tolerance: float = 1e-9) -> bool:
        """Return whether the relation holds everywhere to ``tolerance``."""
        return bool((self.slack >= -tolerance).all())


def proof_lines(
    mdps: Sequence[TabularMDP],
    task_weights: Tensor,
    old: Policies,
    new: Policies,
    demo: Policies,
    claims: Claims | None = None,
) -> list[ProofLine]:
    """Evaluate both sides of every line of Appendix A, in its order.

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
    tasks, scale = step.tasks, 1 - step.discount
    start = tasks.objective(step.new)  # (task, ...)
    earned = (step.visits_new * (step.new * tasks.reward).sum(-1)).sum(-1) / scale
    by_task = start - tasks.objective(step.old)
    separate = step.mean(start) - step.mean(tasks.objective(step.old))
    inner = (step.visits_new * (step.new * terms.advantage).sum(-1)).sum(-1)  # (task, ...)
    joint = step.weights[..., None, None] * step.visits_new[..., None] * step.new
    together = (joint * terms.advantage).sum((-2, -1)).sum(0)
    return [
        _line("objective", start, "=", earned),
        _line("lemma_1", by_task, "=", inner / scale),
        _line("meta_definition", terms.gap, "=", scale * separate),
        _line("meta_linearity", scale * separate, "=", scale * step.mean(by_task)),
        _line("meta_lemma", scale * step.mean(by_task), "=", step.mean(inner)),
        _line("meta_joint", step.mean(inner), "=", together),
    ]


def _split(terms: _Terms) -> list[ProofLine]:
    """Return equation (inter) and the four sums of its second term."""
    cancelled = terms.new_under_new - terms.new_under_old + terms.new_under_old
    pieces = terms.demo_under_new + terms.from_demo - terms.from_old - terms.old_under_old
    return [
        _line("add_and_subtract", terms.gap, "=", cancelled),
        _line("inter", terms.gap, "=", terms.new_under_old + terms.second),
        _line("second_term", terms.second, "=", pieces),
    ]


def _bound(step: MetaStep, terms: _Terms) -> list[ProofLine]:
    """Return (a) with its four facts, (b) with its two, and the theorem."""
    delta, scale = terms.delta.expand_as(terms.gap), 1 - step.discount
    after_a = delta - terms.size_from_demo - terms.size_from_old
    distance_demo, distance_old = 2 * terms.c1 * terms.tv_demo, 2 * terms.c1 * terms.tv_old
    after_b = delta - distance_demo - distance_old
    return [
        _line("a_assumption", terms.demo_under_new, ">=", delta),
        _line("a_zero", terms.old_under_old, "=", torch.zeros_like(terms.gap)),
        _line("a_absolute_demo", terms.from_demo, ">=", -terms.size_from_demo),
        _line("a_absolute_old", -terms.from_old, ">=", -terms.size_from_old),
        _line("a", terms.second, ">=", after_a),
        _line("b_demo", terms.size_from_demo, "<=", distance_demo),
        _line("b_old", terms.size_from_old, "<=", distance_old),
        _line("b", after_a, ">=", after_b),
        _line("theorem", terms.gap / scale, ">=", (terms.new_under_old + after_b) / scale),
    ]


def _line(name: str, left: Tensor, relation: str, right: Tensor) -> ProofLine:
    return ProofLine(name, left, relation, right, RULES[name])

"""Checks of notebook 04 that have many right answers: a family that breaks a bound, one that meets it."""

from __future__ import annotations

from typing import Any

import torch

from ...tabular import TabularMDP, proof_lines, related_bounds, slippery_pair, theorem_1
from ...tabular.families import Family
from ..proof_drops import drops
from .answers import Student, Wrong, answered
from .values import as_number, as_parts, as_tensor

LEAD = 0.25  # of the demonstrator in the swamp
PROMISED, LOST = 0.1, -0.4  # per step: what the bound must promise, what must come of it
REWARDS = (1.0, 0.0, -1.0)  # of the three actions in the one state of the bonus
GAIN, SLACK = 0.2, 2e-3  # per step: the least improvement, and how far below it the bound may lie
ROUNDING = 2e-3  # how far from 1 three probabilities may sum
TOO_LOOSE = {
    "a_absolute_demo": "the new policy is better than the demonstrator, and pays for the distance "
    "all the same. Go no further than the demonstrator.",
    "b_demo": "the new policy and the demonstrator differ in the action whose |A| is below C1, and "
    "the distance counts it as if it were C1.",
    "a_absolute_old": "the step also makes a worse action more likely. Let it only take from worse "
    "actions and give to better ones.",
    "b_old": "the step changes how often the action is taken whose |A| is below C1, and the "
    "distance counts it as if it were C1.",
}


@answered
def break_the_substitution(student: Student) -> None:
    """Check the counterexample: f() -> (discount, slip) with a promise of 0.1 and a loss of 0.4."""
    got = as_parts(student(), 2, "two numbers, discount and slip")
    discount, slip = (as_number(part, "two plain numbers, discount and slip") for part in got)
    if not 0 <= discount < 1:
        raise Wrong(f"the discount must lie in [0, 1), yours is {discount:g}.")
    if not 0 <= slip <= 0.5 - LEAD:
        raise Wrong(f"the slip must lie in [0, {0.5 - LEAD:g}], yours is {slip:g}.")
    promised, true = _promised_and_true(discount, slip)
    if promised < PROMISED:
        raise Wrong(f"the bound promises only {promised:.3f} per step: the slip is too large.")
    if true > LOST and _promised_and_true(0.9999, slip)[1] > LOST:
        raise Wrong(
            f"the truth is {true:.3f} per step, above {LOST}, and with a slip of {slip:g} no discount "
            "makes it worse: how does the new policy get into the swamp?"
        )
    if true > LOST:
        raise Wrong(
            f"the bound promises {promised:.3f} per step, but the truth is {true:.3f}, above {LOST}: "
            "keep the swamp visited for longer, with a larger discount."
        )


def _promised_and_true(discount: float, slip: float) -> tuple[float, float]:
    """Return what the substituted bound promises per step, and the true improvement per step."""
    family = slippery_pair(discount, slip, LEAD)
    promised = (1 - discount) * float(related_bounds(*family).substituted)
    return promised, (1 - discount) * float(theorem_1(*family).improvement)


@answered
def tight_step(student: Student) -> None:
    """Check the bonus: f() -> (demo, new), each three probabilities, on which the bound is exact."""
    got = as_parts(student(), 2, "two policies, the demonstrator and the new one")
    demo = _policy(got[0], "the demonstrator")
    new = _policy(got[1], "the new policy")
    family = _one_state(demo, new)
    lines = proof_lines(*family)
    share = 1 - float(family[0][0].discount)
    gain = share * float(theorem_1(*family).improvement)
    if gain < GAIN - 1e-6:
        raise Wrong(
            f"the new policy gains {gain:.3f} per step, {GAIN} are asked for: move more probability "
            "from the worst action to the best one."
        )
    lost = {name: float(drop) for name, drop in drops(lines).items()}
    worst = max(lost, key=lambda name: lost[name])
    if sum(lost.values()) > SLACK:
        raise Wrong(
            f"the bound lies {sum(lost.values()):.3f} per step below the truth: {TOO_LOOSE[worst]}"
        )


def _policy(value: Any, whose: str) -> torch.Tensor:
    """Return three probabilities, scaled to a sum of exactly 1; raise Wrong where they are none."""
    policy = as_tensor(value, (len(REWARDS),), f"three probabilities of {whose}")
    if (policy < 0).any():
        raise Wrong(f"the probabilities of {whose} must not be negative, one is {policy.min():g}.")
    if abs(float(policy.sum()) - 1) > ROUNDING:
        raise Wrong(f"the probabilities of {whose} must sum to 1, yours to {policy.sum():g}.")
    return policy / policy.sum()


def _one_state(demo: torch.Tensor, new: torch.Tensor) -> Family:
    """Return the one-state family of the bonus: an even old policy, and the two given ones."""
    count = len(REWARDS)
    mdp = TabularMDP(torch.ones(1, count, 1), [list(REWARDS)], [1.0], 0.9)
    old = torch.full((1, count), 1 / count, dtype=torch.float64)
    return [mdp], torch.ones(1), [old], [new[None]], [demo[None]]

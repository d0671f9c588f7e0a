"""Checks of notebook 04: Theorem 1."""

from __future__ import annotations

import math

import torch

from ...tabular import related_bounds, slippery_pair, theorem_1
from .answers import Student, Wrong, answered, as_tensor, close, draws

LEAD = 0.25  # of the demonstrator in the last exercise


def _world() -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return a random transition (4, 3, 4), start (4,) and two policies (4, 3)."""
    normal = draws(8)
    return (
        normal(4, 3, 4).softmax(-1),
        normal(4).softmax(-1),
        normal(4, 3).softmax(-1),
        normal(4, 3).softmax(-1),
    )


@answered
def visitation(student: Student) -> None:
    """Check d: f(transition, initial, policy, discount) -> (state,)."""
    transition, initial, policy, _ = _world()
    discount = 0.8
    got = as_tensor(student(transition, initial, policy, discount), (4,), "one share per state")
    step = torch.zeros(4, 4, dtype=torch.float64)  # (state, next state)
    for action in range(3):
        step += policy[:, action, None] * transition[:, action]

    def followed(start: torch.Tensor, step: torch.Tensor, rate: float) -> torch.Tensor:
        total, now = torch.zeros_like(start), start
        for _ in range(300):
            total, now = total + now, rate * now @ step
        return total

    expected = (1 - discount) * followed(initial, step, discount)
    if close(got, expected):
        return
    if close(got, expected / (1 - discount)):
        raise Wrong("the factor 1 - gamma is missing: the shares must sum to 1.")
    if close(got, (1 - discount) * followed(initial, step.T, discount)):
        raise Wrong("you follow the chain backwards: transpose the matrix of one step.")
    even = transition.mean(1)
    if close(got, (1 - discount) * followed(initial, even, discount)):
        raise Wrong("the actions must be weighted by the policy, not evenly.")
    if close(got, followed(initial, step, 0.0)):
        raise Wrong("that is where the walk starts; where does it go on to?")
    raise Wrong("the numbers differ. Solve (I - gamma P_pi)^T d = (1 - gamma) rho.")


@answered
def performance_difference(student: Student) -> None:
    """Check Lemma 1: f(advantage, visits_old, visits_new, old, new, discount) -> a number."""
    _, start, old, new = _world()
    advantage = draws(9)(4, 3)
    advantage = advantage - (old * advantage).sum(-1, keepdim=True)
    visits_old, visits_new = start, draws(10)(4).softmax(-1)
    got = student(advantage, visits_old, visits_new, old, new, 0.8)
    value = as_tensor(got, (), "a single number")

    def lemma(visits: torch.Tensor, policy: torch.Tensor) -> torch.Tensor:
        return torch.einsum("s,sa,sa->", visits, policy, advantage) / 0.2

    expected = lemma(visits_new, new)
    if close(value, expected):
        return
    if close(value, lemma(visits_old, new)):
        raise Wrong("that is the surrogate: the lemma has the states of the new policy.")
    if close(value, 0.0 * value):
        raise Wrong("with the old policy's actions its own advantage averages to 0.")
    if close(value, 0.2 * expected):
        raise Wrong("the factor 1 / (1 - gamma) is missing.")
    if close(value, (visits_new[:, None] * advantage).sum() / 0.2):
        raise Wrong("the actions must be weighted by the new policy.")
    raise Wrong("the numbers differ. New states, new actions, old advantage, over 1 - gamma.")


@answered
def assumption_numbers(student: Student) -> None:
    """Check C1 and Delta: f(advantage, demo), both (task, state, action), -> (c1, delta)."""
    normal = draws(11)
    advantage, demo = normal(3, 4, 2), normal(3, 4, 2).softmax(-1)
    advantage[1, 2] -= 3.0  # so that the largest |A| is negative
    got = student(advantage, demo)
    if not isinstance(got, tuple) or len(got) != 2:
        raise Wrong(f"expected two numbers, C1 and Delta, got {type(got).__name__}.")
    c1, delta = (as_tensor(part, (), "a single number") for part in got)
    gains = (demo * advantage).sum(-1)
    if close(c1, advantage.max()):
        raise Wrong("C1 is the largest absolute value; a very bad action counts too.")
    if not close(c1, advantage.abs().max()):
        raise Wrong("C1 differs: the largest |A| over all tasks, states and actions.")
    if close(delta, gains.mean()):
        raise Wrong("Delta must hold in every state of every task: not the mean, the minimum.")
    if close(delta, gains.max()):
        raise Wrong("Delta is the largest number below all of them: the minimum.")
    if close(delta, advantage.min()):
        raise Wrong("average over the demonstrator's actions before you take the minimum.")
    if not close(delta, gains.min()):
        raise Wrong("Delta differs: the minimum over tasks and states of sum_a dem(a|s) A(s, a).")


@answered
def likelihood_distance(student: Student) -> None:
    """Check Pinsker: f(cloning_loss, entropy) -> the largest mean total variation they allow."""
    loss, entropy = draws(12)(1)[0].abs() + 1.0, draws(13)(1)[0].abs() * 0.2
    value = as_tensor(student(loss, entropy), (), "a single number")
    expected = torch.sqrt((loss - entropy) / 2)
    if close(value, expected):
        return
    if close(value, torch.sqrt(loss / 2)):
        raise Wrong("the divergence is the loss minus the demonstrator's entropy.")
    if close(value, torch.sqrt(loss - entropy)):
        raise Wrong("the half is missing: D_TV <= sqrt(KL / 2).")
    if close(value, (loss - entropy) / 2):
        raise Wrong("the square root is missing: D_TV <= sqrt(KL / 2).")
    if close(value, torch.sqrt((loss + entropy) / 2)):
        raise Wrong("the sign of the entropy is turned: KL = loss - entropy.")
    raise Wrong("the numbers differ. KL = loss - entropy, then Pinsker's inequality.")


@answered
def break_the_substitution(student: Student) -> None:
    """Check the counterexample: f() -> (discount, slip) with a promise of 0.1 and a loss of 0.4."""
    got = student()
    if not isinstance(got, tuple) or len(got) != 2:
        raise Wrong(f"expected two numbers, discount and slip, got {type(got).__name__}.")
    if not all(isinstance(part, int | float) and math.isfinite(part) for part in got):
        raise Wrong("expected two plain numbers, discount and slip.")
    discount, slip = (float(part) for part in got)
    if not 0 <= discount < 1:
        raise Wrong(f"the discount must lie in [0, 1), yours is {discount:g}.")
    if not 0 <= slip <= 0.5 - LEAD:
        raise Wrong(f"the slip must lie in [0, {0.5 - LEAD:g}], yours is {slip:g}.")
    family = slippery_pair(discount, slip, LEAD)
    promised = (1 - discount) * float(related_bounds(*family).substituted)
    true = (1 - discount) * float(theorem_1(*family).improvement)
    if promised < 0.1:
        raise Wrong(f"the bound promises only {promised:.3f} a step: the slip is too large.")
    if true > -0.4:
        raise Wrong(
            f"the bound promises {promised:.3f} a step, but the truth is {true:.3f}, above -0.4: "
            "keep the swamp visited for longer, with a larger discount."
        )

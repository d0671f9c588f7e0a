"""Checks of notebook 04: the terms of Theorem 1. In double precision, as the notebook's tables are."""

from __future__ import annotations

import torch

from .answers import Student, answered
from .calls import ask
from .values import as_parts, as_tensor, draws, judge

# (states, actions, discount)
WORLDS = ((4, 3, 0.8), (3, 2, 0.95), (5, 4, 0.6), (2, 2, 0.9))


def _world(states: int, actions: int, seed: int) -> tuple[torch.Tensor, ...]:
    """Return a random transition (s, a, s), start (s,) and two policies (s, a)."""
    normal = draws(seed)
    return (
        (2 * normal(states, actions, states)).softmax(-1),
        normal(states).softmax(-1),
        normal(states, actions).softmax(-1),
        normal(states, actions).softmax(-1),
    )


def _followed(start: torch.Tensor, step: torch.Tensor, rate: float) -> torch.Tensor:
    """Return the sum over time of where a chain is, weighed by rate^t."""
    total, now = torch.zeros_like(start), start
    for _ in range(1000):
        total, now = total + now, rate * now @ step
    return total


@answered
def visitation(student: Student) -> None:
    """Check d: f(transition, initial, policy, discount) -> (state,)."""
    for seed, (states, actions, discount) in enumerate(WORLDS, start=8):
        transition, initial, policy, _ = _world(states, actions, seed)
        got = ask(student, transition, initial, policy, discount).answer
        value = as_tensor(got, (states,), "one share per state")
        _judge_visitation(value, transition, initial, policy, discount)


def _judge_visitation(
    value: torch.Tensor,
    transition: torch.Tensor,
    initial: torch.Tensor,
    policy: torch.Tensor,
    discount: float,
) -> None:
    """Compare the visitation; name the mistake that it equals."""
    step = sum(policy[:, a, None] * transition[:, a] for a in range(policy.shape[1]))
    count = len(initial)
    walked = _followed(initial, step, discount)
    share = 1 - discount
    mistakes = {
        "the factor 1 - gamma is missing: the shares must sum to 1.": walked,
        "you follow the chain backwards: transpose the matrix of one step.": (
            share * _followed(initial, step.T, discount)
        ),
        "the actions must be weighted by the policy, not evenly.": (
            share * _followed(initial, transition.mean(1), discount)
        ),
        "that is where the walk starts; where does it go on to?": initial,
        "that is where the walk starts, times 1 - gamma; where does it go on to?": share * initial,
        "that is where one step leads to; follow the walk for ever.": initial @ step,
        "the walk starts at `initial`, not evenly in every state.": (
            share * _followed(torch.full_like(initial, 1 / count), step, discount)
        ),
        "the start itself is visited, too: the sum begins at time 0.": share * (walked - initial),
        "the weight of time t is gamma^t.": walked / count,
    }
    hint = "the numbers differ. Solve (I - gamma P_pi)^T d = (1 - gamma) rho."
    judge(value, share * walked, mistakes, hint)


@answered
def performance_difference(student: Student) -> None:
    """Check Lemma 1: f(advantage, visits_old, visits_new, old, new, discount) -> a number."""
    for seed, (states, actions, discount) in enumerate(WORLDS, start=20):
        _, visits_old, old, new = _world(states, actions, seed)
        normal = draws(seed + 40)
        advantage = 2 * normal(states, actions)
        advantage = advantage - (old * advantage).sum(-1, keepdim=True)
        visits_new = normal(states).softmax(-1)
        got = ask(student, advantage, visits_old, visits_new, old, new, discount).answer
        value = as_tensor(got, (), "a single number")
        _judge_lemma(value, advantage, (visits_old, visits_new), (old, new), discount)


def _judge_lemma(
    value: torch.Tensor, advantage: torch.Tensor, visits: tuple, policies: tuple, discount: float
) -> None:
    """Compare the difference of performance; name the mistake that it equals."""
    left = 1 - discount

    def lemma(states: torch.Tensor, actions: torch.Tensor) -> torch.Tensor:
        return torch.einsum("s,sa,sa->", states, actions, advantage) / left

    expected = lemma(visits[1], policies[1])
    every = torch.ones_like(policies[1])
    mistakes = {
        "that is the surrogate: the lemma has the states of the new policy.": (
            lemma(visits[0], policies[1])
        ),
        "with the old policy's actions its own advantage averages to 0.": 0.0 * expected,
        "the factor 1 / (1 - gamma) is missing.": left * expected,
        "the factor is 1 / (1 - gamma): divide, do not multiply.": left**2 * expected,
        "the actions must be weighted by the new policy.": lemma(visits[1], every),
        "the states must be weighted by the new policy's visits.": (
            lemma(torch.ones_like(visits[1]), policies[1])
        ),
        "the sign is turned: new less old.": -expected,
        "that is a mean over the table; the visits and the policy are the weights already.": (
            expected / advantage.numel()
        ),
    }
    hint = "the numbers differ. New states, new actions, old advantage, over 1 - gamma."
    judge(value, expected, mistakes, hint)


@answered
def assumption_numbers(student: Student) -> None:
    """Check C1 and Delta: f(advantage, demo), both (task, state, action), -> (c1, delta)."""
    for seed, (shape, lifted) in enumerate(
        (((3, 4, 2), 0.0), ((2, 3, 3), 4.0), ((1, 5, 2), 0.0), ((4, 4, 4), -0.5)), start=11
    ):
        normal = draws(seed)
        advantage, demo = normal(*shape) + lifted, (2 * normal(*shape)).softmax(-1)
        if not lifted:
            advantage[-1, 2, 0] -= 4.0  # so that the largest |A| is negative
        got = as_parts(ask(student, advantage, demo).answer, 2, "two numbers, C1 and Delta")
        c1, delta = (as_tensor(part, (), "a single number") for part in got)
        _judge_assumption(c1, delta, advantage, demo)


def _judge_assumption(
    c1: torch.Tensor, delta: torch.Tensor, advantage: torch.Tensor, demo: torch.Tensor
) -> None:
    """Compare C1, then Delta; name the mistake that they equal."""
    gains = (demo * advantage).sum(-1)
    for_c1 = {
        "the two numbers are in the wrong order: C1 first, then Delta.": gains.min(),
        "C1 is the largest absolute value; a very bad action counts too.": advantage.max(),
        "C1 is the largest absolute value; a very good action counts too.": advantage.min().abs(),
        "C1 is an absolute value, so it has no sign.": -advantage.abs().max(),
        "C1 is the largest |A|, not the mean.": advantage.abs().mean(),
        "C1 is about the advantage itself, before it is averaged over actions.": gains.abs().max(),
    }
    for_delta = {
        "Delta must hold in every state of every task: not the mean, the minimum.": gains.mean(),
        "Delta is the largest number below all of them: the minimum.": gains.max(),
        "average over the demonstrator's actions before you take the minimum.": advantage.min(),
        "the demonstrator's probabilities are the weights already: sum over actions, no mean.": (
            (demo * advantage).mean(-1).min()
        ),
        "Delta may be negative: no absolute value there.": gains.abs().min(),
        "sum over the actions first, then take the minimum.": (demo * advantage).min(),
        "Delta weighs the advantages by the demonstrator.": advantage.sum(-1).min(),
    }
    hint = "C1 differs: the largest |A| over all tasks, states and actions."
    judge(c1, advantage.abs().max(), for_c1, hint)
    hint = "Delta differs: the minimum over tasks and states of sum_a dem(a|s) A(s, a)."
    judge(delta, gains.min(), for_delta, hint)

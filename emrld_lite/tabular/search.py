"""A search for task families that break a bound: gradient ascent on bound minus improvement."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from ..validation import check_choice, positive_count, real_number
from .families import Family
from .mdp import TabularMDP
from .theorem import MetaStep, as_dict, related_of, theorem_of

BOUNDS = (
    "bound",
    "bound_group_2",
    "bound_average_delta",
    "trust_region",
    "repaired",
    "substituted",
    "substituted_group_2",
)


@dataclass(frozen=True, eq=False)
class Found:
    """What a search came to, for a batch of families climbed from random starts."""

    family: Family
    """The families as they stand at the end, as a batch: mdps, task_weights, old, new, demo."""
    violation: Tensor
    """(1 - gamma) (bound - improvement) / C1 of each, (family,); above 0 the bound is broken."""


def hunt(
    bound: str,
    families: int = 64,
    states: int = 3,
    actions: int = 2,
    discount: float = 0.9,
    steps: int = 300,
    learning_rate: float = 0.1,
    seed: int = 0,
) -> Found:
    """Climb ``bound`` minus improvement over one-task families of a given size, by Adam.

    Transitions, rewards, start and all three policies move; the improvement, the bound and the
    visits are differentiated through the linear solves. ``bound`` is a field of Theorem1 or
    RelatedBounds. Raises InputError for what cannot be used.
    """
    check_choice("bound", bound, BOUNDS)
    real_number("discount", discount, minimum=0.0, maximum=1.0)
    for name, count in (("families", families), ("states", states), ("actions", actions)):
        positive_count(name, count)
    random = torch.Generator().manual_seed(seed)

    def start(*shape: int) -> Tensor:
        drawn = torch.randn(families, *shape, generator=random, dtype=torch.float64)
        return (1.5 * drawn).requires_grad_()

    free = {
        "transition": start(states, actions, states),
        "reward": start(states, actions),
        "initial": start(states),
        **{name: start(states, actions) for name in ("old", "new", "demo")},
    }
    climber = torch.optim.Adam(free.values(), lr=learning_rate, maximize=True)
    for _ in range(steps):
        climber.zero_grad()
        violation(bound, family_of(free, discount)).sum().backward()
        climber.step()
    found = family_of({name: value.detach() for name, value in free.items()}, discount)
    return Found(found, violation(bound, found))


def family_of(free: dict[str, Tensor], discount: float) -> Family:
    """Return the one-task families that free numbers stand for: softmax rows, rewards within 1."""
    mdp = TabularMDP(
        free["transition"].softmax(-1), free["reward"].tanh(), free["initial"].softmax(-1), discount
    )
    policies = [[free[name].softmax(-1)] for name in ("old", "new", "demo")]
    return [mdp], torch.ones(1), *policies


def violation(bound: str, family: Family) -> Tensor:
    """Return (1 - gamma) (bound - improvement) / C1 of each family."""
    step = MetaStep.of(*family)
    theorem = theorem_of(step)
    value = (as_dict(theorem) | as_dict(related_of(step)))[bound]
    scale = (1 - step.discount) / theorem.c1.clamp(min=1e-12)
    return scale * (value - theorem.improvement)

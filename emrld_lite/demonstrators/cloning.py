"""Behaviour cloning alone: one policy per task, fitted to one demonstration each, no reward anywhere."""

from __future__ import annotations

import torch

from ..demonstrations import Demonstrations
from ..losses import bc_loss
from ..policy import Params, detach, initialise, per_task
from ..validation import positive_count, real_number


def clone(
    demonstrations: Demonstrations, steps: int = 400, rate: float = 3e-3, seed: int = 0
) -> Params:
    """Return task_params that maximise each demonstration's likelihood, by Adam.

    All tasks are fitted at once and do not touch each other. Raises InputError for numbers that
    cannot be used.
    """
    positive_count("steps", steps)
    real_number("rate", rate, minimum=0.0)
    states, actions = demonstrations.states, demonstrations.actions
    start = initialise(states.shape[-1], actions.shape[-1], seed)
    task_params = per_task(start, len(demonstrations.tasks))
    leaves = {name: value.clone().requires_grad_() for name, value in task_params.items()}
    optimiser = torch.optim.Adam(leaves.values(), lr=rate, fused=True)  # faster, same formula
    for _ in range(steps):
        optimiser.zero_grad()
        bc_loss(leaves, demonstrations).sum().backward()
        optimiser.step()
    return detach(leaves)

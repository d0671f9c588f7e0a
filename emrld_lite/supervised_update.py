"""The meta-update of Meta-BC and GMPS: Adam on the demonstrations' likelihood after adaptation."""

from __future__ import annotations

from typing import NamedTuple

import torch

from .adapt import Adaptation, adapt, task_chunks
from .demonstrations import Demonstrations
from .losses import bc_loss, task_mean
from .policy import Params, detach, distribution, kl_divergence
from .rollout import Rollout, pack, take
from .trpo import Step


class Moments(NamedTuple):
    """What Adam remembers from one meta-iteration to the next (Kingma and Ba, 2015)."""

    step: int
    """Updates made so far."""
    mean: Params
    """Running mean of the gradient."""
    square: Params
    """Running mean of its square."""


def supervised_update(
    meta_params: Params,
    moments: Moments | None,
    before: Rollout,
    after: Rollout,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    learning_rate: float,
) -> tuple[Params, Moments | None, Step]:
    """Return theta_{k+1} after one Adam step on mean_i L^BC_i(theta_i), through the adaptation.

    Section 4.1, "Baselines": with cloning in the adaptation this is Meta-BC, with RL it is GMPS.
    ``after`` only measures: the record's KL is that between the old and the new adapted policies on
    its states, which nothing here bounds. A gradient that is not finite leaves everything as it is.
    """
    loss_gradient = cloning_gradient(meta_params, before, demonstrations, adaptation)
    if not all(torch.isfinite(part).all() for part in loss_gradient.values()):
        return meta_params, moments, Step(0.0, 0, "skipped: the gradient is not finite")
    stepped, remembered = adam_step(meta_params, loss_gradient, moments, learning_rate)
    if not all(torch.isfinite(value).all() for value in stepped.values()):
        return meta_params, moments, Step(0.0, 0, "skipped: Adam's step is not finite")
    kl = adapted_kl(meta_params, stepped, before, after, demonstrations, adaptation)
    return stepped, remembered, Step(kl, 0, "")


def cloning_gradient(
    meta_params: Params,
    before: Rollout,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
) -> Params:
    """Return the gradient of mean_i L^BC_i(theta_i) by the meta-policy, second-order terms included.

    Summed up a few tasks at a time, so memory does not grow with their number.
    """
    total = {name: torch.zeros_like(value) for name, value in meta_params.items()}
    tasks = len(before.rewards)
    for part in task_chunks(tasks, before.rewards[0].numel()):
        leaves = detach(meta_params, requires_grad=True)
        data = demonstrations.take(part)
        task_params = adapt(leaves, pack(take(before, part)), data, adaptation, keep_graph=True)
        loss = bc_loss(task_params, data, adaptation.bc_reduction).sum() / tasks
        gradients = torch.autograd.grad(loss, list(leaves.values()))
        total = {
            name: value + gradient
            for (name, value), gradient in zip(total.items(), gradients, strict=True)
        }
    return total


def adam_step(
    params: Params, gradient: Params, moments: Moments | None, learning_rate: float
) -> tuple[Params, Moments]:
    """Return the parameters after one step of torch's Adam, and its moments for the next one."""
    leaves = {name: value.detach().clone().requires_grad_() for name, value in params.items()}
    optimiser = torch.optim.Adam(leaves.values(), lr=learning_rate)
    for name, leaf in leaves.items():
        leaf.grad = gradient[name]
        if moments is not None:
            optimiser.state[leaf] = {
                "step": torch.tensor(float(moments.step)),
                "exp_avg": moments.mean[name].clone(),
                "exp_avg_sq": moments.square[name].clone(),
            }
    optimiser.step()
    states = {name: optimiser.state[leaf] for name, leaf in leaves.items()}
    return detach(leaves), Moments(
        step=1 if moments is None else moments.step + 1,
        mean={name: state["exp_avg"] for name, state in states.items()},
        square={name: state["exp_avg_sq"] for name, state in states.items()},
    )


@torch.no_grad()
def adapted_kl(
    old: Params,
    new: Params,
    before: Rollout,
    after: Rollout,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
) -> float:
    """Return the mean KL from the policies adapted from ``old`` to those from ``new``, nats."""
    total = 0.0
    for part in task_chunks(len(before.rewards), before.rewards[0].numel()):
        data = (pack(take(before, part)), demonstrations.take(part), adaptation)
        seen = pack(take(after, part))
        policies = [distribution(adapt(params, *data), seen.states) for params in (old, new)]
        total += float(task_mean(kl_divergence(*policies), seen.mask).sum())
    return total / len(before.rewards)

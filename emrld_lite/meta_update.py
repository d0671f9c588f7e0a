"""The meta-update, equation (meta-update-emrld): TRPO on D^val, differentiated through the adaptation."""

from __future__ import annotations

from typing import NamedTuple

import torch

from .adapt import Adaptation, adapt, task_chunks
from .demonstrations import Demonstrations
from .losses import surrogate_loss, task_mean
from .policy import Gaussian, Params, detach, distribution, kl_divergence
from .rollout import Rollout, pack, subsample, take
from .timing import section
from .trpo import Step, TrustRegion, trpo_step


class TaskData(NamedTuple):
    """D^tr, D^val and D^dem of a few tasks, the steps packed."""

    before: Rollout
    after: Rollout
    demonstrations: Demonstrations


class SurrogateGradient(NamedTuple):
    """Surrogate summed over tasks, its gradient (parameter,), and the policies it was taken at."""

    surrogate: float
    gradient: torch.Tensor
    old: Gaussian


def meta_update(
    meta_params: Params,
    before: Rollout,
    after: Rollout,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    region: TrustRegion,
    random: torch.Generator,
) -> tuple[Params, Step]:
    """Return theta_{k+1}, equation (meta-update-emrld): TRPO on D^val, through the adaptation.

    The meta-loss is a mean over tasks, so it is summed up a few tasks at a time: memory then does
    not grow with the number of tasks.
    """
    tasks = len(before.rewards)
    chunks = [
        TaskData(pack(take(before, part)), pack(take(after, part)), demonstrations.take(part))
        for part in task_chunks(tasks)
    ]
    with section("adaptation and gradient"):
        pieces = [surrogate_and_gradient(meta_params, chunk, adaptation) for chunk in chunks]
        surrogate = sum(piece.surrogate for piece in pieces) / tasks
        gradient = torch.stack([piece.gradient for piece in pieces]).sum(0) / tasks
    olds = [piece.old for piece in pieces]

    def surrogate_and_kl(params: Params) -> tuple[float, float]:
        totals = [
            chunk_surrogate_and_kl(params, chunk, old, adaptation)
            for chunk, old in zip(chunks, olds, strict=True)
        ]
        return tuple(sum(values) / tasks for values in zip(*totals, strict=True))

    sampled_before = subsample(before, region.fisher_samples, random)
    sampled_after = subsample(after, region.fisher_samples, random)

    def fisher(params: Params) -> tuple[Gaussian, torch.Tensor]:
        task_params = adapt(params, sampled_before, demonstrations, adaptation, keep_graph=True)
        weight = sampled_after.mask / sampled_after.mask.sum()
        return distribution(task_params, sampled_after.states), weight

    return trpo_step(meta_params, surrogate, gradient, fisher, surrogate_and_kl, region)


def surrogate_and_gradient(
    meta_params: Params, data: TaskData, adaptation: Adaptation
) -> SurrogateGradient:
    """Return TRPO's surrogate at the old policy and its second-order gradient by the meta-policy."""
    leaves = detach(meta_params, requires_grad=True)
    task_params = adapt(leaves, data.before, data.demonstrations, adaptation, keep_graph=True)
    new = distribution(task_params, data.after.states)
    old = Gaussian(*(output.detach() for output in new))
    surrogate = surrogate_loss(new, old, data.after).sum()
    parts = torch.autograd.grad(surrogate, list(leaves.values()))
    gradient = torch.cat([part.reshape(-1) for part in parts])
    return SurrogateGradient(float(surrogate.detach()), gradient, old)


def chunk_surrogate_and_kl(
    params: Params, data: TaskData, old: Gaussian, adaptation: Adaptation
) -> tuple[float, float]:
    """Return the exact surrogate and KL of a trial meta-policy, summed over tasks."""
    task_params = adapt(params, data.before, data.demonstrations, adaptation)
    new = distribution(task_params, data.after.states)
    kl = task_mean(kl_divergence(old, new), data.after.mask).sum()
    return float(surrogate_loss(new, old, data.after).sum()), float(kl)

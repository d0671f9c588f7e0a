"""The meta-update: TRPO on D^val or Adam on D^dem, each differentiated through the adaptation."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from typing import NamedTuple

import torch

from .adapt import Adaptation, adapt, cloning_loss, task_slices
from .demonstrations import Demonstrations
from .losses import task_mean
from .policy import (
    Gaussian,
    Params,
    Vector,
    detach,
    distribution,
    kl_divergence,
    own_memory,
    to_vector,
)
from .rollout import Rollout, pack, subsample
from .trpo import (
    Product,
    Step,
    TrustRegion,
    fisher_product,
    surrogate_and_kl,
    surrogate_gradient,
    trpo_step,
)


class TaskData(NamedTuple):
    """What a meta-update learns from: D^tr and D^val with their advantages, and D^dem."""

    before: Rollout
    after: Rollout
    demonstrations: Demonstrations


def chunks(data: TaskData) -> list[TaskData]:
    """Return the data of a few tasks at a time, their steps packed.

    Meta-losses are means over tasks, so they can be summed up chunk by chunk: the memory of the
    work then does not grow with the number of tasks, only that of their episodes and samples.
    """
    before, after, demonstrations = data
    return [
        TaskData(pack(before.take(part)), pack(after.take(part)), demonstrations.take(part))
        for part in task_slices(len(before.rewards))
    ]


def policies_after(
    theta: Params, data: TaskData, rule: Adaptation, keep_graph: bool = False
) -> Gaussian:
    """Return pi_{theta_i}(. | s) at the states of D^val, where theta_i is theta adapted on D^tr and D^dem."""
    task_params = adapt(theta, data.before, data.demonstrations, rule, keep_graph)
    return distribution(task_params, data.after.states)


class Learner(ABC):
    """What changes the meta-policy; a column of the comparison's table says which one."""

    @abstractmethod
    def update(
        self, theta: Params, data: TaskData, rule: Adaptation, random: torch.Generator
    ) -> tuple[Params, Step]:
        """Return theta_{k+1} and what the step did; a step that is not finite leaves theta as it is."""

    def state(self) -> Params:
        """Return what the learner remembers, for a checkpoint: by default nothing."""
        return {}

    def load(self, state: Params) -> None:  # noqa: B027  (nothing to do is a fair answer)
        """Go on from the memory of a checkpoint; an empty one is a fresh start."""


class Trpo(Learner):
    """TRPO on D^val, equation (meta-update-emrld), through the adaptation.

    The step goes along a running mean of the iterations' gradients, m_k = mu m_{k-1} + (1 - mu) g_k
    from m_0 = g_0 on: with mu = 0.5 a third of the variance of one iteration's. With mu = 0, the
    paper's step, nothing is remembered.
    """

    def __init__(self, theta: Params, region: TrustRegion, momentum: float = 0.0) -> None:
        self.region, self.momentum = region, momentum
        self.mean_gradient = torch.zeros_like(to_vector(theta))  # zero: no gradient yet

    def update(
        self, theta: Params, data: TaskData, rule: Adaptation, random: torch.Generator
    ) -> tuple[Params, Step]:
        """Return theta_{k+1}: one step that lowers the surrogate on D^val within the KL bound."""
        region = self.region.for_actions(data.after.actions.shape[-1])
        parts, tasks = chunks(data), len(data.after.rewards)
        pieces = [
            surrogate_gradient(
                theta,
                lambda leaves, part=part: policies_after(leaves, part, rule, True),
                part.after,
            )
            for part in parts
        ]
        surrogate = sum(piece.surrogate for piece in pieces) / tasks
        gradient = torch.stack([piece.gradient for piece in pieces]).sum(0) / tasks

        def exact(trial: Params) -> tuple[float, float]:
            totals = [
                surrogate_and_kl(policies_after(trial, part, rule), piece.old, part.after)
                for part, piece in zip(parts, pieces, strict=True)
            ]
            return tuple(sum(values) / tasks for values in zip(*totals, strict=True))

        product = self.fisher(theta, data, rule, random)
        smooth = self.smoothed(gradient)
        theta, step = trpo_step(theta, surrogate, smooth, product, exact, region)
        return own_memory(theta), step

    def smoothed(self, gradient: Vector) -> Vector:
        """Return the running mean with ``gradient`` in it; one that is zero or no number stays out."""
        if not self.momentum or not torch.isfinite(gradient).all() or not gradient.any():
            return gradient
        if self.mean_gradient.any():
            gradient = self.momentum * self.mean_gradient + (1.0 - self.momentum) * gradient
        self.mean_gradient = gradient
        return gradient

    def fisher(
        self, theta: Params, data: TaskData, rule: Adaptation, random: torch.Generator
    ) -> Product:
        """Return the product with the adapted policies' Fisher matrix, on a sample of the steps."""
        before, after = (
            subsample(rollout, self.region.fisher_samples, random)
            for rollout in (data.before, data.after)
        )
        leaves = detach(theta, requires_grad=True)
        sample = TaskData(before, after, data.demonstrations)
        adapted = policies_after(leaves, sample, rule, keep_graph=True)
        return fisher_product(adapted, after.mask / after.mask.sum(), leaves, self.region.damping)

    def state(self) -> Params:
        """Return the running mean, for a checkpoint; without momentum there is none."""
        return {"trpo.mean_gradient": self.mean_gradient.clone()} if self.momentum else {}

    def load(self, state: Params) -> None:
        """Go on from the memory of a checkpoint; an empty one is a fresh start."""
        kept = state.get("trpo.mean_gradient", torch.zeros_like(self.mean_gradient))
        self.mean_gradient = kept.to(self.mean_gradient.device, copy=True)


LARGE_KL = 10.0  # nats; TRPO's steps stay under 0.06
UNBOUNDED = "nothing bounds Adam's step"  # ends the note of a step that was made all the same


class Adam(Learner):
    """torch's Adam on mean_i L^BC_i(theta_i), the demonstrations' likelihood after adaptation.

    Section 4.1, "Baselines": with cloning in the adaptation this is Meta-BC, with RL it is GMPS.
    """

    def __init__(self, theta: Params, learning_rate: float) -> None:
        self.leaves = detach(own_memory(theta), requires_grad=True)
        self.optimiser = torch.optim.Adam(self.leaves.values(), lr=learning_rate)
        self.load({})

    def update(
        self, theta: Params, data: TaskData, rule: Adaptation, random: torch.Generator
    ) -> tuple[Params, Step]:
        """Return theta_{k+1} after one step of Adam.

        D^val only measures: the KL is that between the old and the new adapted policies on its
        states, which nothing here bounds; the note says where it is large. A step after which the
        policy or Adam's memory is not finite is not made.
        """
        parts = chunks(data)
        gradient = cloning_gradient(theta, parts, rule)
        if not all(torch.isfinite(part).all() for part in gradient.values()):
            return theta, Step(0.0, 0, "skipped: the gradient is not finite")
        kept = copy.deepcopy(self.optimiser.state_dict())
        for name, leaf in self.leaves.items():
            leaf.data.copy_(theta[name])
            leaf.grad = gradient[name]
        self.optimiser.step()
        stepped = detach(own_memory(self.leaves))
        for what, made in (("step", stepped), ("memory", self.state())):
            if not all(torch.isfinite(value).all() for value in made.values()):
                self.optimiser.load_state_dict(kept)
                return theta, Step(0.0, 0, f"skipped: Adam's {what} is not finite")
        kl = adapted_kl(theta, stepped, parts, rule)
        note = "" if kl <= LARGE_KL else f"KL of {kl:.2g} nats: {UNBOUNDED}"
        return stepped, Step(kl, 0, note)

    def state(self) -> Params:
        """Return Adam's number of steps and running means, under names that no parameter has."""
        return {
            f"adam.{key}.{name}": value.clone()
            for name, leaf in self.leaves.items()
            for key, value in self.optimiser.state[leaf].items()
        }

    def load(self, state: Params) -> None:
        """Go on from the memory of a checkpoint; an empty one is a fresh start."""
        for name, leaf in self.leaves.items():
            zero = torch.zeros_like(leaf.detach())
            fresh = {"step": torch.tensor(0.0), "exp_avg": zero, "exp_avg_sq": zero}
            self.optimiser.state[leaf] = {
                key: state.get(f"adam.{key}.{name}", value).to(value.device, copy=True)
                for key, value in fresh.items()
            }


def cloning_gradient(theta: Params, parts: list[TaskData], rule: Adaptation) -> Params:
    """Return the gradient of mean_i L^BC_i(theta_i) by the meta-policy, through the adaptation."""
    total = {name: torch.zeros_like(value) for name, value in theta.items()}
    tasks = sum(len(part.demonstrations.tasks) for part in parts)
    for before, _, demonstrations in parts:
        leaves = detach(theta, requires_grad=True)
        task_params = adapt(leaves, before, demonstrations, rule, keep_graph=True)
        loss = cloning_loss(task_params, demonstrations, rule).sum() / tasks
        gradients = torch.autograd.grad(loss, list(leaves.values()))
        total = {
            name: value + gradient
            for (name, value), gradient in zip(total.items(), gradients, strict=True)
        }
    return total


@torch.no_grad()
def adapted_kl(old: Params, new: Params, parts: list[TaskData], rule: Adaptation) -> float:
    """Return the mean KL from the policies adapted from ``old`` to those from ``new``, nats."""
    total, tasks = 0.0, 0
    for part in parts:
        policies = [policies_after(params, part, rule) for params in (old, new)]
        kl = task_mean(kl_divergence(*policies), part.after.mask)
        total, tasks = total + float(kl.sum()), tasks + len(kl)
    return total / tasks

"""The meta-update by TRPO: RL's surrogate on D^val (the paper's), the demonstrations' likelihood, or both."""

from __future__ import annotations

from typing import NamedTuple

import torch

from ..adapt import Adaptation, adapt, cloning_loss
from ..losses import task_mean
from ..policy import Gaussian, Params, Vector, detach, kl_divergence, own_memory, to_vector
from ..rollout import subsample
from ..trpo import (
    Product,
    Step,
    TrustRegion,
    fisher_product,
    surrogate_and_kl,
    surrogate_gradient,
    trpo_step,
)
from .base import Learner, TaskData, chunks, cloning_gradient, policies_after


class Objective(NamedTuple):
    """What a step is to lower: its mean over tasks, its gradient, and the policies it was taken at."""

    value: float
    gradient: Vector
    old: list[Gaussian]


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
        objective, gradient, old = self.objective(theta, parts, rule)

        def exact(trial: Params) -> tuple[float, float]:
            totals = [
                self.objective_and_kl(trial, part, policies, rule)
                for part, policies in zip(parts, old, strict=True)
            ]
            return tuple(sum(values) / tasks for values in zip(*totals, strict=True))

        product = self.fisher(theta, data, rule, random)
        smooth = self.smoothed(gradient)
        theta, step = trpo_step(theta, objective, smooth, product, exact, region)
        return own_memory(theta), step

    def objective(self, theta: Params, parts: list[TaskData], rule: Adaptation) -> Objective:
        """Return the mean surrogate on D^val at ``theta``, its gradient, and the adapted policies."""
        pieces = [
            surrogate_gradient(
                theta,
                lambda leaves, part=part: policies_after(leaves, part, rule, True),
                part.after,
            )
            for part in parts
        ]
        tasks = sum(len(part.after.rewards) for part in parts)
        surrogate = sum(piece.surrogate for piece in pieces) / tasks
        gradient = torch.stack([piece.gradient for piece in pieces]).sum(0) / tasks
        return Objective(surrogate, gradient, [piece.old for piece in pieces])

    def objective_and_kl(
        self, trial: Params, part: TaskData, old: Gaussian, rule: Adaptation
    ) -> tuple[float, float]:
        """Return the exact surrogate and KL of a trial on a few tasks, each summed over them."""
        return surrogate_and_kl(policies_after(trial, part, rule), old, part.after)

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


class CloningTrpo(Trpo):
    """The demonstrations' likelihood after adaptation, as in Meta-BC, but by TRPO's step, not by Adam.

    No row of the comparison: a switch that tells what of Meta-BC's outcome is its loss, and what its
    optimiser. The KL is measured, as TRPO does, on the states of D^val, whose rewards are not read.
    """

    def objective(self, theta: Params, parts: list[TaskData], rule: Adaptation) -> Objective:
        """Return the mean cloning loss after adaptation, its gradient, and the adapted policies."""
        gradient = to_vector(cloning_gradient(theta, parts, rule))
        with torch.no_grad():
            old = [policies_after(theta, part, rule) for part in parts]
        tasks = sum(len(part.after.rewards) for part in parts)
        losses = sum(self.loss(theta, part, rule) for part in parts)
        return Objective(losses / tasks, gradient, old)

    def objective_and_kl(
        self, trial: Params, part: TaskData, old: Gaussian, rule: Adaptation
    ) -> tuple[float, float]:
        """Return the exact cloning loss and KL of a trial on a few tasks, each summed over them."""
        new = policies_after(trial, part, rule)
        kl = task_mean(kl_divergence(old, new), part.after.mask).sum()
        return self.loss(trial, part, rule), float(kl)

    def loss(self, theta: Params, part: TaskData, rule: Adaptation) -> float:
        """Return the cloning loss after adaptation, summed over a few tasks."""
        task_params = detach(adapt(theta, part.before, part.demonstrations, rule))
        return float(cloning_loss(task_params, part.demonstrations, rule).sum())


class RlAndCloningTrpo(CloningTrpo):
    """The surrogate on D^val plus ``weight`` times the cloning loss after adaptation, by one step of TRPO.

    Section 3 tried "the double use of the demonstration data [...] by adding an additional gradient
    through a BC loss function", and names no weight.
    """

    def __init__(
        self, theta: Params, region: TrustRegion, momentum: float = 0.0, weight: float = 1.0
    ) -> None:
        super().__init__(theta, region, momentum)
        self.weight = weight

    def objective(self, theta: Params, parts: list[TaskData], rule: Adaptation) -> Objective:
        """Return the weighted sum of both means, its gradient, and the adapted policies."""
        rl = Trpo.objective(self, theta, parts, rule)
        cloning = super().objective(theta, parts, rule)
        value = rl.value + self.weight * cloning.value
        return Objective(value, rl.gradient + self.weight * cloning.gradient, rl.old)

    def objective_and_kl(
        self, trial: Params, part: TaskData, old: Gaussian, rule: Adaptation
    ) -> tuple[float, float]:
        """Return the exact weighted sum of both losses, and the KL, of a trial, each summed over tasks."""
        surrogate, kl = Trpo.objective_and_kl(self, trial, part, old, rule)
        return surrogate + self.weight * self.loss(trial, part, rule), kl

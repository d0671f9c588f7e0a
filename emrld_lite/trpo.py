"""TRPO's step (Schulman et al., 2015): surrogate, Fisher product, conjugate gradient, line search.

The meta-learner and the expert share it; they differ in which policies a set of parameters stands for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from .losses import surrogate_loss, task_mean
from .policy import Gaussian, Params, Vector, detach, from_vector, kl_divergence, to_vector
from .rollout import Rollout
from .validation import positive_count, real_number

KL_OF_DIMENSION = 0.01  # nats; the released code's bound is on the mean over dimensions
Product = Callable[[Vector], Vector]


@dataclass(frozen=True)
class TrustRegion:
    """How far and how carefully one step goes; raises InputError for a number that cannot be used."""

    max_kl: float | None = None
    """Bound on the mean KL divergence from the old to the new policy, nats (joint action); by default
    0.01 per dimension of the action, as in the released code."""
    cg_iterations: int = 10
    """Conjugate-gradient iterations at most."""
    damping: float = 0.3
    """Multiple of the identity added to the Fisher matrix, against the noise of its samples."""
    backtracks: int = 15
    """Halvings of the step before it is given up."""
    fisher_samples: int = 100
    """Steps per task, drawn at random, on which the Fisher product is evaluated."""
    aliased_cg: bool = False
    """Whether residual and first direction share memory, the released code's slip."""

    def __post_init__(self) -> None:
        if self.max_kl is not None:
            real_number("max_kl", self.max_kl, minimum=1e-12)
        real_number("damping", self.damping, minimum=0.0)
        positive_count("cg_iterations", self.cg_iterations)
        positive_count("backtracks", self.backtracks)
        positive_count("fisher_samples", self.fisher_samples)

    def for_actions(self, action_dim: int) -> TrustRegion:
        """Return the same region with the bound for actions of ``action_dim`` dimensions filled in."""
        bound = KL_OF_DIMENSION * action_dim if self.max_kl is None else self.max_kl
        return replace(self, max_kl=bound)


class Step(NamedTuple):
    """What one update did: the KL between old and new policies, halvings before it, why if none."""

    kl: float
    backtracks: int
    note: str


class SurrogateGradient(NamedTuple):
    """Surrogate summed over tasks, its gradient, and the policies it was taken at."""

    surrogate: float
    gradient: Vector
    old: Gaussian


def surrogate_gradient(
    params: Params, policies: Callable[[Params], Gaussian], rollout: Rollout
) -> SurrogateGradient:
    """Return TRPO's surrogate at the old policies, and its gradient by ``params``.

    ``policies`` gives the distributions that parameters stand for at the states of ``rollout``, in
    the autograd graph.
    """
    leaves = detach(params, requires_grad=True)
    new = policies(leaves)
    old = Gaussian(*(output.detach() for output in new))
    surrogate = surrogate_loss(new, old, rollout).sum()
    parts = torch.autograd.grad(surrogate, list(leaves.values()))
    gradient = torch.cat([part.reshape(-1) for part in parts])
    return SurrogateGradient(float(surrogate.detach()), gradient, old)


def surrogate_and_kl(new: Gaussian, old: Gaussian, rollout: Rollout) -> tuple[float, float]:
    """Return the exact surrogate and KL of new policies, each summed over tasks."""
    kl = task_mean(kl_divergence(old, new), rollout.mask).sum()
    return float(surrogate_loss(new, old, rollout).sum()), float(kl)


def conjugate_gradient(
    product: Product,
    target: Vector,
    iterations: int,
    tolerance: float = 1e-10,
    aliased: bool = False,
) -> Vector:
    """Return x with product(x) = target for a symmetric positive definite product.

    Stops after ``iterations`` or when the squared residual has shrunk by ``tolerance``. A zero
    target gives zero. ``target`` is left as it was. ``aliased`` is the released code's slip, a
    switch to measure what it costs: residual and first direction share memory, so the first update
    of the one changes the other, and the directions are never conjugate after it.
    """
    solution, residual = torch.zeros_like(target), target.clone()
    direction = residual if aliased else residual.clone()
    squared = residual @ residual
    goal = tolerance * squared
    for _ in range(iterations):
        if squared <= goal:
            break
        image = product(direction)
        length = squared / (direction @ image)
        solution += length * direction
        residual -= length * image
        previous, squared = squared, residual @ residual
        direction = residual + (squared / previous) * direction
    return solution


def fisher_product(
    gaussian: Gaussian, weight: Float[Tensor, ...], params: Params, damping: float = 0.0
) -> Product:
    """Return v -> (F + damping I) v, the Hessian of the mean KL at the old policy.

    ``gaussian`` must hang on ``params`` in the autograd graph; ``weight`` says how much each state
    counts and sums to 1. F = J^T M J, where J is the Jacobian of mean and
    log sigma with respect to ``params`` and M the Fisher matrix of a Gaussian: 1/sigma^2 for the
    mean, 2 for log sigma. J v comes from differentiating J^T u, which is linear in u, twice.
    """
    leaves = list(params.values())
    precision = torch.exp(-2.0 * gaussian.log_sigma.detach())
    metrics = (weight[..., None] * precision, weight[..., None] * torch.full_like(precision, 2.0))
    pairs = zip(gaussian, metrics, strict=True)
    learned = [(output, metric) for output, metric in pairs if output.requires_grad]
    outputs, metrics = zip(*learned, strict=True)  # without log sigma when it is fixed
    probes = tuple(torch.zeros_like(output, requires_grad=True) for output in outputs)
    transposed = torch.autograd.grad(outputs, leaves, grad_outputs=probes, create_graph=True)

    def product(vector: Vector) -> Vector:
        direction = list(from_vector(vector, params).values())
        changes = torch.autograd.grad(
            transposed, probes, grad_outputs=direction, retain_graph=True
        )  # J v
        weighted = tuple(part * change for part, change in zip(metrics, changes, strict=True))
        image = torch.autograd.grad(outputs, leaves, grad_outputs=weighted, retain_graph=True)
        return torch.cat([part.reshape(-1) for part in image]) + damping * vector

    return product


def trpo_step(
    params: Params,
    surrogate: float,
    gradient: Vector,
    product: Product,
    surrogate_and_kl: Callable[[Params], tuple[float, float]],
    region: TrustRegion,
) -> tuple[Params, Step]:
    """Return the policy after one step that lowers the surrogate within the KL bound, and its record.

    ``surrogate`` and ``gradient`` are the surrogate's at ``params``, ``product`` is the Fisher
    matrix's there, ``surrogate_and_kl(params)`` gives the exact surrogate and KL on all data, and
    ``region`` must say its ``max_kl``. A gradient or a step that is zero or not finite leaves
    ``params`` as they are, and the record's note says so.
    """
    if not torch.isfinite(gradient).all():
        return params, Step(0.0, 0, "skipped: the gradient is not finite")
    if not gradient.any():
        return params, Step(0.0, 0, "no step: the gradient is zero (nothing rewarded yet)")
    descent = -conjugate_gradient(
        product, gradient, region.cg_iterations, aliased=region.aliased_cg
    )
    curvature = float(descent @ product(descent))
    if not math.isfinite(curvature) or curvature <= 0.0:
        return params, Step(0.0, 0, f"skipped: the curvature along the step is {curvature:.2g}")
    full_step = descent * math.sqrt(2.0 * region.max_kl / curvature)
    return line_search(params, surrogate, full_step, surrogate_and_kl, region)


@torch.no_grad()
def line_search(
    params: Params,
    before: float,
    full_step: Vector,
    surrogate_and_kl: Callable[[Params], tuple[float, float]],
    region: TrustRegion,
) -> tuple[Params, Step]:
    """Halve ``full_step`` until the surrogate is under ``before`` and the KL in bounds."""
    start = to_vector(params)
    for halvings in range(region.backtracks):
        trial = from_vector(start + 0.5**halvings * full_step, params)
        surrogate, kl = surrogate_and_kl(trial)  # on all data
        if math.isfinite(surrogate) and surrogate < before and kl <= region.max_kl:
            return trial, Step(kl, halvings, "")
    return params, Step(0.0, region.backtracks, "no step: the line search found no improvement")

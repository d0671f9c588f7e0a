"""A conjugate gradient with a planted fault, for an exercise: meet its symptoms before you read it."""

from __future__ import annotations

import torch

from ..policy import Vector
from ..trpo import Product


def suspect_solver(product: Product, target: Vector, iterations: int) -> Vector:
    """Return x, which ought to solve product(x) = target."""
    solution, residual = torch.zeros_like(target), target.clone()
    direction = residual
    squared = residual @ residual
    for _ in range(iterations):
        image = product(direction)
        length = squared / (direction @ image)
        solution += length * direction
        residual -= length * image
        previous, squared = squared, residual @ residual
        direction = residual + squared / previous * direction
    return solution

"""Checks of notebook 05, the trust region: the repaired conjugate gradient, and the full step."""

from __future__ import annotations

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_tensor, close, draws, judge

Vector = torch.Tensor


def _system(size: int, condition: float, seed: int = 52) -> tuple[torch.Tensor, Vector]:
    """Return a random symmetric matrix of that condition number, and a right-hand side."""
    normal = draws(seed)
    basis = torch.linalg.qr(normal(size, size))[0]
    eigenvalues = torch.logspace(0, -torch.log10(torch.tensor(condition)).item(), size)
    return basis @ torch.diag(eigenvalues.double()) @ basis.T, normal(size)


def _krylov(matrix: torch.Tensor, target: Vector, iterations: int) -> Vector:
    """Return CG's x: it minimises 1/2 x.Ax - b.x over the directions b, Ab, A^2 b and so on."""
    directions = [target / target.norm()]
    for _ in range(iterations - 1):
        new = matrix @ directions[-1]
        for old in directions * 2:  # twice: once leaves rounding behind
            new = new - (new @ old) * old
        directions.append(new / new.norm())
    reduced = torch.stack(directions[:iterations], 1)
    return reduced @ torch.linalg.solve(reduced.T @ matrix @ reduced, reduced.T @ target)


@answered
def conjugate_gradient(student: Student) -> None:
    """Check CG: f(product, target, iterations) -> x with product(x) = target."""
    _cg_first_step(student)
    for seed, size, iterations in ((52, 12, 3), (53, 9, 2), (54, 12, 5), (55, 10, 8)):
        matrix, target = _system(size, 1e4, seed)
        _cg_steps(student, matrix, 0.02 * target, iterations)  # small: no early end is right
    zero = torch.zeros(7, dtype=torch.float64)
    try:
        answer = as_tensor(ask(student, lambda v: 2 * v, zero, 5).answer, (7,), "x")
    except ZeroDivisionError:
        answer = zero + torch.nan
    except Wrong as wrong:
        if "not finite" not in str(wrong):
            raise
        answer = zero + torch.nan
    if not bool((answer == 0).all()):
        raise Wrong("a target of zero gave no zeros: 0 / 0. Stop when the residual is zero.")
    matrix, target = _system(6, 10.0, 56)
    value = as_tensor(ask(student, lambda v: matrix @ v, target, 60).answer, (6,), "x")
    if not close(value, torch.linalg.solve(matrix, target), 1e-6):
        raise Wrong("with more iterations than unknowns the answer is not exact to six digits.")


def _cg_first_step(student: Student) -> None:
    """Look at one iteration alone, which needs no conjugate direction yet."""
    matrix, target = _system(12, 1e4)
    value = as_tensor(ask(student, lambda v: matrix @ v, target, 1).answer, (12,), "x")
    along = target @ target / (target @ matrix @ target)
    mistakes = {
        "that is one iteration too many: `iterations` counts the steps taken.": (
            _krylov(matrix, target, 2)
        ),
        "that is one iteration too few: the first one already takes a step.": 0 * target,
        "the first step points backwards.": -along * target,
        "the first step's length is upside down: b.b / b.Ab.": target / along,
        "that is the direction, not yet the solution: a step's length is missing.": target,
    }
    judge(
        value,
        along * target,
        mistakes,
        "the first step is off: along the target b, as far as b.b / b.Ab, starting from zero.",
    )


def _cg_steps(student: Student, matrix: torch.Tensor, target: Vector, iterations: int) -> None:
    """Compare several iterations, and count the products that they took."""
    asked: list[Vector] = []

    def product(vector: Vector) -> Vector:
        asked.append(vector.detach().clone())
        return matrix @ vector

    size = len(target)
    got = ask(student, product, target, iterations).answer
    value = as_tensor(got, (size,), "one number for each unknown")
    if len(asked) > iterations + 1:
        raise Wrong(f"{iterations} iterations need {iterations} products; yours took {len(asked)}.")
    early = [0 * target, *(_krylov(matrix, target, k) for k in range(1, iterations - 1))]
    if any(close(value / target.norm(), short / target.norm()) for short in early):
        raise Wrong(
            "you stop too early: only a residual of zero ends the loop before the last iteration."
        )
    exact = _krylov(matrix, target, iterations)
    mistakes = {
        "that is one iteration too many: `iterations` counts the steps taken.": (
            _krylov(matrix, target, iterations + 1)
        ),
        "that is one iteration too few.": _krylov(matrix, target, iterations - 1),
        "the residual grows: each step takes its image away, residual - length * product.": (
            _with_turned_residual(matrix, target, iterations)
        ),
        "the first direction is lost, as in the solver that you were to mend: your second one is a "
        "multiple of the residual. Which two names stand for one tensor there?": (
            _with_lost_direction(matrix, target, iterations)
        ),
    }
    judge(
        value,
        exact,
        mistakes,
        "the directions are not conjugate. The new one is residual + (new r.r / old r.r) * "
        "direction, with the residual that is already updated, in every iteration.",
    )


def _with_turned_residual(matrix: torch.Tensor, target: Vector, iterations: int) -> Vector:
    """Return what comes out when the residual is updated with the wrong sign."""
    solution, residual, direction = torch.zeros_like(target), target, target
    for _ in range(iterations):
        image = matrix @ direction
        length = residual @ residual / (direction @ image)
        solution, new = solution + length * direction, residual + length * image
        direction = new + (new @ new) / (residual @ residual) * direction
        residual = new
    return solution


def _with_lost_direction(matrix: torch.Tensor, target: Vector, iterations: int) -> Vector:
    """Return what comes out when the new residual stands where the first direction should be."""
    length = target @ target / (target @ matrix @ target)
    solution, residual = length * target, target - length * (matrix @ target)
    direction = residual + (residual @ residual) / (target @ target) * residual
    for _ in range(iterations - 1):
        image = matrix @ direction
        length = residual @ residual / (direction @ image)
        solution, new = solution + length * direction, residual - length * image
        direction = new + (new @ new) / (residual @ residual) * direction
        residual = new
    return solution


@answered
def full_step(student: Student) -> None:
    """Check the step length: f(direction, product, max_kl) -> the scaled direction."""
    for seed, size, max_kl in ((52, 5, 0.02), (57, 7, 0.3), (58, 3, 0.005)):
        matrix, direction = _system(size, 10.0, seed)
        direction = 3 * direction
        got = ask(student, direction, lambda v, m=matrix: m @ v, max_kl).answer
        value = as_tensor(got, (size,), "a step, one number for each parameter")
        _judge_full_step(value, direction, matrix, max_kl)


def _judge_full_step(value: Vector, direction: Vector, matrix: torch.Tensor, max_kl: float) -> None:
    """Compare the full step; name the mistake that it equals."""
    curvature = direction @ matrix @ direction
    scale = (2 * max_kl / curvature).sqrt()
    mistakes = {
        "the step points backwards: keep the direction, only its length changes.": (
            -scale * direction
        ),
        "the KL is *half* the quadratic form, so there is a factor of 2 under the root.": (
            (max_kl / curvature).sqrt() * direction
        ),
        "the factor of 2 is upside down: s^2 is 2 max_kl over x.Fx.": (
            (max_kl / (2 * curvature)).sqrt() * direction
        ),
        "the root is missing: the KL grows with the square of the length.": (
            2 * max_kl / curvature * direction
        ),
        "the fraction is upside down: the more x.Fx, the shorter the step.": direction / scale,
        "only a part of the fraction is under the root.": (
            (2 * max_kl) ** 0.5 / curvature * direction
        ),
        "that is a length in parameters; the KL measures it with F: use the product.": (
            (2 * max_kl) ** 0.5 * direction / direction.norm()
        ),
        "s is a number for the direction itself, not for its product with F.": (
            scale * (matrix @ direction)
        ),
    }
    hint = "the numbers differ. Solve 1/2 s^2 x.Fx = max_kl for s, and return s x."
    judge(value / scale, direction, {s: v / scale for s, v in mistakes.items()}, hint)

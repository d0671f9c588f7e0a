"""Checks of notebook 05: MAML."""

from __future__ import annotations

from collections.abc import Callable

import torch

from .answers import Student, Wrong, answered, as_tensor, close, draws

Steps = tuple[torch.Tensor, torch.Tensor, torch.Tensor]


def _gradient(w: torch.Tensor, data: Steps, average: bool = True) -> torch.Tensor:
    """Return the weighted least-squares gradient of a one-layer policy, written as a plain loop."""
    states, actions, advantages = data
    total = torch.zeros_like(w)
    for state, action, advantage in zip(states, actions, advantages, strict=True):
        total = total + advantage * (w @ state - action) * state
    return total / len(states) if average else total


def _hessian(data: Steps) -> torch.Tensor:
    states, _, advantages = data
    pairs = zip(states, advantages, strict=True)
    return sum(weight * torch.outer(state, state) for state, weight in pairs) / len(states)


@answered
def meta_gradient(student: Student) -> None:
    """Check the gradient through a step: f(w, before, after, alpha) -> (state,)."""
    normal = draws(51)
    w, alpha = normal(3), 0.3
    before, after = ((normal(20, 3), normal(20), normal(20)) for _ in range(2))
    value = as_tensor(student(w, before, after, alpha), (3,), "one number for each weight")
    adapted = w - alpha * _gradient(w, before)
    outer = _gradient(adapted, after)
    if close(value, outer - alpha * _hessian(before) @ outer):
        return
    if close(value, outer):
        raise Wrong("that is the first-order gradient: the factor (I - alpha H) is missing.")
    at_start = _gradient(w, after)
    if close(value, at_start - alpha * _hessian(before) @ at_start):
        raise Wrong("the gradient on the later data belongs at the adapted weights, not at w.")
    if close(value, outer - alpha * _hessian(after) @ outer):
        raise Wrong("H belongs to the data before the step: it is that step you differentiate.")
    if close(value, outer + alpha * _hessian(before) @ outer):
        raise Wrong(
            "the sign of H is turned: adaptation goes against the gradient, so I - alpha H."
        )
    if close(value, outer - _hessian(before) @ outer):
        raise Wrong("the learning rate alpha in front of H is missing.")
    summed = _gradient(w - alpha * _gradient(w, before, False), after, False)
    if close(value, summed - alpha * 20 * _hessian(before) @ summed):
        raise Wrong("sums where the formulas have means: divide g and H by the number of steps.")
    raise Wrong("the numbers differ. Adapt w, take g on the later data there, then multiply.")


def _system(size: int, condition: float) -> tuple[torch.Tensor, torch.Tensor]:
    """Return a random symmetric matrix of that condition number, and a right-hand side."""
    normal = draws(52)
    basis = torch.linalg.qr(normal(size, size))[0]
    eigenvalues = torch.logspace(0, -torch.log10(torch.tensor(condition)).item(), size)
    return basis @ torch.diag(eigenvalues.double()) @ basis.T, normal(size)


@answered
def conjugate_gradient(student: Student) -> None:
    """Check CG: f(product, target, iterations) -> x with product(x) = target."""
    matrix, target = _system(12, condition=1e4)
    asked: list[torch.Tensor] = []

    def product(vector: torch.Tensor) -> torch.Tensor:
        asked.append(vector.detach().clone())
        return matrix @ vector

    given = target.clone()
    three = as_tensor(student(product, given, 3), (12,), "one number for each unknown")
    if not torch.equal(given, target):
        raise Wrong("you changed the target in place: the residual must be a copy of it.")
    if len(asked) > 4:
        raise Wrong(f"3 iterations need 3 products; yours took {len(asked)}.")
    one = target * (target @ target) / (target @ matrix @ target)
    if not close(as_tensor(student(product, given, 1), (12,), "x"), one):
        raise Wrong(
            "the first step is off: along the target b, as far as b.b / b.Ab, starting from zero."
        )
    basis = [target, matrix @ target, matrix @ matrix @ target]
    reduced = torch.stack(basis, 1)  # CG's x minimises 1/2 x.Ax - b.x over these directions
    best = reduced @ torch.linalg.solve(reduced.T @ matrix @ reduced, reduced.T @ target)
    if not close(three, best, 1e-4):
        raise Wrong(
            "the directions are not conjugate. The new one is residual + (new r.r / old r.r) * "
            "direction, with the residual that is already updated."
        )
    zero = as_tensor(student(product, torch.zeros(12, dtype=torch.float64), 5), (12,), "x")
    if not bool((zero == 0).all()):
        raise Wrong("a target of zero gave no zeros: 0 / 0. Stop when the residual is zero.")


@answered
def full_step(student: Student) -> None:
    """Check the step length: f(direction, product, max_kl) -> the scaled direction."""
    matrix, direction = _system(5, condition=10.0)
    max_kl = 0.02
    got = student(direction, lambda vector: matrix @ vector, max_kl)
    value = as_tensor(got, (5,), "a step, one number for each parameter")
    curvature = direction @ matrix @ direction
    scale = (2 * max_kl / curvature).sqrt()
    if close(value, scale * direction):
        return
    if close(value, -scale * direction):
        raise Wrong("the step points backwards: keep the direction, only its length changes.")
    if close(value, (max_kl / curvature).sqrt() * direction):
        raise Wrong(
            "the KL is *half* the quadratic form, so there is a factor of 2 under the root."
        )
    if close(value, 2 * max_kl / curvature * direction):
        raise Wrong("the root is missing: the KL grows with the square of the length.")
    if close(value, (2 * max_kl) ** 0.5 * direction / direction.norm()):
        raise Wrong("that is a length in parameters; the KL measures it with F: use the product.")
    raise Wrong("the numbers differ. Solve 1/2 s^2 x.Fx = max_kl for s, and return s x.")


@answered
def supervised_meta_loss(student: Student) -> None:
    """Check Meta-BC's and GMPS's loss: f(theta, tasks, alpha) -> scalar; a task: (adapt_loss, bc_loss)."""
    normal = draws(53)
    tasks, numbers = [], []
    for _ in range(3):
        a, b = normal(4), normal(4)
        tasks.append(
            (lambda x, a=a: (x - a).pow(4).sum(), lambda x, b=b: 0.5 * (x - b).square().sum())
        )
        numbers.append((a, b))
    start, alpha = normal(4) * 0.3, 0.02
    theta = start.clone().requires_grad_()
    got = student(theta, tasks, alpha)
    value = as_tensor(got, (), "a single number")

    def mean(points: Callable[[torch.Tensor, torch.Tensor], torch.Tensor]) -> torch.Tensor:
        return sum(0.5 * (points(a, b) - b).square().sum() for a, b in numbers) / 3

    adapted = mean(lambda a, b: start - alpha * 4 * (start - a).pow(3))
    if not close(value, adapted):
        if close(value, 3 * adapted):
            raise Wrong("that is the sum over tasks; the meta-loss is their mean.")
        if close(value, mean(lambda a, b: start)):
            raise Wrong("the cloning loss belongs at the adapted parameters, not at theta.")
        if close(value, mean(lambda a, b: start - alpha * (start - b))):
            raise Wrong("you adapted by the cloning loss; use the task's own adaptation loss.")
        raise Wrong(
            "the numbers differ. One step on adapt_loss, then bc_loss there, then the mean."
        )
    if got.grad_fn is None:
        raise Wrong("right number, but it has no gradient: is there a `.detach()` in it?")
    whole = sum(
        (1 - alpha * 12 * (start - a).square()) * (start - alpha * 4 * (start - a).pow(3) - b)
        for a, b in numbers
    )
    if not close(torch.autograd.grad(got, theta)[0], whole / 3):
        raise Wrong("right number, but its gradient is first-order: use create_graph=True.")

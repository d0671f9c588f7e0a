"""Checks of notebook 05, the gradients: through a step, and of the supervised meta-loss."""

from __future__ import annotations

from collections.abc import Callable

import torch

from .answers import Student, answered
from .calls import ask
from .values import as_graph, as_tensor, draws, judge, pulled_back

Steps = tuple[torch.Tensor, torch.Tensor, torch.Tensor]
Vector = torch.Tensor


def _gradient(w: Vector, data: Steps, average: bool = True) -> Vector:
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
    for seed, (size, early, late, alpha) in enumerate(
        ((3, 20, 20, 0.3), (4, 17, 23, 0.15), (2, 9, 8, 0.5)), start=51
    ):
        normal = draws(seed)
        w = normal(size)
        before, after = ((normal(n, size), normal(n), normal(n)) for n in (early, late))
        got = ask(student, w, before, after, alpha).answer
        value = as_tensor(got, (size,), "one number for each weight")
        _judge_meta_gradient(value, w, before, after, alpha)


def _judge_meta_gradient(
    value: Vector, w: Vector, before: Steps, after: Steps, alpha: float
) -> None:
    """Compare the meta-gradient; name the mistake that it equals."""
    hessian, later = _hessian(before), _hessian(after)
    outer = _gradient(w - alpha * _gradient(w, before), after)
    at_start = _gradient(w, after)
    climbed = _gradient(w + alpha * _gradient(w, before), after)
    full = _gradient(w - _gradient(w, before), after)
    summed = _gradient(w - alpha * _gradient(w, before, False), after, False)
    count, other = len(before[0]), len(after[0])
    mistakes = {
        "that is the first-order gradient: the factor (I - alpha H) is missing.": outer,
        "the gradient on the later data belongs at the adapted weights, not at w.": (
            at_start - alpha * hessian @ at_start
        ),
        "H belongs to the data before the step: it is that step you differentiate.": (
            outer - alpha * later @ outer
        ),
        "the sign of H is turned: adaptation goes against the gradient, so I - alpha H.": (
            outer + alpha * hessian @ outer
        ),
        "the learning rate alpha in front of H is missing.": outer - hessian @ outer,
        "the learning rate alpha in the adaptation step is missing.": (
            full - alpha * hessian @ full
        ),
        "the adaptation step climbs: it goes against the gradient.": (
            climbed - alpha * hessian @ climbed
        ),
        "sums where the formulas have means: divide g and H by the number of steps.": (
            summed - alpha * count * hessian @ summed
        ),
        "H is a mean as well: divide it by the number of steps.": (
            outer - alpha * count * hessian @ outer
        ),
        "each mean divides by the number of its own data's steps; the two may differ.": (
            outer - alpha * count / other * hessian @ outer
        ),
        "that is the part of (I - alpha H) with H alone: the gradient itself is missing.": (
            -alpha * hessian @ outer
        ),
    }
    judge(
        value,
        outer - alpha * hessian @ outer,
        mistakes,
        "the numbers differ. Adapt w, take g on the later data there, then multiply.",
    )


@answered
def supervised_meta_loss(student: Student) -> None:
    """Check Meta-BC's and GMPS's loss: f(theta, tasks, alpha) -> scalar; a task: (adapt_loss, bc_loss)."""
    for seed, (size, count, alpha, dtype) in enumerate(
        (
            (4, 3, 0.02, torch.float64),
            (5, 4, 0.05, torch.float64),
            (3, 2, 0.03, torch.float32),
            (3, 1, 0.04, torch.float64),
        ),
        start=53,
    ):
        normal = draws(seed)
        numbers = [(normal(size), normal(size)) for _ in range(count)]
        theta = (0.3 * normal(size)).to(dtype).requires_grad_()
        asked = ask(student, theta, [_task(a, b) for a, b in numbers], alpha)
        got = as_graph(asked.answer, (), "a single number")
        start = theta.detach().double()
        _judge_meta_loss(got, start, numbers, alpha)
        _judge_its_gradient(got, asked.given[0], start, numbers, alpha)


def _task(a: Vector, b: Vector) -> tuple[Callable, Callable]:
    """Return a quartic adaptation loss and a quadratic cloning loss."""
    return (
        lambda x: (x - a.to(x.dtype)).pow(4).sum(),
        lambda x: 0.5 * (x - b.to(x.dtype)).square().sum(),
    )


def _judge_meta_loss(got: torch.Tensor, start: Vector, numbers: list, alpha: float) -> None:
    """Compare the value of the meta-loss; name the mistake that it equals."""

    def mean(points: Callable[[Vector, Vector], Vector]) -> torch.Tensor:
        each = [0.5 * (points(a, b) - b).square().sum() for a, b in numbers]
        return torch.stack(each).mean()

    def slope(a: Vector) -> Vector:
        return 4 * (start - a).pow(3)

    adapted = mean(lambda a, b: start - alpha * slope(a))
    last = numbers[-1]
    mistakes = {
        "that is the sum over tasks; the meta-loss is their mean.": len(numbers) * adapted,
        "the cloning loss belongs at the adapted parameters, not at theta.": (
            mean(lambda a, b: start)
        ),
        "you adapted by the cloning loss; use the task's own adaptation loss.": (
            mean(lambda a, b: start - alpha * (start - b))
        ),
        "the adaptation step climbs: it goes against the gradient.": (
            mean(lambda a, b: start + alpha * slope(a))
        ),
        "the learning rate alpha is missing.": mean(lambda a, b: start - slope(a)),
        "that is the last task's loss; the meta-loss is the mean over all tasks.": (
            0.5 * (start - alpha * slope(last[0]) - last[1]).square().sum()
        ),
        "every task must start from the same theta, not where the task before it ended.": (
            _in_a_row(start, numbers, alpha)
        ),
    }
    hint = "the numbers differ. One step on adapt_loss, then bc_loss there, then the mean."
    judge(got, adapted, mistakes, hint)


def _in_a_row(start: Vector, numbers: list, alpha: float) -> torch.Tensor:
    """Return the loss when each task goes on from where the one before it ended."""
    total, here = torch.zeros((), dtype=torch.float64), start
    for a, b in numbers:
        here = here - alpha * 4 * (here - a).pow(3)
        total = total + 0.5 * (here - b).square().sum() / len(numbers)
    return total


def _judge_its_gradient(
    got: torch.Tensor, theta: Vector, start: Vector, numbers: list, alpha: float
) -> None:
    """Compare the exact gradient of the meta-loss by theta."""
    one = torch.ones((), dtype=torch.float64)
    cut = "right number, but it has no gradient: is there a `.detach()` in it?"
    value = pulled_back(got, theta, one, cut)
    ends = [(a, start - alpha * 4 * (start - a).pow(3) - b) for a, b in numbers]
    curved = [-alpha * 12 * (start - a).square() * end for a, end in ends]
    plain = torch.stack([end for _, end in ends]).mean(0)
    through = torch.stack(curved).mean(0)
    mistakes = {
        "right number, but its gradient is first-order: use create_graph=True.": plain,
        "right number, but theta itself is cut off: do not detach the theta that you step from.": (
            through
        ),
    }
    hint = "right number, but its gradient by theta is off: is a part of it detached?"
    judge(value, plain + through, mistakes, hint)

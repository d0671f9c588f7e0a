"""Check of notebook 06: the meta-loss of one iteration of Algorithm 1."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_graph, draws, episode_mask, judge, pulled_back

CUT = (
    "right number, but it has no gradient by theta: the surrogate's new policy must hang on "
    "`adapted(theta, task)`."
)


def _task(size: int, normal: Callable[..., torch.Tensor], seed: int) -> SimpleNamespace:
    """Return a task with random log-densities, and a step of its own that bends theta."""
    episodes, horizon = 3 + seed % 2, 5
    matrix, offset, pull = normal(episodes, horizon, size), normal(episodes, horizon), normal(size)

    def log_prob(theta: torch.Tensor) -> torch.Tensor:
        means = matrix.to(theta.dtype) @ theta + offset.to(theta.dtype)
        return -0.1 * means.square()

    return SimpleNamespace(
        log_prob=log_prob,
        collected_with=0.6 * normal(size),
        advantages=normal(episodes, horizon) + 0.3,
        mask=episode_mask(episodes, horizon, seed, torch.float64),
        pull=pull,
    )


def _adapted(theta: torch.Tensor, task: SimpleNamespace) -> torch.Tensor:
    """Return a step whose Jacobian is neither the identity nor constant."""
    away = theta - task.pull.to(theta.dtype)
    return theta - 0.2 * away - 0.05 * away.pow(3)


def _surrogate(
    new: torch.Tensor, old: torch.Tensor, gain: torch.Tensor, mask: torch.Tensor
) -> torch.Tensor:
    return -(torch.exp(new - old) * gain.to(new) * mask.to(new)).sum() / mask.to(new).sum()


@answered
def meta_loss(student: Student) -> None:
    """Check one iteration's loss: f(theta, tasks, adapted, surrogate) -> scalar in theta's graph."""
    for seed, (size, count, dtype) in enumerate(
        ((4, 3, torch.float64), (5, 2, torch.float64), (3, 4, torch.float32)), start=21
    ):
        normal = draws(seed)
        tasks = tuple(_task(size, normal, seed + number) for number in range(count))
        start = 0.5 * normal(size)
        mine = start.clone().requires_grad_()
        values = _meta_mistakes(mine, tasks)
        expected = _mean_loss(mine, tasks)
        exact = pulled_back(expected, mine, torch.ones(()).double(), CUT)
        given = tuple(_in_precision(task, dtype) for task in tasks)
        asked = ask(student, start.to(dtype).requires_grad_(), given, _adapted, _surrogate)
        _unchanged(given, tasks, dtype)
        got = as_graph(asked.answer, (), "a single number")
        judge(got, expected, values, "the numbers differ. Adapt, compare with the old, average.")
        through = pulled_back(got, asked.given[0], torch.ones(()).double(), CUT)
        judge(
            through,
            exact,
            _graph_mistakes(mine, tasks),
            "right number, but the gradient by theta is off: does a part of it pass a `.detach()`?",
        )


def _in_precision(task: SimpleNamespace, dtype: torch.dtype) -> SimpleNamespace:
    tensors = ("collected_with", "advantages", "mask", "pull")
    changed = {name: getattr(task, name).to(dtype).clone() for name in tensors}
    return SimpleNamespace(**{**vars(task), **changed})


def _unchanged(given: Sequence, tasks: Sequence, dtype: torch.dtype) -> None:
    for one, other in zip(given, tasks, strict=True):
        for name in ("collected_with", "advantages", "mask"):
            if not torch.equal(getattr(one, name), getattr(other, name).to(dtype)):
                raise Wrong(
                    f"you changed `task.{name}` in place. The next call needs it as it was."
                )


def _mean_loss(
    theta: torch.Tensor,
    tasks: Sequence,
    new: Callable[..., torch.Tensor] = _adapted,
    old: Callable[..., torch.Tensor] = lambda theta, task: task.collected_with,
) -> torch.Tensor:
    """Return the mean surrogate where ``new`` and ``old`` say whose log-densities are compared."""
    each = [
        _surrogate(
            task.log_prob(new(theta, task)),
            task.log_prob(old(theta, task)),
            task.advantages,
            task.mask,
        )
        for task in tasks
    ]
    return torch.stack(each).mean()


def _meta_mistakes(theta: torch.Tensor, tasks: Sequence) -> dict[str, torch.Tensor]:
    """Return the numbers that plausible mistakes give."""

    def collected(_: torch.Tensor, task: SimpleNamespace) -> torch.Tensor:
        return task.collected_with

    right = _mean_loss(theta, tasks)
    steps = sum(task.mask.sum() for task in tasks)
    pooled = sum(_mean_loss(theta, [task]) * task.mask.sum() for task in tasks) / steps
    mistakes = {
        "that is the sum over tasks; their mean is meant.": len(tasks) * right,
        "that is the last task's loss; the mean over all tasks is meant.": (
            _mean_loss(theta, tasks[-1:])
        ),
        "that is the first task's loss: does `return` stand inside the loop?": (
            _mean_loss(theta, tasks[:1])
        ),
        "the sign is turned: the surrogate is a loss already.": -right,
        "every ratio is 1: the old policy is the one that collected D^val, "
        "`task.collected_with`, not the one that theta leads to now.": (
            _mean_loss(theta, tasks, old=_adapted)
        ),
        "the new policy is not adapted: D^val judges `adapted(theta, task)`, not theta.": (
            _mean_loss(theta, tasks, new=lambda theta, task: theta)
        ),
        "the old policy is the adapted one that collected D^val, not the meta-policy.": (
            _mean_loss(theta, tasks, old=lambda theta, task: theta)
        ),
        "new and old are swapped.": _mean_loss(theta, tasks, collected, _adapted),
        "you adapt twice: the step starts from theta, not from `task.collected_with`.": (
            _mean_loss(theta, tasks, lambda theta, task: _adapted(task.collected_with, task))
        ),
        "every task weighs the same, however many steps its episodes took.": pooled,
        "every task must start from the same theta, not where the task before it ended.": (
            _in_a_row(theta, tasks)
        ),
    }
    return {sentence: value.detach() for sentence, value in mistakes.items()}


def _in_a_row(theta: torch.Tensor, tasks: Sequence) -> torch.Tensor:
    each = []
    for task in tasks:
        theta = _adapted(theta, task)
        each.append(_mean_loss(theta, [task], new=lambda theta, task: theta))
    return torch.stack(each).mean()


def _graph_mistakes(theta: torch.Tensor, tasks: Sequence) -> dict[str, torch.Tensor]:
    """Return the gradients of answers whose number is right."""

    def straight(theta: torch.Tensor, task: SimpleNamespace) -> torch.Tensor:
        return theta + (_adapted(theta, task) - theta).detach()

    loss = _mean_loss(theta, tasks, straight)
    first_order = (
        "right number, but the gradient does not go through the adaptation step: theta_i is a "
        "function of theta."
    )
    return {first_order: pulled_back(loss, theta, torch.ones(()).double(), CUT)}

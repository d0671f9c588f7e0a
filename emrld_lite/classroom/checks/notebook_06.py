"""Checks of notebook 06: EMRLD."""

from __future__ import annotations

from collections.abc import Callable

import torch

from .answers import Student, Wrong, answered, as_tensor, close, draws


def _quadratic(normal: Callable[..., torch.Tensor]) -> tuple[Callable, Callable, torch.Tensor]:
    """Return two random quadratic losses on 4 parameters, and a point."""
    matrices = [m @ m.T / 4 for m in (normal(4, 4), normal(4, 4))]
    offsets = [normal(4), normal(4)]

    def loss(which: int) -> Callable[[torch.Tensor], torch.Tensor]:
        return lambda theta: 0.5 * theta @ matrices[which] @ theta + offsets[which] @ theta

    return loss(0), loss(1), normal(4)


@answered
def adaptation_step(student: Student) -> None:
    """Check equation (adapt_rl_bc): f(theta, rl_loss, bc_loss, w_rl, w_bc, alpha) -> theta_i."""
    rl_loss, bc_loss, start = _quadratic(draws(5))
    theta = start.clone().requires_grad_()
    w_rl, w_bc, alpha = 0.3, 0.8, 0.1
    got = student(theta, rl_loss, bc_loss, w_rl, w_bc, alpha)
    value = as_tensor(got, (4,), "the adapted parameters")

    def stepped(one: float, other: float) -> torch.Tensor:
        point = start.clone().requires_grad_()
        total = one * rl_loss(point) + other * bc_loss(point)
        return start - alpha * torch.autograd.grad(total, point)[0]

    expected = stepped(w_rl, w_bc)
    if not torch.equal(theta.detach(), start):
        raise Wrong("you changed theta in place; every task must start from the same theta.")
    if not close(value, expected):
        if close(value, 2 * start - expected):
            raise Wrong("you climb the loss: the step goes against the gradient.")
        if close(value, stepped(w_bc, w_rl)):
            raise Wrong("the weights are swapped: w_rl belongs to the RL loss.")
        if close(value, stepped(1.0, 1.0)):
            raise Wrong("the weights w_rl and w_bc are missing.")
        if close(value, start - (start - expected) / alpha):
            raise Wrong("the learning rate alpha is missing.")
        raise Wrong("the numbers differ. Take one gradient of the weighted sum, at theta.")
    if got.grad_fn is None:
        raise Wrong("right numbers, but cut from theta: the meta-gradient could not flow back.")
    direction = torch.ones(4, dtype=torch.float64)
    through = torch.autograd.grad(got @ direction, theta)[0]
    if close(through, direction):
        raise Wrong(
            "right numbers, but the meta-gradient is first-order: it does not see that the "
            "adaptation's own gradient depends on theta. Use create_graph=True."
        )


@answered
def warm_start_step(student: Student) -> None:
    """Check EMRLD-WS: f(theta, rl_loss, bc_loss, w_rl, w_bc, alpha) -> theta_i, two steps in a row."""
    rl_loss, bc_loss, start = _quadratic(draws(6))
    theta = start.clone().requires_grad_()
    w_rl, w_bc, alpha = 0.3, 0.8, 0.1
    got = student(theta, rl_loss, bc_loss, w_rl, w_bc, alpha)
    value = as_tensor(got, (4,), "the adapted parameters")

    def gradient(loss: Callable, at: torch.Tensor) -> torch.Tensor:
        point = at.clone().requires_grad_()
        return torch.autograd.grad(loss(point), point)[0]

    def both(theta: torch.Tensor) -> torch.Tensor:
        return w_rl * rl_loss(theta) + w_bc * bc_loss(theta)

    warm = start - alpha * gradient(bc_loss, start)
    if close(value, warm - alpha * gradient(both, warm)):
        if got.grad_fn is None:
            raise Wrong("right numbers, but cut from theta: the meta-gradient could not flow back.")
        return
    if close(value, start - alpha * gradient(both, start)):
        raise Wrong("that is EMRLD: the cloning step that comes first is missing.")
    if close(value, warm):
        raise Wrong("that is the warm start alone: the adaptation step must follow it.")
    if close(value, start - alpha * gradient(both, warm)):
        raise Wrong("the second step must start from the warm-started parameters, not from theta.")
    if close(value, warm - alpha * gradient(both, start)):
        raise Wrong("the second gradient must be taken at the warm-started parameters.")
    weighted = start - alpha * w_bc * gradient(bc_loss, start)
    if close(value, weighted - alpha * gradient(both, weighted)):
        raise Wrong("the paper's warm start has no weight: one plain step on L^BC.")
    raise Wrong("the numbers differ. First one step on L^BC alone, then the step of EMRLD.")


@answered
def surrogate(student: Student) -> None:
    """Check TRPO's surrogate: f(new_log_prob, old_log_prob, advantages, mask) -> scalar loss."""
    normal = draws(7)
    old = normal(3, 5)
    new = (old + 0.3 * normal(3, 5)).requires_grad_()
    advantage = normal(3, 5)
    mask = torch.tensor([[1, 1, 1, 1, 1], [1, 1, 1, 0, 0], [1, 0, 0, 0, 0]], dtype=torch.float64)
    got = student(new, old, advantage, mask)
    value = as_tensor(got, (), "a single number")
    ratio = (new.detach() - old).exp()
    expected = -(ratio * advantage * mask).sum() / mask.sum()
    if close(value, expected):
        if got.grad_fn is None:
            raise Wrong("right number, but it has no gradient: is there a `.detach()` in it?")
        return
    if close(value, -expected):
        raise Wrong("the sign is turned: the surrogate loss is minus the weighted advantage.")
    if close(value, -((new.detach() - old) * advantage * mask).sum() / mask.sum()):
        raise Wrong("the ratio of densities is the exponential of the difference of their logs.")
    if close(value, -(advantage * mask / ratio).sum() / mask.sum()):
        raise Wrong("the ratio is upside down: new over old.")
    if close(value, -(ratio * advantage).mean()):
        raise Wrong("steps after an episode's end count too: use the mask.")
    raise Wrong("the numbers differ. The ratio pi_new/pi_old weighs each advantage.")

"""Checks of notebook 06: the adaptation step and the surrogate.

The gradient is the point here, so the answer's exact derivative by theta is compared, not only its
numbers. The reference is computed in double precision.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import torch

from .answers import Student, Wrong, answered
from .calls import Asked, ask
from .values import as_graph, close, draws, episode_mask, judge, pulled_back

Loss = Callable[[torch.Tensor], torch.Tensor]
Steps = Callable[..., torch.Tensor]

CUT = "right numbers, but cut from theta: the meta-gradient could not flow back."
FIRST_ORDER = (
    "right numbers, but the meta-gradient is first-order: it does not see that the adaptation's own "
    "gradient depends on theta. Use create_graph=True."
)
GRADIENT_DIFFERS = (
    "right numbers, but the meta-gradient through them is off: is a part of the step detached, or a "
    "gradient taken without create_graph=True?"
)
# (parameters, w_rl, w_bc, alpha, precision of theta)
SETTINGS = (
    (4, 0.3, 0.8, 0.1, torch.float64),
    (6, 1.3, 0.4, 0.2, torch.float64),
    (3, 0.7, 1.6, 0.05, torch.float32),
)


def _losses(size: int, seed: int) -> tuple[Loss, Loss, torch.Tensor]:
    """Return two random losses whose Hessians differ and move with theta, and a point."""
    normal = draws(seed)

    def loss(matrix: torch.Tensor, offset: torch.Tensor, quartic: torch.Tensor) -> Loss:
        square = matrix @ matrix.T / size

        def at(theta: torch.Tensor) -> torch.Tensor:
            curved, along = square.to(theta.dtype), offset.to(theta.dtype)
            fourth = 0.05 * (theta - quartic.to(theta.dtype)).pow(4).sum()
            return 0.5 * theta @ curved @ theta + along @ theta + fourth

        return at

    one, other = (loss(normal(size, size), normal(size), normal(size)) for _ in range(2))
    return one, other, normal(size)


def _slope(loss: Loss, at: torch.Tensor, keep: bool = True) -> torch.Tensor:
    """Return the loss's gradient, with its own graph or cut off from it."""
    point = at if at.requires_grad else at.clone().requires_grad_()
    (gradient,) = torch.autograd.grad(loss(point), point, create_graph=True)
    return gradient if keep else gradient.detach()


class Right(NamedTuple):
    """The right steps, and the mistakes that change theta_i, or only its derivative by theta."""

    steps: Steps
    numbers: dict[str, Steps]
    graphs: dict[str, Steps]


def _compare(asked: Asked, start: torch.Tensor, right: Right, hint: str) -> None:
    """Compare an adapted theta and its derivative with the right ones; name what is wrong."""
    got = as_graph(asked.answer, start.shape, "the adapted parameters")
    theta = start.double().clone().requires_grad_()
    expected = right.steps(theta)
    wrong = {sentence: variant(theta).detach() for sentence, variant in right.numbers.items()}
    judge(got, expected, wrong, f"the numbers differ. {hint}")
    for seed in (1, 2):
        weights = draws(seed)(len(start))
        through = pulled_back(got, asked.given[0], weights, CUT)
        exact = pulled_back(expected, theta, weights, CUT)
        mistaken = {
            sentence: pulled_back(variant(theta), theta, weights, CUT)
            for sentence, variant in right.graphs.items()
        }
        judge(through, exact, mistaken, GRADIENT_DIFFERS)


@answered
def adaptation_step(student: Student) -> None:
    """Check equation (adapt_rl_bc): f(theta, rl_loss, bc_loss, w_rl, w_bc, alpha) -> theta_i."""
    for seed, (size, w_rl, w_bc, alpha, dtype) in enumerate(SETTINGS, start=5):
        rl_loss, bc_loss, start = _losses(size, seed)
        theta = start.to(dtype).requires_grad_()
        asked = ask(student, theta, rl_loss, bc_loss, w_rl, w_bc, alpha)
        right = _one_step(rl_loss, bc_loss, w_rl, w_bc, alpha)
        _compare(asked, start, right, "Take one gradient of the weighted sum, at theta.")


def _one_step(rl_loss: Loss, bc_loss: Loss, w_rl: float, w_bc: float, alpha: float) -> Right:
    """Return the right step, and the mistakes in its numbers and in its graph."""

    def step(
        theta: torch.Tensor,
        rl: float = w_rl,
        bc: float = w_bc,
        rate: float = alpha,
        keep_rl: bool = True,
        keep_bc: bool = True,
    ) -> torch.Tensor:
        slope = rl * _slope(rl_loss, theta, keep_rl) + bc * _slope(bc_loss, theta, keep_bc)
        return theta - rate * slope

    numbers = {
        "you climb the loss: the step goes against the gradient.": lambda x: step(x, rate=-alpha),
        "the weights are swapped: w_rl belongs to the RL loss.": lambda x: step(x, w_bc, w_rl),
        "the weights w_rl and w_bc are missing.": lambda x: step(x, 1.0, 1.0),
        "the weight w_rl of the RL loss is missing.": lambda x: step(x, rl=1.0),
        "the weight w_bc of the cloning loss is missing.": lambda x: step(x, bc=1.0),
        "the cloning loss is missing.": lambda x: step(x, bc=0.0),
        "the RL loss is missing.": lambda x: step(x, rl=0.0),
        "the RL loss must be added to the cloning loss, not subtracted.": (
            lambda x: step(x, rl=-w_rl)
        ),
        "the cloning loss must be added, not subtracted.": lambda x: step(x, bc=-w_bc),
        "the learning rate alpha is missing.": lambda x: step(x, rate=1.0),
        "that is the step alone: take it away from theta.": lambda x: x - step(x),
        "that is the step alone, with its sign: add it to theta.": lambda x: step(x) - x,
        "theta comes back as it was: where is the step?": lambda x: 1.0 * x,
    }
    graphs = {
        FIRST_ORDER: lambda x: step(x, keep_rl=False, keep_bc=False),
        "right numbers, but the RL loss's gradient is cut off: it needs create_graph=True, too.": (
            lambda x: step(x, keep_rl=False)
        ),
        "right numbers, but the cloning loss's gradient is cut off: it needs create_graph=True, "
        "too.": lambda x: step(x, keep_bc=False),
        "right numbers, but theta itself is cut off: do not detach the theta that you step from.": (
            lambda x: step(x) - x + x.detach()
        ),
    }
    return Right(step, numbers, graphs)


@answered
def surrogate(student: Student) -> None:
    """Check TRPO's surrogate: f(new_log_prob, old_log_prob, advantages, mask) -> scalar loss."""
    for seed, (episodes, horizon, dtype) in enumerate(
        ((3, 5, torch.float64), (4, 7, torch.float64), (2, 6, torch.float32)), start=7
    ):
        normal = draws(seed, dtype)
        old, advantage = normal(episodes, horizon), normal(episodes, horizon) + 0.5
        new = (old + 0.6 * normal(episodes, horizon)).requires_grad_()
        mask = episode_mask(episodes, horizon, seed, dtype)
        asked = ask(student, new, old, advantage, mask)
        got = as_graph(asked.answer, (), "a single number")
        _judge_surrogate(got, new.detach().double(), old.double(), advantage.double(), mask)
        ratio = (new.detach().double() - old.double()).exp()
        exact = -ratio * advantage * mask / mask.sum()
        one = torch.ones((), dtype=torch.float64)
        cut = (
            "right number, but it has no gradient by the new log-densities: is there a `.detach()` "
            "in it?"
        )
        if not close(pulled_back(got, asked.given[0], one, cut), exact):
            raise Wrong(
                "right number, but its gradient is off: the whole ratio depends on the new "
                "log-density, so detach no part of it."
            )


def _judge_surrogate(
    got: torch.Tensor, new: torch.Tensor, old: torch.Tensor, gain: torch.Tensor, mask: torch.Tensor
) -> None:
    """Compare the surrogate's value; name the mistake that it equals."""
    ratio, steps = (new - old).exp(), mask.sum()
    weighted = ratio * gain * mask
    expected = -weighted.sum() / steps
    clipped = torch.minimum(weighted, ratio.clamp(0.8, 1.2) * gain * mask)
    mistakes = {
        "the sign is turned: the surrogate loss is minus the weighted advantage.": -expected,
        "the ratio of densities is the exponential of the difference of their logs.": (
            -((new - old) * gain * mask).sum() / steps
        ),
        "the ratio is upside down: new over old.": -(gain * mask / ratio).sum() / steps,
        "divide densities, not their logarithms: exp(new - old).": (
            -(new / old * gain * mask).sum() / steps
        ),
        "steps after an episode's end count too: use the mask.": -(ratio * gain).mean(),
        "the mask must also leave out steps of the sum, not only of the count.": (
            -(ratio * gain).sum() / steps
        ),
        "you divide by all entries; the mean is over the steps that were taken.": -weighted.mean(),
        "you return the sum; the mean over the steps taken is meant.": -weighted.sum(),
        "you average each episode first; every step that was taken weighs the same.": (
            -(weighted.sum(-1) / mask.sum(-1)).mean()
        ),
        "the advantages are missing.": -(ratio * mask).sum() / steps,
        "that clips the ratio, as PPO does; TRPO's surrogate does not.": -clipped.sum() / steps,
        "the old policy's density is missing in the ratio.": (
            -(new.exp() * gain * mask).sum() / steps
        ),
        "that is the REINFORCE loss: the ratio of densities weighs the advantage here.": (
            -(new * gain * mask).sum() / steps
        ),
    }
    judge(got, expected, mistakes, "the numbers differ. The ratio new/old weighs each advantage.")

"""Random numbers for the questions of every exercise, and whether two answers are the same.

An answer is right when it gives the solution's numbers and derivatives on random questions that no check
draws, and leaves its arguments as they are.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from emrld_lite.classroom.checks.patience import TimeUp, limited

LONGEST = 5.0  # seconds of the processor for one question; an endless loop is a wrong answer
Question = tuple[Any, ...]
Questions = dict[str, Callable[["Draw"], Question]]
F = torch.float32
D = torch.float64


class Draw:
    """Random numbers of one question."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)

    def normal(self, *shape: int, dtype: torch.dtype = D) -> torch.Tensor:
        return torch.as_tensor(self.random.normal(size=shape)).to(dtype)

    def leaf(self, *shape: int, dtype: torch.dtype = D) -> torch.Tensor:
        return self.normal(*shape, dtype=dtype).requires_grad_()

    def whole(self, low: int, high: int) -> int:
        return int(self.random.integers(low, high))

    def between(self, low: float, high: float) -> float:
        return float(self.random.uniform(low, high))

    def table(self, *shape: int) -> torch.Tensor:
        return self.normal(*shape).softmax(-1)

    def mask(self, episodes: int, horizon: int) -> torch.Tensor:
        lengths = torch.as_tensor(self.random.integers(1, horizon + 1, episodes))
        return (torch.arange(horizon) < lengths[:, None]).to(D)


def wave(draw: Draw, size: int) -> Callable[[torch.Tensor], torch.Tensor]:
    a, b = draw.normal(size, size), draw.normal(size)
    return lambda x: torch.sin(a @ x + b).sum() + 0.3 * (x - b).square().sum()


def episodes(draw: Draw) -> tuple[int, int]:
    return draw.whole(2, 6), draw.whole(2, 14)


def shaped(*makers: str) -> Callable[[Draw], Question]:
    """Return a question of tensors (episode, time): leaf, normal or mask."""

    def question(draw: Draw) -> Question:
        shape = episodes(draw)
        return tuple(getattr(draw, maker)(*shape) for maker in makers)

    return question


def gaussians(draw: Draw, logarithm: bool) -> Question:
    shape = *episodes(draw), draw.whole(1, 4)
    spread = draw.normal(*shape) if logarithm else draw.normal(*shape).abs() + 0.1
    return draw.leaf(*shape), spread.requires_grad_(), draw.normal(*shape)


def _numbers(value: Any) -> Any:
    """Return an answer as nested lists of numbers, whatever holds them."""
    if isinstance(value, torch.Tensor | np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, dict):
        return {key: _numbers(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_numbers(part) for part in value]
    return value


def _alike(one: Any, other: Any) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_alike(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_alike, one, other))
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=1e-5, abs_tol=1e-6)
    return type(one) is type(other) and one == other


def _seen(function: Callable[..., Any], question: Question) -> tuple[Any, Any, Any]:
    """Return an answer's numbers, its derivatives by the leaves, and the arguments afterwards."""
    given = copy.deepcopy(question)
    leaves = [p for p in given if isinstance(p, torch.Tensor) and p.requires_grad]
    answer = function(*given)
    slopes = None
    if leaves and isinstance(answer, torch.Tensor) and answer.requires_grad:
        weights = torch.linspace(1, 2, answer.numel(), dtype=answer.dtype).reshape(answer.shape)
        slopes = torch.autograd.grad((answer * weights).sum(), leaves, allow_unused=True)
    arguments = [p for p in given if isinstance(p, torch.Tensor | np.ndarray | dict | float)]
    return _numbers(answer), _numbers(slopes), _numbers(arguments)


def same(
    asked: Callable[[Draw], Question],
    function: Callable[..., Any],
    solution: Callable[..., Any],
    many: int = 25,
) -> bool:
    """Return whether a function answers ``many`` random questions as the solution does."""
    for seed in range(1000, 1000 + many):
        question = asked(Draw(seed))
        try:
            with limited(LONGEST):
                seen = _seen(function, question)
        except (Exception, TimeUp):
            return False
        if not _alike(list(seen), list(_seen(solution, question))):
            return False
    return True

"""Random questions for every exercise, drawn by no check: they decide whether an answer is right.

An answer is right when it gives the solution's numbers and derivatives on all of them, and leaves
its arguments as they are.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

Question = tuple[Any, ...]
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


def _wave(draw: Draw, size: int) -> Callable[[torch.Tensor], torch.Tensor]:
    a, b = draw.normal(size, size), draw.normal(size)
    return lambda x: torch.sin(a @ x + b).sum() + 0.3 * (x - b).square().sum()


def _matrix(draw: Draw, size: int) -> torch.Tensor:
    root = draw.normal(size, size)
    return root @ root.T + 0.1 * torch.eye(size, dtype=D)


def _product(matrix: torch.Tensor) -> Callable[[torch.Tensor], torch.Tensor]:
    return lambda vector: matrix @ vector


def _policies(draw: Draw) -> Question:
    states, actions = draw.whole(2, 5), draw.whole(2, 5)
    return (
        draw.normal(states, actions), draw.table(states), draw.table(states),
        draw.table(states, actions), draw.table(states, actions), draw.between(0.3, 0.95),
    )  # fmt: skip


def _step(draw: Draw) -> Question:
    position, move = draw.normal(2), 0.12 * draw.normal(2)
    away = math.exp(draw.between(-5, 1)) * draw.normal(2)
    goal = position + move * min(1, 0.1 / float(move.norm())) + away
    return position, move, goal, draw.whole(0, 100)


def _episodes(draw: Draw) -> tuple[int, int]:
    return draw.whole(2, 6), draw.whole(2, 14)


def _dicts(draw: Draw) -> Question:
    seeds = [draw.random.permutation(7)[: draw.whole(2, 7)].tolist() for _ in range(2)]
    return tuple({seed: draw.between(-9, 9) for seed in some} for some in seeds)


def _cut(draw: Draw) -> Question:
    return draw.normal(*_episodes(draw)).abs().mul(8).round() / 8, draw.whole(1, 8) / 8


def _plan(draw: Draw) -> Question:
    letters = "abcdefg"
    control = {letter: draw.whole(0, 5) for letter in letters[: draw.whole(1, 6)]}
    names = letters[: draw.whole(1, 4)]
    return control, {name: {draw.random.choice(list(letters)): draw.whole(5, 9)} for name in names}


def _adaptation(draw: Draw) -> Question:
    size = draw.whole(2, 6)
    waves = _wave(draw, size), _wave(draw, size)
    weights = (draw.between(0.2, 2) for _ in range(2))
    return draw.leaf(size), *waves, *weights, draw.between(0.02, 0.3)


def _meta(draw: Draw) -> Question:
    size = draw.whole(2, 5)
    data = []
    for _ in range(2):
        steps = draw.whole(3, 20)
        data.append((draw.normal(steps, size), draw.normal(steps), draw.normal(steps)))
    return draw.normal(size), *data, draw.between(0.05, 0.5)


def _meta_loss(draw: Draw) -> Question:
    size = draw.whole(2, 5)
    tasks = [(_wave(draw, size), _wave(draw, size)) for _ in range(draw.whole(1, 5))]
    return draw.leaf(size), tasks, draw.between(0.02, 0.3)


def _shaped(*makers: str) -> Callable[[Draw], Question]:
    """Return a question of tensors (episode, time): leaf, normal or mask."""

    def question(draw: Draw) -> Question:
        shape = _episodes(draw)
        return tuple(getattr(draw, maker)(*shape) for maker in makers)

    return question


def _world(draw: Draw) -> Question:
    states, actions = draw.whole(2, 6), draw.whole(2, 5)
    return (
        draw.table(states, actions, states), draw.table(states), draw.table(states, actions),
        draw.between(0.3, 0.95),
    )  # fmt: skip


def _assumption(draw: Draw) -> Question:
    shape = draw.whole(1, 4), draw.whole(2, 5), draw.whole(2, 5)
    return draw.normal(*shape) + draw.between(-1, 1), draw.table(*shape)


def _pinsker(draw: Draw) -> Question:
    entropy = draw.between(-1, 3)
    return torch.tensor(entropy + draw.between(0.1, 4), dtype=D), torch.tensor(entropy, dtype=D)


def _vector(draw: Draw) -> Question:
    size = draw.whole(2, 7)
    return draw.normal(size), _product(_matrix(draw, size)), draw.between(0.005, 0.5)


def _target(draw: Draw) -> Question:
    size = draw.whole(4, 9)
    zero = draw.whole(0, 6) == 0
    target = torch.zeros(size, dtype=D) if zero else draw.between(0.01, 2) * draw.normal(size)
    return _product(_matrix(draw, size)), target, draw.whole(1, 4)


def _scores(draw: Draw) -> np.ndarray:
    return draw.random.exponential(9, [(7,), (3,), (16,), (4, 5), (2, 9)][draw.whole(0, 5)])


def _wheels(draw: Draw) -> Question:
    count = draw.whole(2, 6)
    return 2 * draw.normal(count, 3), draw.normal(count), draw.normal(count), draw.between(0.05, 2)


def _tasks(draw: Draw) -> Question:
    count = draw.whole(2, 5)
    return draw.normal(count, draw.whole(2, 5), draw.whole(1, 5)), draw.normal(
        count, draw.whole(1, 4)
    )


def _clouds(draw: Draw) -> Question:
    size = draw.whole(2, 4)
    return draw.normal(draw.whole(2, 6), size), draw.normal(draw.whole(2, 6), size)


def _gaussians(draw: Draw, logarithm: bool) -> Question:
    shape = *_episodes(draw), draw.whole(1, 4)
    spread = draw.normal(*shape) if logarithm else draw.normal(*shape).abs() + 0.1
    return draw.leaf(*shape), spread.requires_grad_(), draw.normal(*shape)


def _rise(draw: Draw) -> Question:
    level = (0.0, 20.0)[draw.whole(0, 2)]
    return level + draw.random.normal(size=draw.whole(10, 60)), draw.between(1.0, 6.0)


QUESTIONS: dict[str, Callable[[Draw], Question]] = {
    "log_density": lambda draw: _gaussians(draw, True),
    "discounted_returns": lambda draw: (draw.normal(*_episodes(draw)), draw.between(0.3, 1)),
    "reinforce_loss": _shaped("leaf", "normal", "mask"),
    "advantages": lambda draw: (
        *_shaped("normal", "normal")(draw), draw.between(0.3, 1), draw.between(0.2, 1)
    ),
    "point_step": _step,
    "loitering_gain": lambda draw: (draw.whole(0, 100), draw.between(0.3, 1)),
    "wheeled_step": _wheels,
    "episodes_needed": lambda draw: (draw.between(0.01, 0.9), draw.between(0.1, 0.99)),
    "with_task": _tasks,
    "steps_before_reward": _cut,
    "nearest_distance": _clouds,
    "visitation": _world,
    "performance_difference": _policies,
    "assumption_numbers": _assumption,
    "likelihood_distance": _pinsker,
    "meta_gradient": _meta,
    "conjugate_gradient": _target,
    "full_step": _vector,
    "supervised_meta_loss": _meta_loss,
    "adaptation_step": _adaptation,
    "warm_start_step": _adaptation,
    "surrogate": _shaped("leaf", "normal", "normal", "mask"),
    "interquartile_mean": lambda draw: (_scores(draw),),
    "late_rise": _rise,
    "one_at_a_time": _plan,
    "seed_differences": _dicts,
    "averaged_log_density": lambda draw: _gaussians(draw, False),
}  # fmt: skip


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
    name: str, function: Callable[..., Any], solution: Callable[..., Any], many: int = 25
) -> bool:
    """Return whether a function answers ``many`` random questions as the solution does."""
    for seed in range(1000, 1000 + many):
        question = QUESTIONS[name](Draw(seed))
        try:
            seen = _seen(function, question)
        except Exception:
            return False
        if not _alike(list(seen), list(_seen(solution, question))):
            return False
    return True

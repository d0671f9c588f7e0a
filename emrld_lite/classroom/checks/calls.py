"""How a check calls a student's function: with copies, and looking whether they were changed."""

from __future__ import annotations

import inspect
from typing import Any, NamedTuple

import numpy as np
import torch

from .answers import Student, Wrong


class Asked(NamedTuple):
    """What a function answered, and the very arguments that it was given."""

    answer: Any
    given: tuple[Any, ...]


def ask(student: Student, *arguments: Any) -> Asked:
    """Call the function with copies of the arguments; raise Wrong if it changes one of them."""
    given = tuple(_copied(argument) for argument in arguments)
    answer = student(*given)
    for place, (one, other) in enumerate(zip(given, arguments, strict=True)):
        if not _equal(one, other):
            raise Wrong(
                f"you changed {_name(student, place)} in place. It belongs to the caller, who uses "
                "it again: compute a new one from it."
            )
    return Asked(answer, given)


def _name(student: Student, place: int) -> str:
    try:
        return f"`{list(inspect.signature(student).parameters)[place]}`"
    except (TypeError, ValueError, IndexError):
        return "an argument"


def _copied(value: Any) -> Any:
    if isinstance(value, torch.Tensor):
        return value.detach().clone().requires_grad_(value.requires_grad)
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, dict):
        return {key: _copied(part) for key, part in value.items()}
    if isinstance(value, tuple | list):
        return type(value)(_copied(part) for part in value)
    return value


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, torch.Tensor):
        same = (one == other) | (one.isnan() & other.isnan()) if one.shape == other.shape else None
        return same is not None and bool(same.all())
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if isinstance(one, dict):
        return list(one) == list(other) and all(_equal(one[key], other[key]) for key in other)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(_equal, one, other))
    return one is other or bool(one == other)

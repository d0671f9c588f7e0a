"""What every check shares: how it answers, and how it looks at what a student returns.

A check compares with its own reference on random inputs and answers in a sentence. It never trusts
the student's objects and never changes them. It raises nothing: the answer is printed, and returned
as True or False.
"""

from __future__ import annotations

import functools
import math
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np
import torch

Student = Callable[..., Any]


class Wrong(Exception):
    """A wrong answer, with the sentence that says so."""


def answered(check: Callable[[Student], None]) -> Callable[[Student], bool]:
    """Turn a check that raises Wrong into one that prints its verdict and returns it."""

    @functools.wraps(check)
    def verdict(student: Student) -> bool:
        try:
            check(student)
        except Wrong as wrong:
            print(f"Not yet: {wrong}")
            return False
        except NotImplementedError:
            print("Not yet: the function is still blank. Replace `raise NotImplementedError`.")
            return False
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            print(
                f"Not yet: your function stopped with {type(error).__name__}: {error} "
                f"(line: {where.line})"
            )
            return False
        print(f"Correct: {check.__name__.replace('_', ' ')}.")
        return True

    return verdict


def as_tensor(value: Any, shape: tuple[int, ...], what: str) -> torch.Tensor:
    """Return the student's value if it is a tensor of ``shape``; otherwise raise Wrong."""
    return _of_shape(value, torch.Tensor, "a tensor", shape, what).detach().double()


def as_array(value: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    """Return the student's value if it is a numpy array of ``shape``; otherwise raise Wrong."""
    return _of_shape(value, np.ndarray, "an array", shape, what)


def _of_shape(value: Any, kind: type, called: str, shape: tuple[int, ...], what: str) -> Any:
    _given(value, what)
    if not isinstance(value, kind):
        raise Wrong(f"expected {what} as {called}, got {type(value).__name__}.")
    if value.shape != shape:
        raise Wrong(f"expected {what} of shape {tuple(shape)}, got {tuple(value.shape)}.")
    return value


def _given(value: Any, what: str) -> None:
    if value is None:
        raise Wrong(f"your function returned None. Does it end with `return`? Expected {what}.")


def as_number(value: Any, what: str) -> float:
    """Return the student's value if it is a finite number; otherwise raise Wrong."""
    _given(value, what)
    if isinstance(value, str) or np.ndim(value) != 0:
        raise Wrong(f"expected {what}, got {type(value).__name__}.")
    number = float(value)
    if not math.isfinite(number):
        raise Wrong(f"expected {what}, got {number}.")
    return number


def close(one: torch.Tensor, other: torch.Tensor, tolerance: float = 1e-6) -> bool:
    """Return whether two tensors of one shape agree to ``tolerance``, relative to their size."""
    scale = max(1.0, float(other.abs().max()))
    return bool(torch.isfinite(one).all()) and float((one - other).abs().max()) <= tolerance * scale


def draws(seed: int) -> Callable[..., torch.Tensor]:
    """Return a function that draws standard normal float64 tensors."""
    random = torch.Generator().manual_seed(seed)
    return lambda *shape: torch.randn(*shape, generator=random, dtype=torch.float64)

"""How a check reads what a function returned, of whatever type, and compares it.

Right numbers are right as a tensor of any precision, an array, a list, a tuple or a plain number.
"""

from __future__ import annotations

import numbers
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import torch

from .answers import Wrong

TOLERANCE = 1e-4  # of the largest number: single precision gets within a hundredth of it


def as_graph(value: Any, shape: tuple[int, ...], what: str) -> torch.Tensor:
    """Return the value as a tensor of ``shape`` that still carries gradients; else raise Wrong."""
    tensor = _tensor(value, what)
    if shape == () and tensor.numel() == 1:
        tensor = tensor.reshape(())
    if tensor.shape != shape:
        raise Wrong(f"expected {what}, of shape {tuple(shape)}, got {tuple(tensor.shape)}.")
    if not bool(torch.isfinite(tensor).all()):
        raise Wrong(
            f"expected {what}, got numbers that are not finite (nan or inf): is there a division "
            "by zero, or a root or logarithm of something negative?"
        )
    return tensor


def as_tensor(value: Any, shape: tuple[int, ...], what: str) -> torch.Tensor:
    """Return the value as a float64 tensor of ``shape`` without gradients; else raise Wrong."""
    return as_graph(value, shape, what).detach().double()


def as_number(value: Any, what: str) -> float:
    """Return the value as a finite number, whatever holds it; otherwise raise Wrong."""
    return float(as_tensor(value, (), what))


def as_parts(value: Any, count: int, what: str) -> Sequence[Any]:
    """Return a tuple, list or array of ``count`` parts; otherwise raise Wrong."""
    _given(value, what)
    if isinstance(value, str) or not hasattr(value, "__len__") or isinstance(value, Mapping):
        raise Wrong(f"expected {what}, got {type(value).__name__}.")
    if not isinstance(value, tuple | list) and np.ndim(value) == 0:
        raise Wrong(f"expected {what}, got a single number.")
    if len(value) != count:
        raise Wrong(f"expected {what}, got {len(value)}.")
    return value


def _given(value: Any, what: str) -> None:
    if value is None:
        raise Wrong(f"your function returned None. Does it end with `return`? Expected {what}.")


def _tensor(value: Any, what: str) -> torch.Tensor:
    _given(value, what)
    if isinstance(value, numbers.Real) and not isinstance(value, np.generic):
        value = torch.tensor(float(value), dtype=torch.float64)  # a Fraction, too
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "biufc":
        value = torch.as_tensor(np.array(value))
    if isinstance(value, list | tuple) and value:
        parts = [_tensor(part, what) for part in value]
        if len({part.shape for part in parts}) > 1:
            raise Wrong(f"expected {what}, got a {type(value).__name__} of several shapes.")
        value = torch.stack([part.double() for part in parts])
    if not isinstance(value, torch.Tensor):
        raise Wrong(f"expected {what}, got {type(value).__name__}.")
    if value.is_complex():
        raise Wrong("your numbers are complex; the ones asked for are real.")
    return value


def close(one: torch.Tensor, other: torch.Tensor, tolerance: float = TOLERANCE) -> bool:
    """Return whether two tensors of one shape agree to ``tolerance``, relative to their size."""
    if one.shape != other.shape or one.numel() == 0:
        return one.shape == other.shape
    scale = max(0.1, float(other.detach().abs().max()))
    gap = (one.detach().double() - other.detach().double()).abs().max()
    return bool(torch.isfinite(gap)) and float(gap) <= tolerance * scale


def judge(
    value: torch.Tensor,
    expected: torch.Tensor,
    mistakes: Mapping[str, torch.Tensor],
    otherwise: str,
    tolerance: float = TOLERANCE,
) -> None:
    """Raise Wrong unless the value is the expected one, with the sentence of the mistake it equals."""
    if close(value, expected, tolerance):
        return
    for sentence, mistaken in mistakes.items():
        if not close(expected, mistaken, tolerance) and close(value, mistaken, tolerance):
            raise Wrong(sentence)
    raise Wrong(otherwise)


def pulled_back(
    output: torch.Tensor, leaf: torch.Tensor, weights: torch.Tensor, cut: str
) -> torch.Tensor:
    """Return the gradient of ``weights`` times the output by the leaf; raise Wrong(cut) if none."""
    if not output.requires_grad:
        raise Wrong(cut)
    weighted = (output * weights.to(output.dtype)).sum()
    (gradient,) = torch.autograd.grad(weighted, leaf, retain_graph=True, allow_unused=True)
    if gradient is None:
        raise Wrong(cut)
    return gradient.double()


def draws(seed: int, dtype: torch.dtype = torch.float64) -> Callable[..., torch.Tensor]:
    """Return a function that draws standard normal tensors."""
    random = torch.Generator().manual_seed(seed)
    return lambda *shape: torch.randn(*shape, generator=random, dtype=torch.float64).to(dtype)


def episode_mask(episodes: int, horizon: int, seed: int, dtype: torch.dtype) -> torch.Tensor:
    """Return a mask (episode, time) of ragged episodes: a whole one, a short one, random ones."""
    random = torch.Generator().manual_seed(seed)
    lengths = torch.randint(1, horizon, (episodes,), generator=random)
    lengths[0] = horizon
    return (torch.arange(horizon) < lengths[:, None]).to(dtype)


def agree(ours: Any, package: Any, tolerance: float = TOLERANCE) -> bool:
    """Return whether a student's numbers equal the package's, whatever types hold them.

    The cells after a check compare by this, so that a right answer in another precision, as a list
    or as an array is right there, too; anything that is not numbers of the same shape is not equal.
    """
    try:
        theirs = _tensor(package, "numbers")
        return close(as_tensor(ours, tuple(theirs.shape), "numbers"), theirs, tolerance)
    except Wrong:
        return False

"""Checks at the door: every refusal says what was expected, what came, and where."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TypeVar

import torch

Value = TypeVar("Value")


class InputError(ValueError):
    """Input that cannot be used; the message names the field, the expectation and the value."""


def check_choice(kind: str, name: str, names: Iterable[str]) -> str:
    """Return ``name`` if it is one of ``names``; otherwise raise InputError with the nearest one."""
    choices = sorted(names)
    if name in choices:
        return name
    nearest = difflib.get_close_matches(str(name).lower(), choices, n=1, cutoff=0.3)
    hint = f" Did you mean {nearest[0]!r}?" if nearest else ""
    raise InputError(f"unknown {kind} {name!r}; known: {', '.join(choices)}.{hint}")


def lookup(kind: str, name: str, table: Mapping[str, Value]) -> Value:
    """Return ``table[name]``; an unknown name raises InputError with the nearest known one."""
    return table[check_choice(kind, name, table)]


def positive_count(field: str, value: int, minimum: int = 1) -> int:
    """Return a whole number of at least ``minimum``; anything else raises InputError."""
    if isinstance(value, bool) or not isinstance(value, int) or value < minimum:
        raise InputError(f"{field}: expected a whole number of at least {minimum}, got {value!r}")
    return value


def real_number(
    field: str, value: float, minimum: float = -math.inf, maximum: float = math.inf
) -> float:
    """Return a finite number in ``[minimum, maximum]``; anything else raises InputError."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{field}: expected a finite number, got {value!r}")
    if not minimum <= value <= maximum:
        raise InputError(f"{field}: expected {minimum} to {maximum}, got {value!r}")
    return value


def shaped(field: str, tensor: torch.Tensor, shape: tuple[int | str, ...]) -> torch.Tensor:
    """Return a finite tensor of ``shape`` (a word stands for any size); otherwise raise InputError."""
    fits = len(tensor.shape) == len(shape) and all(
        isinstance(want, str) or want == size
        for want, size in zip(shape, tensor.shape, strict=True)
    )
    if not fits:
        expected = ", ".join(str(size) for size in shape)
        raise InputError(f"{field}: expected shape ({expected}), got {tuple(tensor.shape)}")
    if not torch.isfinite(tensor).all():
        first = tuple((~torch.isfinite(tensor)).nonzero()[0].tolist())
        raise InputError(f"{field}: a value that is not finite at index {first}")
    return tensor


def ends_in(field: str, path: Path, suffix: str) -> Path:
    """Return a path whose name ends in ``suffix``; another raises InputError."""
    if path.suffix != suffix:
        raise InputError(f"{field}: expected a file name ending in {suffix}, got {str(path)!r}")
    return path


def usable_device(device: str) -> str:
    """Return ``cpu``, or ``cuda`` where torch finds such a device; anything else raises InputError."""
    check_choice("device", device, ("cpu", "cuda"))
    if device == "cuda" and not torch.cuda.is_available():
        raise InputError("device: expected cpu, since torch finds no CUDA device here; got 'cuda'")
    return device

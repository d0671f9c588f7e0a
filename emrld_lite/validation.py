"""Checks at the door: every refusal says what was expected, what came, and where."""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TypeVar

import torch

Value = TypeVar("Value")
LONGEST = 1500  # characters of a message
LARGEST_COUNT = 2**31 - 1
LARGEST_REAL = sys.float_info.max
LARGEST_SEED = 2**63 - 2  # torch and numpy both take it, and the number after it


class InputError(ValueError):
    """Input that cannot be used; the message names the field, the expectation and the value, in one line."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


def one_line(message: str) -> str:
    """Return a message as one printable line, its middle cut where it is very long."""
    words = " ".join(str(message).split())
    line = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in words)
    return line if len(line) <= LONGEST else f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"


def shown(value: object) -> str:
    """Return a value as a message shows it: its repr, or its kind where that is too long or too deep."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # thousands of digits, or nested too deep
        return f"a value of type {type(value).__name__} too large to print"
    return text if len(text) <= 200 else f"{text[:90]} ... {text[-90:]}"


def check_choice(kind: str, name: str, names: Iterable[str]) -> str:
    """Return ``name`` if it is one of ``names``; otherwise raise InputError with the nearest one."""
    choices = sorted(names)
    if isinstance(name, str) and name in choices:
        return name
    said = name if isinstance(name, str) else shown(name)
    nearest = difflib.get_close_matches(said[:50].lower(), choices, n=1, cutoff=0.3)
    hint = f" Did you mean {nearest[0]!r}?" if nearest else ""
    raise InputError(f"unknown {kind} {shown(name)}; known: {', '.join(choices)}.{hint}")


def lookup(kind: str, name: str, table: Mapping[str, Value]) -> Value:
    """Return ``table[name]``; an unknown name raises InputError with the nearest known one."""
    return table[check_choice(kind, name, table)]


def positive_count(field: str, value: int, minimum: int = 1, maximum: int = LARGEST_COUNT) -> int:
    """Return a whole number in ``[minimum, maximum]``; anything else raises InputError."""
    whole = isinstance(value, int) and not isinstance(value, bool)
    if not whole or value < minimum:
        raise InputError(
            f"{field}: expected a whole number of at least {minimum}, got {shown(value)}"
        )
    if value > maximum:
        raise InputError(
            f"{field}: expected a whole number of at most {maximum}, got {shown(value)}"
        )
    return value


def seed_number(field: str, value: int) -> int:
    """Return a number that can seed every generator; anything else raises InputError."""
    return positive_count(field, value, minimum=0, maximum=LARGEST_SEED)


def real_number(
    field: str, value: float, minimum: float = -math.inf, maximum: float = math.inf
) -> float:
    """Return a finite number in ``[minimum, maximum]``; anything else raises InputError."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not -LARGEST_REAL <= value <= LARGEST_REAL:  # a comparison with nan is false
        raise InputError(f"{field}: expected a finite number, got {shown(value)}")
    if not minimum <= value <= maximum:
        raise InputError(f"{field}: expected {minimum} to {maximum}, got {value!r}")
    return value


def whole_number(field: str, cell: str | None, minimum: int = 0) -> int:
    """Return the whole number that a text says in digits; anything else raises InputError."""
    if cell is None or not (cell.isascii() and cell.isdigit() and len(cell) < 20):
        raise InputError(f"{field}: expected a whole number, got {shown(cell)}")
    return positive_count(field, int(cell), minimum, maximum=LARGEST_SEED)


def number(field: str, cell: str, finite: bool = True) -> float:
    """Return the number that a text says; anything else raises InputError."""
    try:
        value = float(cell)
    except ValueError:
        raise InputError(f"{field}: expected a number, got {shown(cell)}") from None
    if finite and not math.isfinite(value):
        raise InputError(f"{field}: expected a finite number, got {shown(cell)}")
    return value


def true_or_false(field: str, value: bool) -> bool:
    """Return a boolean; anything else, also a text or a 0, raises InputError."""
    if not isinstance(value, bool):
        raise InputError(f"{field}: expected true or false, got {shown(value)}")
    return value


def text(field: str, value: str) -> str:
    """Return a text that is not empty; anything else raises InputError."""
    if not isinstance(value, str) or not value.strip():
        raise InputError(f"{field}: expected a text, got {shown(value)}")
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
    if Path(path).suffix != suffix:
        raise InputError(f"{field}: expected a file name ending in {suffix}, got {str(path)!r}")
    return path


def usable_device(device: str) -> str:
    """Return ``cpu``, or ``cuda`` where torch finds such a device; anything else raises InputError."""
    check_choice("device", device, ("cpu", "cuda"))
    if device == "cuda" and not torch.cuda.is_available():
        raise InputError("device: expected cpu, since torch finds no CUDA device here; got 'cuda'")
    return device

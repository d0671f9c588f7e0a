"""Where the seconds of an iteration go: named sections that add up, for ``bench`` to read."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

import torch

seconds: Counter[str] = Counter()


@contextmanager
def section(name: str) -> Iterator[None]:
    """Add the wall-clock time of the block to ``seconds[name]``; sections are not nested."""
    start = _now()
    try:
        yield
    finally:
        seconds[name] += _now() - start


def _now() -> float:
    if torch.cuda.is_initialized():
        torch.cuda.synchronize()
    return time.perf_counter()

"""A time limit for a student's function that does not end.

In the main thread, where a notebook runs its cells, the operating system's timer interrupts it; one
long call into a library is interrupted only when it returns. In any other thread, and on Windows,
which has no such timer, a trace function looks at the clock before every line of Python.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType
from typing import Any


class TimeUp(BaseException):
    """The time is up; not an Exception, so that an answer's own `except Exception` lets it pass."""


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise TimeUp in the block when it takes longer than ``seconds``."""
    main = threading.current_thread() is threading.main_thread()
    with _alarm(seconds) if main and hasattr(signal, "setitimer") else _watch(seconds):
        yield


@contextlib.contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    armed = True

    def ring(*_: Any) -> None:
        if armed:
            raise TimeUp

    handler = signal.signal(signal.SIGALRM, ring)
    # It rings again and again: an answer's bare `except:` may swallow the first.
    before, started = signal.setitimer(signal.ITIMER_REAL, seconds, 1.0), time.monotonic()
    try:
        yield
    finally:
        armed = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, handler)
        if before[0]:  # somebody else's timer goes on where it would be
            left = max(before[0] - (time.monotonic() - started), 1e-3)
            signal.setitimer(signal.ITIMER_REAL, left, before[1])


@contextlib.contextmanager
def _watch(seconds: float) -> Iterator[None]:
    end = time.monotonic() + seconds

    def look(*_: FrameType | str | None) -> Any:
        if time.monotonic() > end:
            raise TimeUp
        return look

    before = sys.gettrace()
    sys.settrace(look)
    try:
        yield
    finally:
        sys.settrace(before)

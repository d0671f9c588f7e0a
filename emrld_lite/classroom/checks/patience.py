"""A time limit for a student's function that does not end, in seconds of the processor.

A right answer is not refused because the machine is busy with other things: the wall clock alone ends a
function, one that waits, only at WAITING times the limit.

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
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

WAITING = 6.0
AGAIN = 0.25  # seconds of the wall clock between two looks


class TimeUp(BaseException):
    """The time is up; not an Exception, so that an answer's own `except Exception` lets it pass."""


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise TimeUp in the block when it takes longer than ``seconds``."""
    main = threading.current_thread() is threading.main_thread()
    over = _limit(seconds)
    with _alarm(seconds, over) if main and hasattr(signal, "setitimer") else _watch(over):
        yield


def _limit(seconds: float) -> Callable[[], bool]:
    """Return a function that says whether the time, which begins now, is up."""
    worked, waited = time.process_time() + seconds, time.monotonic() + WAITING * seconds
    return lambda: time.process_time() > worked or time.monotonic() > waited


@contextlib.contextmanager
def _alarm(seconds: float, over: Callable[[], bool]) -> Iterator[None]:
    armed = True

    def ring(*_: Any) -> None:
        if armed and over():
            raise TimeUp

    handler = signal.signal(signal.SIGALRM, ring)
    # It rings again and again: until the time is up, and since a bare `except:` may swallow the first.
    before, started = signal.setitimer(signal.ITIMER_REAL, seconds, AGAIN), time.monotonic()
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
def _watch(over: Callable[[], bool]) -> Iterator[None]:
    def look(*_: FrameType | str | None) -> Any:
        if over():
            raise TimeUp
        return look

    before = sys.gettrace()
    sys.settrace(look)
    try:
        yield
    finally:
        sys.settrace(before)

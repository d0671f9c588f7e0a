"""A live training that gives way to a stored run where the machine is too busy for it."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from ..experiments.runs import load_run
from ..policy import Params
from ..train import Iterate, Record
from ..validation import positive_count, real_number

PATIENCE = 8.0  # minutes that a reader waits for a live training
FEW = 3  # iterations that say how fast this machine is


class Seen(NamedTuple):
    """What a reader sees of one iteration."""

    meta_params: Params
    """After a live iteration its policy; of a stored run the last one."""
    record: Record
    """Its line of the curve."""


def while_it_is_quick(
    iterates: Iterable[Iterate],
    stored: Path,
    usual: int,
    minutes: float = PATIENCE,
    clock: Callable[[], float] = time.perf_counter,
) -> Iterator[Seen]:
    """Yield a live training; once ``usual`` iterations would take over ``minutes``, a stored run's rest.

    A printed sentence says so. Twenty readers on one small server then wait minutes, not an hour.
    """
    positive_count("usual", usual)
    real_number("minutes", minutes, minimum=0.0)
    before, seconds = clock(), list[float]()
    for iterate in iterates:
        yield Seen(iterate.meta_params, iterate.record)
        now = clock()
        seconds.append(now - before)
        before = now
        pace, left = statistics.median(seconds), max(0, usual - len(seconds))
        if len(seconds) >= FEW and sum(seconds) + pace * left > 60.0 * minutes:
            yield from _rest(stored, iterate.record.iteration, pace, pace * left / 60.0)
            return


def _rest(stored: Path, done: int, pace: float, minutes: float) -> Iterator[Seen]:
    """Say that a stored run takes over, and yield what it did after iteration ``done``."""
    run = load_run(stored)
    print(
        f"This machine is busy: an iteration takes {pace:.0f} s, so about {minutes:.0f} minutes are left. "
        f"From here on you see a stored run of the same training ({stored.name}). A larger `minutes` waits."
    )
    for record in run.curve[done + 1 :]:
        yield Seen(run.meta_params, record)

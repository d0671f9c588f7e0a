"""A Dask cluster on this machine, closed to everyone else on it."""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

from distributed import Nanny, Scheduler, SpecCluster, Worker
from distributed.security import Security


class _NoHttp:
    """A Dask server without the HTTP server that each one starts, open to everyone on the machine."""

    def start_http_server(self, *_: object, **__: object) -> None:
        """Start none."""


class LocalScheduler(_NoHttp, Scheduler):
    """A scheduler that is reached by TLS alone."""


class LocalWorker(_NoHttp, Worker):
    """A worker that is reached by TLS alone."""


def local_cluster(workers: int) -> SpecCluster:
    """Return a cluster on this machine whose every port asks for a certificate made for it alone.

    Any client of a Dask scheduler can run code on it; so other users of the machine must be none.
    """
    security = Security.temporary()
    common = {"host": "127.0.0.1", "protocol": "tls://", "security": security}
    work = {
        "nthreads": 1,
        "memory_limit": 0,
        "worker_class": LocalWorker,
        "silence_logs": logging.CRITICAL,
    }
    worker = {"cls": Nanny, "options": {**common, **work}}
    scheduler = {"cls": LocalScheduler, "options": {**common, "dashboard": False, "port": 0}}
    with _deaf():
        return SpecCluster(
            scheduler=scheduler,
            workers=dict.fromkeys(range(workers), worker),
            security=security,
            silence_logs=logging.CRITICAL,
        )


@contextmanager
def _deaf() -> Iterator[None]:
    """Keep Ctrl-C for later, and for good from the processes that begin here.

    At a terminal it reaches the workers too; they are told by the sweep that began them.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # else it begins here, and lets signals through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

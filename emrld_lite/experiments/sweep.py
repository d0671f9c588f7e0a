"""Sweeps: the runs of a grid on Dask workers, each run one folder that is there whole or not at all."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import torch
from distributed import Client, Future
from filelock import FileLock
from tqdm import tqdm

from ..config import TrainConfig
from ..limits import cores, readable_time
from ..storage import check_target
from ..validation import InputError, positive_count
from . import runs
from .budget import seconds_per_iteration
from .checkpoints import CHECKPOINT_EVERY, forget_memory, train_run
from .cluster import local_cluster
from .evaluation import evaluate_run, testing_demonstrations, write_evaluation
from .grid import command_of

POLL = 1.0  # seconds between two looks at the workers
PATIENCE = 10.0  # seconds in which a scheduler must answer
RETRIES = 2  # of a run that failed by an error; a lost worker's run is always taken up again
LOST = ("cancelled", "lost")


class Outcome(NamedTuple):
    """What a sweep did."""

    made: list[str]
    """Names of the runs that were made now."""
    kept: list[str]
    """Names of the runs that had been there already."""
    failed: dict[str, str]
    """Names of the runs that failed, with their errors."""


def partial_folder(folder: Path) -> Path:
    """Return where a run lives until it is finished."""
    return folder.parent / f".{folder.name}.partial"


def is_shorter(folder: Path, config: TrainConfig) -> bool:
    """Return whether a finished run differs from ``config`` only in that it has fewer iterations."""
    held = runs.load_config(folder)
    changed = runs.differences(config, held)
    return changed == ["iterations"] and held.iterations < config.iterations


def make_run(config: TrainConfig, folder: str, checkpoint_every: int = CHECKPOINT_EVERY) -> str:
    """Make one run on a worker, or go on where a lost worker left it; returns its name.

    The run grows in a hidden folder beside its place, with a lock on it, so two workers never
    write one run; when it is trained and evaluated, the folder is renamed. A lost worker loses at
    most ``checkpoint_every`` iterations. A finished run with fewer iterations goes on.
    """
    torch.set_num_threads(1)  # one run a core: more threads would only wait for each other
    place = Path(folder)
    grown = partial_folder(place)
    place.parent.mkdir(parents=True, exist_ok=True)
    with _held(place):
        if place.exists() and is_shorter(place, config):
            os.replace(place, grown)
        if not place.exists():
            begun = (grown / "config.json").exists()
            command = command_of(config, f"data/runs/{place.name}")
            run = train_run(
                config, grown, resume=begun, command=command, checkpoint_every=checkpoint_every
            )
            shown = testing_demonstrations(run)
            write_evaluation(grown / "unseen.csv", shown, evaluate_run(run, shown))
            os.replace(grown, place)
    return place.name


@contextmanager
def _held(place: Path) -> Iterator[None]:
    """Keep other sweeps from the run whose finished folder is ``place`` while this one writes there."""
    lock = Path(f"{partial_folder(place)}.lock")
    with FileLock(lock):
        yield
        lock.unlink(missing_ok=True)


def sweep(
    grid: dict[str, TrainConfig],
    out: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    checkpoint_every: int = CHECKPOINT_EVERY,
    patience: float = PATIENCE,
    forget: bool = False,
) -> Outcome:
    """Make every run of ``grid`` that is not in ``out`` yet, or has fewer iterations there.

    On a local cluster of ``workers`` processes (by default one a core), or on the running Dask
    scheduler at the address ``scheduler``, whose workers must see the same files. Each run keeps a
    checkpoint after every ``checkpoint_every`` iterations; with ``forget`` the finished ones, those
    that had been there too, keep their policy without its learner's memory. Raises InputError when
    that scheduler does not answer within ``patience`` seconds or is lost for so long (the same call
    then goes on), and before any run when a folder holds a run with other settings than the grid's.
    """
    out = check_target("out", out, folder=True).resolve()
    kept = [
        name
        for name, config in grid.items()
        if (out / name).exists() and not is_shorter(out / name, config)
    ]
    for name in kept:
        if changed := runs.differences(grid[name], runs.load_config(out / name)):
            raise InputError(
                f"{out / name}: holds a run with other settings: {', '.join(changed)} differ; "
                "move it away, or change the grid"
            )
    missing = {name: config for name, config in grid.items() if name not in kept}
    failed = _make(missing, out, workers, scheduler, checkpoint_every, patience) if missing else {}
    made = [name for name in missing if name not in failed]
    for name in (*kept, *made) if forget else ():
        with _held(out / name):
            try:
                forget_memory(out / name)
            except (
                InputError
            ) as error:  # damage to one run: the others are thinned, and it is named
                failed[name] = str(error)
    return Outcome(made, kept, failed)


def _make(
    missing: dict[str, TrainConfig],
    out: Path,
    workers: int | None,
    scheduler: str | None,
    checkpoint_every: int,
    patience: float,
) -> dict[str, str]:
    """Make the missing runs on the workers; returns the errors of those that failed."""
    if scheduler is None:
        workers = positive_count(
            "workers",
            min(cores(), len(missing)) if workers is None else workers,
            maximum=4 * cores(),
        )
    print(announcement(missing, workers), flush=True)
    with quiet(), _client(workers, scheduler, patience) as client:
        futures = {
            name: client.submit(
                make_run, config, str(out / name), checkpoint_every, pure=False, retries=RETRIES
            )
            for name, config in missing.items()
        }
        return _watch(futures, missing, out)


def announcement(missing: dict[str, TrainConfig], workers: int | None) -> str:
    """Return how many runs there are to make, and about how long they take."""
    seconds = sum(
        config.iterations
        * seconds_per_iteration(config, len(config.environment().training_tasks()))
        for config in missing.values()
    )
    said = f"{len(missing)} runs to make, at the stored runs' pace about {readable_time(seconds)}"
    if workers is None:
        return f"{said} of one core's work"
    return f"{said} / {workers} workers = {readable_time(seconds / workers)}"


@contextmanager
def quiet() -> Iterator[None]:
    """Keep Dask and asyncio from telling of a lost scheduler: that is said in one line at the end."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


@contextmanager
def _client(workers: int | None, scheduler: str | None, patience: float) -> Iterator[Client]:
    """Yield a client of the scheduler at an address, or of a local cluster made for it."""
    if scheduler is not None:
        if workers is not None:
            raise InputError("workers: expected none with a running scheduler, which has its own")
        try:
            client = Client(scheduler, timeout=patience)
        except (OSError, ValueError) as error:
            raise InputError(f"scheduler: cannot reach {scheduler!r}: {error}") from error
        with client:
            yield client
        return
    with local_cluster(workers) as cluster, Client(cluster, security=cluster.security) as client:
        yield client


def _watch(futures: dict[str, Future], grid: dict[str, TrainConfig], out: Path) -> dict[str, str]:
    """Show the progress until every run is finished or failed; returns the errors by name."""
    total = sum(config.iterations for config in grid.values())
    failed: dict[str, str] = {}
    with tqdm(total=total, unit="iteration", desc=f"{len(grid)} runs") as bar:
        bar.n = bar.initial = sum(iterations_done(out / name) for name in grid)
        while True:
            states = {name: future.status for name, future in futures.items()}
            lost = [name for name, state in states.items() if state in LOST]
            if lost:
                raise InputError(
                    f"the scheduler was lost with {len(lost)} runs unfinished; the same command goes on"
                )
            for name, state in states.items():
                if state == "error" and name not in failed:
                    failed[name] = str(futures[name].exception())
            bar.n = sum(iterations_done(out / name) for name in grid)
            waiting = sum(state == "pending" for state in states.values())
            bar.set_postfix_str(f"{len(grid) - waiting} of {len(grid)} runs finished")
            if not waiting:
                return failed
            time.sleep(POLL)


def iterations_done(folder: Path) -> int:
    """Return how many iterations of a run are on disk; a finished one may be about to go on."""
    curve = (folder if folder.exists() else partial_folder(folder)) / "curve.csv"
    try:
        return max(0, curve.read_bytes().count(b"\n") - 1)
    except FileNotFoundError:
        return 0

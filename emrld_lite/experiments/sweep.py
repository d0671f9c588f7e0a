"""Sweeps: the runs of a grid on Dask workers, each run one folder that is there whole or not at all."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import torch
from distributed import Client, Future, LocalCluster
from filelock import FileLock
from tqdm import tqdm

from ..config import TrainConfig
from ..validation import InputError, positive_count
from . import runs
from .evaluation import evaluate_run, testing_demonstrations, write_evaluation
from .grid import command_of

POLL = 1.0  # seconds between two looks at the workers
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


def make_run(config: TrainConfig, folder: str) -> str:
    """Make one run on a worker, or go on where a lost worker left it; returns its name.

    The run grows in a hidden folder beside its place, with a lock on it, so two workers never
    write one run; when it is trained and evaluated, the folder is renamed.
    """
    torch.set_num_threads(1)  # one run a core: more threads would only wait for each other
    place = Path(folder)
    grown = partial_folder(place)
    place.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(f"{grown}.lock"):
        if not place.exists():
            begun = (grown / "config.json").exists()
            command = command_of(config, f"data/runs/{place.name}")
            run = runs.train_run(config, grown, resume=begun, command=command)
            shown = testing_demonstrations(run)
            write_evaluation(grown / "unseen.csv", shown, evaluate_run(run, shown))
            os.replace(grown, place)
        Path(f"{grown}.lock").unlink(missing_ok=True)
    return place.name


def sweep(
    grid: dict[str, TrainConfig],
    out: Path,
    workers: int | None = None,
    scheduler: str | None = None,
) -> Outcome:
    """Make every run of ``grid`` that is not in ``out`` yet.

    On a local cluster of ``workers`` processes (by default one a core), or on the running Dask
    scheduler at the address ``scheduler``, whose workers must see the same files. Raises
    InputError when that scheduler cannot be reached or is lost (the same call then goes on), and
    before any run when a folder holds a run with other settings than the grid's.
    """
    out = Path(out).resolve()
    kept = [name for name in grid if (out / name).exists()]
    for name in kept:
        if changed := runs.differences(grid[name], runs.load_config(out / name)):
            raise InputError(
                f"{out / name}: holds a run with other settings: {', '.join(changed)} differ; "
                "move it away, or change the grid"
            )
    missing = {name: config for name, config in grid.items() if name not in kept}
    if not missing:
        return Outcome([], kept, {})
    with _client(workers, scheduler) as client:
        futures = {
            name: client.submit(make_run, config, str(out / name), pure=False, retries=RETRIES)
            for name, config in missing.items()
        }
        failed = _watch(futures, missing, out)
    return Outcome([name for name in missing if name not in failed], kept, failed)


@contextmanager
def _client(workers: int | None, scheduler: str | None) -> Iterator[Client]:
    """Yield a client of the scheduler at an address, or of a local cluster made for it."""
    if scheduler is not None:
        if workers is not None:
            raise InputError("workers: expected none with a running scheduler, which has its own")
        try:
            client = Client(scheduler, timeout="10s")
        except (OSError, ValueError) as error:
            raise InputError(f"scheduler: cannot reach {scheduler!r}: {error}") from error
        with client:
            yield client
        return
    count = positive_count("workers", (os.cpu_count() or 1) if workers is None else workers)
    with (
        LocalCluster(
            n_workers=count, threads_per_worker=1, dashboard_address=None, memory_limit=0
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


def _watch(futures: dict[str, Future], grid: dict[str, TrainConfig], out: Path) -> dict[str, str]:
    """Show the progress until every run is finished or failed; returns the errors by name."""
    total = sum(config.iterations for config in grid.values())
    failed: dict[str, str] = {}
    with tqdm(total=total, unit="iteration", desc=f"{len(grid)} runs") as bar:
        bar.n = bar.initial = sum(iterations_done(out / name, grid[name]) for name in grid)
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
            bar.n = sum(iterations_done(out / name, grid[name]) for name in grid)
            waiting = sum(state == "pending" for state in states.values())
            bar.set_postfix_str(f"{len(grid) - waiting} of {len(grid)} runs finished")
            if not waiting:
                return failed
            time.sleep(POLL)


def iterations_done(folder: Path, config: TrainConfig) -> int:
    """Return how many iterations of a run are on disk."""
    if folder.exists():
        return config.iterations
    curve = partial_folder(folder) / "curve.csv"
    try:
        return max(0, curve.read_bytes().count(b"\n") - 1)
    except FileNotFoundError:
        return 0

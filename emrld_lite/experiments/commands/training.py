"""The commands that train: one run, the runs of a grid, one run under many seeds."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Literal

import tyro
from tqdm import tqdm

from ...config import TrainConfig
from ...demonstrations import load_demonstrations
from ...limits import thread_count
from ...storage import check_target
from ...train import Iterate
from ...validation import ends_in, positive_count, seed_number, usable_device
from .. import budget, machine, reports
from .. import lottery as lotteries
from ..checkpoints import train_run
from ..grid import load_grid

MOST_SEEDS = 1000


def train(
    config: tyro.conf.OmitArgPrefixes[TrainConfig],
    out: Path,
    resume: bool = False,
    threads: int | None = None,
    device: Literal["cpu", "cuda"] = "cpu",
) -> None:
    """Meta-train and store the run: config.json, curve.csv, policy.safetensors, provenance.json.

    Args:
        config: everything that decides the run
        out: folder of the run
        resume: go on with a run that was stopped or killed
        threads: CPU threads; by default those of the resumed run, else 2 where that is faster than 1
        device: where torch computes
    """
    usable_device(device)
    check_target("out", out, folder=True)
    machine.use_threads(machine.stored_threads(out) if resume and threads is None else threads)
    tasks = len(load_demonstrations(config.demos, config.env).tasks)
    budget.check_training(config, tasks)
    if said := budget.announcement(config, tasks):
        print(said, flush=True)
    last: Iterate | None = None
    bar: tqdm | None = None

    def show(iterate: Iterate) -> None:
        nonlocal last, bar
        last = iterate
        if bar is None:  # not before an error, which then has the one line for itself
            bar = tqdm(total=config.iterations, unit="iteration", desc=config.algorithm)
        bar.n = iterate.record.iteration + 1
        bar.set_postfix_str(f"return {iterate.record.return_after:.1f}")

    try:
        run = train_run(config, out, resume, device, show)
    except KeyboardInterrupt as stop:
        begun = (out / "config.json").exists()
        stop.args = (f"{out} is whole: go on with the same command and --resume",) * begun
        raise
    finally:
        if bar is not None:
            bar.close()
    reports.print_run(out, run, last)


def sweep(
    grid: tyro.conf.Positional[Path],
    out: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    forget: bool = False,
) -> None:
    """Make every run of a grid that is not there yet, on local workers or a running Dask scheduler.

    Args:
        grid: TOML file of [[runs]] blocks; an option of train is a value or a list of values
        out: folder for the runs
        workers: local worker processes, by default one per core
        scheduler: address of a running Dask scheduler, such as tcp://host:8786
        forget: leave out of finished runs what their learner remembers, half of a policy's file or more
    """
    from ..sweep import sweep as make_runs  # Dask is only needed here  # noqa: PLC0415

    try:
        outcome = make_runs(load_grid(grid), out, workers, scheduler, forget=forget)
    except KeyboardInterrupt as stop:
        stop.args = ("the same command goes on from the last checkpoints",)
        raise
    print(f"{out}: {len(outcome.made)} runs made, {len(outcome.kept)} were there already")
    for name, error in outcome.failed.items():
        print(f"failed: {name}: {error}", file=sys.stderr)
    if outcome.failed:
        sys.exit(1)


def lottery(
    config: tyro.conf.OmitArgPrefixes[TrainConfig],
    out: Path,
    folder: Path = Path("build/lottery"),
    seeds: int = 20,
    first_seed: int = 0,
    lots: tuple[str, ...] = ("own",),
    threads: tuple[int, ...] = (1,),
    workers: int = 1,
) -> None:
    """Train again and again, under other seeds and as on other processors, and table the iterations taken.

    Args:
        config: everything that decides a run but its seed; stop_at_return is 70 unless said
        out: table to write or to add to, .csv; what it holds already is not played again
        folder: where the runs grow; one that was stopped goes on
        seeds: how many seeds
        first_seed: the first of them
        lots: machines to play: own, plain (no vector kernels), compatible (MKL's), portable (both)
        threads: CPU threads to play
        workers: trainings at a time
    """
    ends_in("out", check_target("out", out), ".csv")
    check_target("folder", folder, folder=True)
    thread_count("workers", workers)
    positive_count("seeds", seeds, maximum=MOST_SEEDS)
    for count in threads:
        thread_count("threads", count)
    chosen = range(seed_number("first_seed", first_seed), first_seed + seeds)
    if config.stop_at_return is None:
        config = replace(config, stop_at_return=lotteries.TARGET)
    budget.check_training(config, len(load_demonstrations(config.demos, config.env).tasks))
    for draw in lotteries.lottery(config, chosen, lots, threads, out, folder, workers):
        took = draw.reached or f"not in {draw.budget}"
        print(f"lot {draw.lot}, {draw.threads} threads, seed {draw.seed}: {took}", flush=True)
    print(lotteries.summary(lotteries.load_draws(out)))

"""The commands: what each option means, checks before anything starts, what is printed at the end."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import torch
import tyro
from tqdm import tqdm

from .. import demonstrations as demonstration_files
from ..config import EnvironmentName, TrainConfig
from ..demonstrations import QualityName, load_demonstrations
from ..demonstrators import recipes
from ..demonstrators.expert import ExpertConfig, expert_config, save_expert
from ..envs import make
from ..evaluate import LATER_RATE
from ..limits import check_memory, readable_bytes, thread_count
from ..policy import Params
from ..storage import check_target
from ..train import Iterate
from ..validation import (
    InputError,
    ends_in,
    positive_count,
    real_number,
    seed_number,
    usable_device,
)
from . import bench as benchmark
from . import budget, evaluation, machine, paper_figures, reports, results, runs
from . import lottery as lotteries
from .grid import load_grid

LARGEST_NOISE = 10.0  # in units of the action's range, which is 2 wide
MOST_TIMED = 1000  # iterations of a measurement


def demos(
    env: EnvironmentName,
    quality: QualityName,
    out: Path,
    seed: int = 0,
    expert_out: Path | None = None,
    threads: int = 1,
    tasks: int | None = None,
    noise: float | None = None,
) -> None:
    """Make demonstrations with a goal-conditioned expert, one per task; by default train it anew.

    Args:
        env: environment of the tasks
        quality: optimal, or suboptimal (partly trained, noisy, beginning or end cut off)
        out: demonstration file to write, .npz
        seed: seed of the expert and of the demonstrations
        expert_out: where to keep the expert's policy too, .safetensors
        threads: CPU threads; the same number makes the same bytes
        tasks: let the workbook's own expert demonstrate so many tasks drawn at random
        noise: standard deviation of the noise added to each action, in place of the quality's own
    """
    _set_threads(threads)
    config = expert_config(env, seed_number("seed", seed))
    recipe = recipes.recipe_for(env, quality)
    if noise is not None:
        recipe = replace(recipe, action_noise=real_number("noise", noise, 0.0, LARGEST_NOISE))
    ends_in("out", check_target("out", out), ".npz")
    if expert_out is not None and tasks is None:
        ends_in("expert_out", check_target("expert_out", expert_out), ".safetensors")
    if tasks is None:
        wanted, expert = make(env).training_tasks(), _train_expert(config, quality)
    else:
        if expert_out is not None:
            raise InputError("expert_out: expected none with --tasks, which trains no expert")
        needed = budget.rollout_memory(make(env), positive_count("tasks", tasks), 1)
        check_memory(f"tasks: demonstrations of {tasks} tasks", needed)
        if needed > budget.NOTEWORTHY_BYTES:
            print(f"{tasks} demonstrations: about {readable_bytes(needed)} of memory", flush=True)
        wanted = make(env).test_tasks(tasks, np.random.default_rng(seed))
        expert = recipes.load_or_train_expert(env, quality)
    made = recipes.demonstrate(expert, env, wanted, quality, seed, recipe)
    demonstration_files.save(out, made)
    if expert_out is not None:
        save_expert(expert_out, expert, config, quality)
    print(f"{out}: {len(wanted)} {quality} demonstrations. {made.maker}")


def _train_expert(config: ExpertConfig, quality: str) -> Params:
    """Return the policy of a newly trained expert, with a bar that shows its progress."""
    with tqdm(total=config.iterations, unit="iteration", desc=f"{config.env} {quality}") as bar:
        for iterate in recipes.train_to_quality(config, quality):
            bar.set_postfix_str(f"success {iterate.success:.2f}")
            bar.update()
    return iterate.params


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
    _set_threads(machine.stored_threads(out) if resume and threads is None else threads)
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
        run = runs.train_run(config, out, resume, device, show)
    except KeyboardInterrupt as stop:
        begun = (out / "config.json").exists()
        stop.args = (f"{out} is whole: go on with the same command and --resume",) * begun
        raise
    finally:
        if bar is not None:
            bar.close()
    reports.print_run(out, run, last)


def evaluate(
    run: Path,
    out: Path,
    tasks: int = evaluation.UNSEEN_TASKS,
    steps: int = evaluation.STEPS,
    episodes: int = TrainConfig.episodes,
    seed: int = 0,
    demos: str | None = None,
    later_rate: float = LATER_RATE,
    threads: int = 1,
) -> None:
    """Adapt a stored meta-policy to unseen tasks, one demonstration each, fresh rollouts per step.

    Args:
        run: folder of a stored run
        out: table to write, .csv: task, goal, step, return, success, steps_to_goal
        tasks: number of unseen tasks
        steps: adaptation steps; the table has steps 0 (the meta-policy) to this
        episodes: episodes per task and step
        seed: seed of the tasks and of every draw
        demos: a demonstration file with test tasks; by default the workbook's expert makes them
        later_rate: length of the steps after the first, which training knows, in units of the first
        threads: CPU threads
    """
    _set_threads(threads)
    ends_in("out", check_target("out", out), ".csv")
    positive_count("tasks", tasks)
    positive_count("steps", steps, minimum=0)
    positive_count("episodes", episodes)
    seed_number("seed", seed)
    stored = runs.load_run(run)
    world = stored.config.environment()
    if demos is None:
        budget.check_evaluation(world, tasks, steps, episodes)
        demonstrations = evaluation.testing_demonstrations(stored, tasks, seed)
    else:
        demonstrations = demonstration_files.load(Path(demos), stored.config.env)
        budget.check_evaluation(world, len(demonstrations.tasks), steps, episodes)
    curve = evaluation.evaluate_run(stored, demonstrations, steps, episodes, seed, later_rate)
    evaluation.write_evaluation(out, demonstrations, curve)
    reports.print_evaluation(stored, curve, demonstrations.tasks)
    print(f"{out}: every task and step")


def bench(
    iterations: int = 5,
    threads: int | None = None,
    tasks: tuple[int, ...] = (12, 24, 48, 96),
    walk: bool = False,
) -> None:
    """Measure seconds per meta-iteration by part, steps per second, memory, growth, MuJoCo's overhead.

    Args:
        iterations: meta-iterations to time, at full-length episodes
        threads: CPU threads; by default 2 where that is faster than 1
        tasks: numbers of tasks for the growth
        walk: print instead which functions one meta-iteration calls, in order, with file and line
    """
    if walk:
        print(*benchmark.walk(), sep="\n")
        return
    positive_count("iterations", iterations, maximum=MOST_TIMED)
    if not tasks:
        raise InputError("tasks: expected at least one number of tasks, got none")
    for count in tasks:
        budget.check_training(TrainConfig(), positive_count("tasks", count))
    _set_threads(threads)
    benchmark.report(iterations, tasks)
    benchmark.report_cheetah()


def figures(out: Path, runs_folder: Path = runs.SHIPPED) -> None:
    """Draw the paper's Figs. 2 to 8 from the stored runs, as PNG and SVG, and print their table.

    Args:
        out: folder for the figures
        runs_folder: folder of the stored runs, named like point2d-optimal-emrld-seed0
    """
    check_target("out", out, folder=True)
    results.check_runs(runs_folder)
    torch.set_num_threads(1)
    for path in paper_figures.draw(runs_folder, out):
        print(path)
    print(results.summary(runs_folder))


def sweep(
    grid: tyro.conf.Positional[Path],
    out: Path,
    workers: int | None = None,
    scheduler: str | None = None,
) -> None:
    """Make every run of a grid that is not there yet, on local workers or a running Dask scheduler.

    Args:
        grid: TOML file of [[runs]] blocks; an option of train is a value or a list of values
        out: folder for the runs
        workers: local worker processes, by default one per core
        scheduler: address of a running Dask scheduler, such as tcp://host:8786
    """
    from .sweep import sweep as make_runs  # Dask is only needed here  # noqa: PLC0415

    try:
        outcome = make_runs(load_grid(grid), out, workers, scheduler)
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
    positive_count("seeds", seeds, maximum=MOST_TIMED)
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


def _set_threads(threads: int | None) -> None:
    """Use ``threads``, or as many as are fastest; more than the machine has cores are refused."""
    chosen = machine.choose_threads() if threads is None else thread_count("threads", threads)
    torch.set_num_threads(chosen)


COMMANDS = (demos, train, evaluate, sweep, figures, bench, lottery)

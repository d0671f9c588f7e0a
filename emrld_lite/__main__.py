"""The command line: ``python -m emrld_lite --help``."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import torch
import tyro
from tqdm import tqdm

from . import demonstrations as demonstration_files
from .config import EnvironmentName, TrainConfig
from .demonstrations import QualityName
from .demonstrators import recipes
from .demonstrators.expert import ExpertConfig, expert_config, save_expert
from .envs import make
from .evaluate import LATER_RATE
from .experiments import bench as benchmark
from .experiments import evaluation, machine, paper_figures, reports, results, runs
from .experiments import lottery as lotteries
from .experiments.grid import load_grid
from .policy import Params
from .train import Iterate
from .validation import InputError, ends_in, positive_count, real_number, usable_device

DESCRIPTION = """EMRLD: meta reinforcement learning with demonstrations.

demos makes demonstrations, train meta-trains on them and stores the run, evaluate adapts a stored
run to unseen tasks, sweep makes the runs of a grid, figures draws the stored runs, bench measures
the cost, lottery trains under other seeds and as on other processors. Every command explains its
options with --help."""
INTERRUPTED = 130  # the shell's exit code for Ctrl-C


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
    _set_threads(threads, asked=threads)
    config = expert_config(env, seed)
    recipe = recipes.recipe_for(env, quality)
    if noise is not None:
        recipe = replace(recipe, action_noise=real_number("noise", noise, minimum=0.0))
    ends_in("out", out, ".npz")
    if tasks is None:
        wanted, expert = make(env).training_tasks(), _train_expert(config, quality)
    else:
        if expert_out is not None:
            raise InputError("expert_out: expected none with --tasks, which trains no expert")
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
    _set_threads(threads or (machine.stored_threads(out) if resume else None), asked=threads)
    usable_device(device)
    last: Iterate | None = None
    with tqdm(total=config.iterations, unit="iteration", desc=config.algorithm) as bar:

        def show(iterate: Iterate) -> None:
            nonlocal last
            last = iterate
            bar.n = iterate.record.iteration + 1
            bar.set_postfix_str(f"return {iterate.record.return_after:.1f}")

        try:
            run = runs.train_run(config, out, resume, device, show)
        except KeyboardInterrupt:
            bar.close()
            print(f"stopped; {out} is whole: go on with the same command and --resume")
            sys.exit(INTERRUPTED)
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
    _set_threads(threads, asked=threads)
    ends_in("out", out, ".csv")
    positive_count("tasks", tasks)
    stored = runs.load_run(run)
    if demos is None:
        demonstrations = evaluation.testing_demonstrations(stored, tasks, seed)
    else:
        demonstrations = demonstration_files.load(Path(demos), stored.config.env)
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
    _set_threads(threads, asked=threads)
    benchmark.report(positive_count("iterations", iterations), tasks)
    benchmark.report_cheetah()


def figures(out: Path, runs_folder: Path = runs.SHIPPED) -> None:
    """Draw the paper's Figs. 2 to 8 from the stored runs, as PNG and SVG, and print their table.

    Args:
        out: folder for the figures
        runs_folder: folder of the stored runs, named like point2d-optimal-emrld-seed0
    """
    torch.set_num_threads(1)
    for path in paper_figures.draw(runs_folder, out):
        print(path)
    print(results.summary(runs_folder))


def sweep(
    grid: tyro.conf.Positional[Path],
    out: Path = runs.SHIPPED,
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
    from .experiments.sweep import sweep as make_runs  # Dask is only needed here  # noqa: PLC0415

    outcome = make_runs(load_grid(grid), out, workers, scheduler)
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
    ends_in("out", out, ".csv")
    positive_count("workers", workers)
    positive_count("seeds", seeds)
    if config.stop_at_return is None:
        config = replace(config, stop_at_return=lotteries.TARGET)
    chosen = range(first_seed, first_seed + seeds)
    for draw in lotteries.lottery(config, chosen, lots, threads, out, folder, workers):
        took = draw.reached or f"not in {draw.budget}"
        print(f"lot {draw.lot}, {draw.threads} threads, seed {draw.seed}: {took}", flush=True)
    print(lotteries.summary(lotteries.load_draws(out)))


def _set_threads(threads: int | None, asked: int | None) -> None:
    """Use ``threads``, or as many as are fastest; refuse a number ``asked`` for that is no count."""
    if asked is not None:
        positive_count("threads", asked)
    torch.set_num_threads(threads or machine.choose_threads())


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; a refused input or an unwritable file exits with 2 and one line."""
    commands = {
        one.__name__: one for one in (demos, train, evaluate, sweep, figures, bench, lottery)
    }
    try:
        tyro.extras.subcommand_cli_from_dict(
            commands,
            prog="python -m emrld_lite",
            description=DESCRIPTION,
            args=arguments,
            config=(tyro.conf.FlagCreatePairsOff,),
        )
    except (InputError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()

"""The commands that measure: a stored run on unseen tasks, all of them in figures, and what a run costs."""

from __future__ import annotations

from pathlib import Path

import torch

from ... import demonstrations as demonstration_files
from ...config import TrainConfig
from ...evaluate import LATER_RATE
from ...storage import check_target
from ...validation import InputError, ends_in, positive_count, seed_number
from .. import budget, evaluation, machine, reports, results, runs

MOST_TIMED = 1000  # iterations of a measurement


def evaluate(
    run: Path,
    out: Path,
    tasks: int = evaluation.UNSEEN_TASKS,
    steps: int = evaluation.STEPS,
    episodes: int = TrainConfig.episodes,
    seed: int = 0,
    demos: str | None = None,
    later_rate: float = LATER_RATE,
    by_mean: bool = False,
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
        by_mean: test each policy by its mean action, in one episode; it adapts on sampled ones as ever
        threads: CPU threads
    """
    machine.use_threads(threads)
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
    if by_mean:
        curve = evaluation.acting_by_mean(stored, demonstrations, curve)
    evaluation.write_evaluation(out, demonstrations, curve)
    reports.print_evaluation(stored, curve, demonstrations.tasks)
    print(f"{out}: every task and step")


def figures(out: Path, runs_folder: Path = runs.SHIPPED) -> None:
    """Draw the paper's Figs. 2 to 8 from the stored runs, as PNG and SVG, and print their table.

    Args:
        out: folder for the figures
        runs_folder: folder of the stored runs, named like point2d-optimal-emrld-seed0
    """
    check_target("out", out, folder=True)
    results.check_runs(runs_folder)
    from .. import paper_figures  # matplotlib is only needed here  # noqa: PLC0415

    torch.set_num_threads(1)
    for path in paper_figures.draw(runs_folder, out):
        print(path)
    print(results.summary(runs_folder))


def bench(
    iterations: int = 5,
    threads: int | None = None,
    tasks: tuple[int, ...] = (12, 24, 48, 96),
    walk: bool = False,
) -> None:
    """Measure seconds per meta-iteration by part, steps per second, memory, growth, MuJoCo, the robot.

    Args:
        iterations: meta-iterations to time, at full-length episodes
        threads: CPU threads; by default 2 where that is faster than 1
        tasks: numbers of tasks for the growth
        walk: print instead which functions one meta-iteration calls, in order, with file and line
    """
    # MuJoCo is only needed here
    from .. import bench as benchmark  # noqa: PLC0415
    from .. import physics_bench  # noqa: PLC0415

    if walk:
        print(*benchmark.walk(), sep="\n")
        return
    positive_count("iterations", iterations, maximum=MOST_TIMED)
    if not tasks:
        raise InputError("tasks: expected at least one number of tasks, got none")
    for count in tasks:
        budget.check_training(TrainConfig(), positive_count("tasks", count))
    machine.use_threads(threads)
    benchmark.report(iterations, tasks)
    physics_bench.report_cheetah()
    physics_bench.report_robot()

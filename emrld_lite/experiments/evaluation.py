"""Stored runs on unseen tasks: which tasks, the adaptation curve, and its table in a file."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import torch

from ..adapt import cloning_loss, warm_start
from ..config import TrainConfig
from ..demonstrations import Demonstrations
from ..demonstrators.recipes import unseen_demonstrations
from ..evaluate import LATER_RATE, AdaptationCurve, adaptation_curve
from ..policy import per_task, without_noise
from ..rollout import PerTask, Rollout, collect, episode_returns
from ..storage import read_csv, write_csv
from ..validation import InputError, number, real_number, seed_number, whole_number
from .runs import Run

UNSEEN_TASKS, STEPS = 20, 3  # with which stored runs are tested
SAMPLED, BY_MEAN = "unseen.csv", "by_mean.csv"  # a run's table, as its policies act in the test
CUT = (
    "cut.csv"  # sampled, but shown the unseen drifts with the steering cut to what the robot can do
)
EVALUATION_COLUMNS = ("task", "goal", "step", "return", "success", "steps_to_goal")


def evaluate_run(
    run: Run,
    demonstrations: Demonstrations,
    steps: int = STEPS,
    episodes: int = TrainConfig.episodes,
    seed: int = 0,
    later_rate: float = LATER_RATE,
) -> AdaptationCurve:
    """Return the adaptation curve of a stored run on the tasks of ``demonstrations``."""
    config = run.config
    return adaptation_curve(
        config.environment(),
        run.meta_params,
        demonstrations,
        config.adaptation(demonstrations.quality),
        steps,
        episodes,
        torch.Generator().manual_seed(seed_number("seed", seed)),
        later_rate,
        config.score(),
    )


def acting_by_mean(
    run: Run, demonstrations: Demonstrations, curve: AdaptationCurve
) -> AdaptationCurve:
    """Return an adaptation curve whose policies act by their mean action, one episode per task.

    They are the same policies: the trajectories that each step adapted on were sampled, as ever. The
    paper samples actions "during training" (appendix C) and does not say how a policy acts in the test.
    """
    world, policies = run.config.environment(), [without_noise(each) for each in curve.policies]
    nothing_drawn = torch.Generator()
    rollouts = [collect(world, demonstrations.tasks, each, 1, nothing_drawn) for each in policies]
    return AdaptationCurve(rollouts, policies)


def cloning_before_and_after_warm_start(run: Run) -> tuple[PerTask, PerTask]:
    """Return L^BC of a stored EMRLD-WS on its training tasks, before its cloning step and after it.

    No episode is drawn. A step that raises the loss is too long for what it descends: it overshoots.
    """
    demonstrations = run.load_demonstrations()
    rule = run.config.adaptation(demonstrations.quality)
    demonstrations = demonstrations.seen_in(run.config.environment())
    theta = per_task(run.meta_params, len(demonstrations.tasks))
    start = warm_start(run.meta_params, demonstrations, rule)
    before, after = (cloning_loss(params, demonstrations, rule) for params in (theta, start))
    return before.detach(), after.detach()


def testing_demonstrations(run: Run, tasks: int = UNSEEN_TASKS, seed: int = 0) -> Demonstrations:
    """Return unseen tasks for a stored run, shown in the quality of the data it was trained on."""
    quality = run.load_demonstrations().quality
    return unseen_demonstrations(run.config.env, quality, tasks, seed)


class UnseenRow(NamedTuple):
    """What a stored evaluation says of one task after one adaptation step, as far as it is drawn."""

    task: int
    step: int
    mean_return: float
    goal: str


def read_evaluation(path: Path) -> list[UnseenRow]:
    """Read a table of unseen tasks.

    Raises InputError for one that is missing or damaged, or where a task lacks a step.
    """
    found = []
    for line, row in enumerate(read_csv(path, "evaluation", EVALUATION_COLUMNS), start=2):
        where = f"{path}: line {line}"
        task, step = (whole_number(f"{where}: {name}", row[name]) for name in ("task", "step"))
        real_number(f"{where}: success", number(f"{where}: success", row["success"]), 0.0, 1.0)
        number(f"{where}: steps_to_goal", row["steps_to_goal"], finite=False)
        found.append(UnseenRow(task, step, number(f"{where}: return", row["return"]), row["goal"]))
    places = {(row.task, row.step) for row in found}
    tasks, steps = {row.task for row in found}, {row.step for row in found}
    whole = {(task, step) for task in range(len(tasks)) for step in range(len(steps))}
    if not found or places != whole or len(found) != len(places):
        raise InputError(
            f"{path}: expected one row for every task and step, from 0 on, got {len(found)} rows "
            f"of {len(tasks)} tasks and {len(steps)} steps"
        )
    return found


def write_evaluation(path: Path, demonstrations: Demonstrations, curve: AdaptationCurve) -> None:
    """Write an evaluation as a table, a row per task and step."""
    write_csv(path, EVALUATION_COLUMNS, evaluation_rows(demonstrations.tasks, curve))


def evaluation_rows(tasks: torch.Tensor, curve: AdaptationCurve) -> list[list[str]]:
    """Return the rows of the evaluation table, a row per task and step."""
    rows = []
    for step, rollout in enumerate(curve.rollouts):
        returns = episode_returns(rollout).mean(-1)
        success = rollout.success.float().mean(-1)
        lengths = steps_to_goal(rollout)
        for task in range(len(tasks)):
            numbers = (float(values[task]) for values in (returns, success, lengths))
            goal = " ".join(repr(value) for value in tasks[task].tolist())
            rows.append([str(task), goal, str(step), *(repr(number) for number in numbers)])
    return rows


def steps_to_goal(rollout: Rollout) -> torch.Tensor:
    """Return the mean steps of each task's successful episodes, (task,); nan where none succeeded."""
    lengths = rollout.mask.sum(-1)  # (task, episode)
    reached = rollout.success.float()
    return (lengths * reached).sum(-1) / reached.sum(-1)

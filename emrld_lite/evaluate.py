"""How a meta-policy adapts to tasks it has not seen: fresh rollouts after every step."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

from .adapt import Adaptation, adapt, usable, warm_start
from .config import TrainConfig
from .demonstrations import Demonstrations, find
from .demonstrator import demonstrate, load_or_train_expert
from .envs import Environment, make
from .policy import Params, per_task
from .rollout import Rollout, collect, episode_returns
from .runs import Run
from .storage import write_csv
from .validation import positive_count, real_number

LATER_RATE = 0.1  # measured: at 1 the second step undoes the first, at 0.1 it refines it
EVALUATION_COLUMNS = ("task", "goal", "step", "return", "success", "steps_to_goal")


class AdaptationCurve(NamedTuple):
    """Rollouts on every task after 0, 1, 2, ... adaptation steps, and the policies that made them."""

    rollouts: list[Rollout]
    policies: list[Params]


def adaptation_curve(
    environment: Environment,
    meta_params: Params,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    steps: int,
    episodes: int,
    random: torch.Generator,
    later_rate: float = LATER_RATE,
    scored: Callable[[Rollout], Rollout] | None = None,
) -> AdaptationCurve:
    """Adapt to each task of ``demonstrations`` by ``steps`` steps and roll out after each.

    Every step collects the data it adapts on, as at training time, and is followed by fresh
    rollouts that only measure. The warm start of EMRLD-WS comes once, before the first step. The
    meta-policy was trained for one step and has made it long; those after it use ``later_rate``
    times its learning rate (MAML's own evaluation halves it: Finn et al., 2017, appendix A.2).
    Each task has its own parameters throughout: nothing leaks from one task into the next.
    ``scored`` estimates the advantages, by default as Table 2 says.
    """
    scored = scored or TrainConfig().scored
    positive_count("steps", steps, minimum=0)
    positive_count("episodes", episodes)
    real_number("later_rate", later_rate, minimum=0.0)
    later = dataclasses.replace(
        adaptation, warm_start=False, adapt_lr=later_rate * adaptation.adapt_lr
    )
    tasks = demonstrations.tasks
    policy = per_task(meta_params, len(tasks))
    rollouts = [collect(environment, tasks, policy, episodes, random)]
    policies = [policy]
    for _ in range(steps):
        start, _ = usable(warm_start(policy, demonstrations, adaptation), policy)
        data = collect(environment, tasks, start, episodes, random)
        policy, _ = usable(adapt(policy, scored(data), demonstrations, adaptation), start)
        adaptation = later
        rollouts.append(collect(environment, tasks, policy, episodes, random))
        policies.append(policy)
    return AdaptationCurve(rollouts, policies)


def evaluate_run(
    run: Run,
    demonstrations: Demonstrations,
    steps: int,
    episodes: int = 20,
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
        torch.Generator().manual_seed(positive_count("seed", seed, minimum=0)),
        later_rate,
        config.scored,
    )


def unseen_demonstrations(env: str, quality: str, tasks: int, seed: int = 0) -> Demonstrations:
    """Return ``tasks`` test tasks, drawn from ``seed``, each shown once by the workbook's expert."""
    random = np.random.default_rng(positive_count("seed", seed, minimum=0))
    unseen = make(env).test_tasks(tasks, random)
    return demonstrate(load_or_train_expert(env, quality), env, unseen, quality, seed)


def testing_demonstrations(run: Run, tasks: int = 20, seed: int = 0) -> Demonstrations:
    """Return unseen tasks for a stored run, shown in the quality of the data it was trained on."""
    quality = find(run.config.demos, run.config.env).quality
    return unseen_demonstrations(run.config.env, quality, tasks, seed)


def write_evaluation(path: Path, demonstrations: Demonstrations, curve: AdaptationCurve) -> None:
    """Write an evaluation as a table, a row a task and step."""
    write_csv(path, EVALUATION_COLUMNS, evaluation_rows(demonstrations.tasks, curve))


def evaluation_rows(tasks: torch.Tensor, curve: AdaptationCurve) -> list[list[str]]:
    """Return the rows of the evaluation table, a row a task and step."""
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

"""Algorithm 1: meta-training as a loop in the order of the paper's box."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch

from .adapt import adapt, unmoved_tasks, warm_start
from .config import TrainConfig
from .demonstrations import Demonstrations
from .envs.base import Environment, Tasks
from .learners import TaskData
from .policy import Params, own_memory
from .rollout import Rollout, collect, episode_returns, first_to_end
from .trpo import Step
from .validation import InputError


class Record(NamedTuple):
    """One row of ``curve.csv``; returns are means over tasks and episodes, undiscounted.

    ``return_before`` is that of D^tr, so of the warm-started policy in EMRLD-WS; ``return_after`` and
    ``success_after`` are those of D^val. ``kl`` is the mean divergence between the old and the new
    adapted policies, nats: bounded by TRPO, only measured where the meta-update is Adam's.
    ``env_steps`` counts the steps of the episodes that are kept. ``unmoved`` counts the tasks whose
    adaptation changed nothing: no gradient, or one too large to use; curves stored before it was
    counted have None.
    """

    iteration: int
    seconds: float
    env_steps: int
    return_before: float
    return_after: float
    success_after: float
    kl: float
    backtracks: int
    note: str
    unmoved: int | None = None


class Iterate(NamedTuple):
    """What one meta-iteration leaves behind: the new policy, its record and the data it saw."""

    meta_params: Params
    record: Record
    before: Rollout
    after: Rollout
    learner_state: Params
    """What the learner remembers, for a checkpoint."""


def meta_train(
    config: TrainConfig,
    demonstrations: Demonstrations,
    meta_params: Params | None = None,
    curve: tuple[Record, ...] = (),
    learner_state: Params | None = None,
    device: str = "cpu",
) -> Iterator[Iterate]:
    """Run Algorithm 1 and yield after every meta-iteration.

    To go on with a stopped run, pass its last ``meta_params``, its ``curve`` so far and the
    ``learner_state``: every iteration draws from a generator of its own, seeded by the run's seed
    and its number, so the curve is the same as without the stop. Raises InputError when the
    demonstrations are those of another environment.
    """
    if demonstrations.environment != config.env:
        raise InputError(
            f"demonstrations: expected environment {config.env!r}, got {demonstrations.environment!r}"
        )
    world, score = config.environment(), config.score()
    rule = config.adaptation(demonstrations.quality)
    demos, tasks = demonstrations.seen_in(world).to(device), demonstrations.tasks.to(device)
    theta = config.initial_policy()
    theta = own_memory(meta_params or theta, order=theta, device=device)
    learner = config.learner(theta)
    learner.load(learner_state or {})
    record = Recorder(curve)
    for iteration in range(len(curve), config.iterations):
        random = iteration_generator(config.seed, iteration)
        start = warm_start(theta, demos, rule)  # EMRLD-WS only
        before = score(gather(world, tasks, start, config, random))  # line 6
        adapted = adapt(theta, before, demos, rule)  # line 7
        after = score(gather(world, tasks, adapted, config, random))  # line 8
        data = TaskData(before, after, demos)
        theta, step = learner.update(theta, data, rule, random)  # line 10
        row = record(iteration, before, after, unmoved_tasks(start, adapted), step)
        yield Iterate(theta, row, before, after, learner.state())
        if config.stop_at_return is not None and row.return_after >= config.stop_at_return:
            return


def gather(
    world: Environment, tasks: Tasks, params: Params, config: TrainConfig, random: torch.Generator
) -> Rollout:
    """Return the episodes that one line of Algorithm 1 learns from, (task, episode, time)."""
    started = config.started_episodes or config.episodes
    return first_to_end(collect(world, tasks, params, started, random), config.episodes)


class Recorder:
    """Turns what happened in an iteration into its row of the curve; knows the steps and the seconds."""

    def __init__(self, curve: tuple[Record, ...]) -> None:
        self.env_steps = curve[-1].env_steps if curve else 0
        self.started = time.perf_counter() - (curve[-1].seconds if curve else 0.0)

    def __call__(
        self, iteration: int, before: Rollout, after: Rollout, unmoved: int, step: Step
    ) -> Record:
        """Return the row of one iteration."""
        self.env_steps += int(before.mask.sum() + after.mask.sum())
        return Record(
            iteration=iteration,
            seconds=round(time.perf_counter() - self.started, 3),
            env_steps=self.env_steps,
            return_before=float(episode_returns(before).mean()),
            return_after=float(episode_returns(after).mean()),
            success_after=float(after.success.float().mean()),
            kl=step.kl,
            backtracks=step.backtracks,
            note=step.note,
            unmoved=unmoved,
        )


def iteration_generator(seed: int, iteration: int) -> torch.Generator:
    """Return the CPU generator of one iteration: nothing but seed and number decides its draws."""
    state = np.random.SeedSequence([seed, iteration]).generate_state(1, np.uint64)
    return torch.Generator().manual_seed(int(state[0] >> np.uint64(1)))

"""Algorithm 1: meta-training as a loop that reads like the paper's box."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch

from .adapt import Adaptation, adapt, usable, warm_start
from .config import TrainConfig
from .demonstrations import Demonstrations
from .envs import Environment
from .meta_update import meta_update
from .policy import Params, initialise
from .rollout import Rollout, collect, episode_returns
from .supervised_update import Moments, supervised_update
from .timing import section
from .trpo import Step
from .validation import InputError

SIGMA_SEEN = (1e-3, 1e3)  # beyond, the curve's note says that sigma has drifted


class Record(NamedTuple):
    """One row of ``curve.csv``; returns are means over tasks and episodes, undiscounted.

    ``return_before`` is that of D^tr, so of the warm-started policy in EMRLD-WS; ``return_after`` and
    ``success_after`` are those of D^val. ``kl`` is the mean divergence between the old and the new
    adapted policies, nats: bounded by TRPO, only measured where the meta-update is Adam's.
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


class Iterate(NamedTuple):
    """What one meta-iteration leaves behind: the new policy, its record and the data it saw."""

    meta_params: Params
    record: Record
    before: Rollout
    after: Rollout
    moments: Moments | None = None


def meta_train(
    config: TrainConfig,
    demonstrations: Demonstrations,
    meta_params: Params | None = None,
    history: tuple[Record, ...] = (),
    device: str = "cpu",
    moments: Moments | None = None,
) -> Iterator[Iterate]:
    """Run Algorithm 1 and yield after every meta-iteration.

    To go on with a stopped run, pass its ``meta_params``, the ``history`` of its records, and what
    Adam remembers (``moments``) where the meta-update is Adam's: every iteration draws from a
    generator of its own, seeded by the run's seed and its number, so the curve is the same as
    without the stop. Raises InputError when the demonstrations are those of another environment.
    """
    if demonstrations.environment != config.env:
        raise InputError(
            f"demonstrations: expected environment {config.env!r}, got {demonstrations.environment!r}"
        )
    environment = config.environment()
    adaptation = config.adaptation(demonstrations.quality)
    demonstrations = demonstrations.to(device)
    start = initialise(
        environment.state_dim,
        environment.action_dim,
        config.seed,
        learn_sigma=config.learn_sigma,
        start=config.network_start,
    )
    meta_params = own_memory(meta_params or start, order=start, device=device)
    moments = own_moments(moments, order=start, device=device)
    env_steps = history[-1].env_steps if history else 0
    started = time.perf_counter() - (history[-1].seconds if history else 0.0)
    for iteration in range(len(history), config.iterations):
        random = iteration_generator(config.seed, iteration)
        meta_params, moments, before, after, step = meta_iteration(
            meta_params, environment, demonstrations, adaptation, config, random, moments
        )
        meta_params = own_memory(meta_params, order=start, device=device)
        moments = own_moments(moments, order=start, device=device)
        env_steps += int(before.mask.sum() + after.mask.sum())
        record = Record(
            iteration=iteration,
            seconds=round(time.perf_counter() - started, 3),
            env_steps=env_steps,
            return_before=float(episode_returns(before).mean()),
            return_after=float(episode_returns(after).mean()),
            success_after=float(after.success.float().mean()),
            kl=step.kl,
            backtracks=step.backtracks,
            note=step.note,
        )
        yield Iterate(meta_params, record, before, after, moments)
        if config.stop_at_return is not None and record.return_after >= config.stop_at_return:
            return


def own_memory(params: Params, order: Params, device: str) -> Params:
    """Return copies in the order of ``order``, each in memory of its own.

    A product of matrices may differ in its last bit with where its operands lie, and a sum with its
    order: without this, a policy read from a file would not train on bit for bit as one that
    stayed in memory.
    """
    return {name: params[name].to(device, copy=True) for name in order}


def own_moments(moments: Moments | None, order: Params, device: str) -> Moments | None:
    """Return Adam's moments in memory of their own, for the same reason."""
    if moments is None:
        return None
    mean, square = (own_memory(part, order, device) for part in (moments.mean, moments.square))
    return Moments(moments.step, mean, square)


def iteration_generator(seed: int, iteration: int) -> torch.Generator:
    """Return the CPU generator of one iteration: nothing but seed and number decides its draws."""
    state = np.random.SeedSequence([seed, iteration]).generate_state(1, np.uint64)
    return torch.Generator().manual_seed(int(state[0] >> np.uint64(1)))


def meta_iteration(
    meta_params: Params,
    environment: Environment,
    demonstrations: Demonstrations,
    adaptation: Adaptation,
    config: TrainConfig,
    random: torch.Generator,
    moments: Moments | None = None,
) -> tuple[Params, Moments | None, Rollout, Rollout, Step]:
    """Go once through the body of Algorithm 1.

    Returns the new meta-policy, what Adam remembers (None for TRPO), D^tr, D^val and the step.
    """
    tasks = demonstrations.tasks
    with section("rollout"):
        start, _ = usable(warm_start(meta_params, demonstrations, adaptation), meta_params)
        before = collect(environment, tasks, start, config.episodes, random)  # line 6
    with section("adaptation and gradient"):
        before = config.scored(before)
        adapted = adapt(meta_params, before, demonstrations, adaptation)  # line 7
        task_params, undone = usable(adapted, start)
    with section("rollout"):
        after = collect(environment, tasks, task_params, config.episodes, random)  # line 8
    if config.row().meta_update == "bc":
        meta_params, moments, step = supervised_update(
            meta_params, moments, before, after, demonstrations, adaptation, config.meta_lr
        )
        return meta_params, moments, before, after, told(step, undone, meta_params)
    with section("adaptation and gradient"):
        after = config.scored(after)
    meta_params, step = meta_update(  # line 10
        meta_params, before, after, demonstrations, adaptation, config.trust_region, random
    )
    return meta_params, None, before, after, told(step, undone, meta_params)


def told(step: Step, undone: int, meta_params: Params) -> Step:
    """Return ``step`` with all that a reader of the curve should know in its note."""
    notes = [step.note]
    if undone:
        notes.append(f"adaptation undone for {undone} tasks: parameters not finite or beyond 1e6")
    if "log_sigma" in meta_params:
        sigma = meta_params["log_sigma"].exp()
        if float(sigma.min()) < SIGMA_SEEN[0] or float(sigma.max()) > SIGMA_SEEN[1]:
            notes.append(f"sigma has drifted: {float(sigma.min()):.0e} to {float(sigma.max()):.0e}")
    return step._replace(note="; ".join(note for note in notes if note))

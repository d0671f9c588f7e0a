"""How a meta-policy adapts to tasks it has not seen: fresh rollouts after every step."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import torch

from .adapt import Adaptation, adapt, warm_start
from .advantage import Score
from .demonstrations import Demonstrations
from .envs import Environment
from .policy import Params, per_task
from .rollout import Rollout, collect
from .validation import positive_count, real_number

LATER_RATE = 0.1  # measured: at 1 the second step undoes the first, at 0.1 it refines it


class AdaptationCurve(NamedTuple):
    """Rollouts on every task after 0, 1, 2, ... adaptation steps, and the policies that made them."""

    rollouts: list[Rollout]
    policies: list[Params]


def adaptation_curve(
    environment: Environment,
    meta_params: Params,
    demonstrations: Demonstrations,
    rule: Adaptation,
    steps: int,
    episodes: int,
    random: torch.Generator,
    later_rate: float = LATER_RATE,
    score: Score | None = None,
) -> AdaptationCurve:
    """Adapt to each task of ``demonstrations`` by ``steps`` steps and roll out after each.

    Every step collects the data it adapts on, as at training time, and is followed by fresh
    rollouts that only measure. The warm start of EMRLD-WS comes once, before the first step. The
    meta-policy was trained for one step; those after it use ``later_rate`` times its learning rate
    (MAML's own evaluation halves it: Finn et al., 2017, appendix A.2).
    Each task has its own parameters throughout: nothing leaks from one task into the next.
    ``score`` estimates the advantages, by default as Table 1 says.
    """
    positive_count("steps", steps, minimum=0)
    positive_count("episodes", episodes)
    real_number("later_rate", later_rate, minimum=0.0)
    score = score or Score()
    later = dataclasses.replace(rule, warm_start=False, adapt_lr=later_rate * rule.adapt_lr)
    demonstrations = demonstrations.seen_in(environment)
    tasks = demonstrations.tasks
    policy = per_task(meta_params, len(tasks))
    policies = [policy]
    rollouts = [collect(environment, tasks, policy, episodes, random)]
    for _ in range(steps):
        start = warm_start(policy, demonstrations, rule)
        before = score(collect(environment, tasks, start, episodes, random))
        policy = adapt(policy, before, demonstrations, rule)
        rule = later
        policies.append(policy)
        rollouts.append(collect(environment, tasks, policy, episodes, random))
    return AdaptationCurve(rollouts, policies)

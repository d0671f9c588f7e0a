"""From experts to demonstrations: what makes data optimal or sub-optimal, and the stored experts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from .. import storage
from ..demonstrations import Demonstrations, from_arrays
from ..envs import Environment, make
from ..policy import LOG_SIGMA_BOUNDS, Params
from ..rollout import collect, episode_returns
from ..validation import InputError, lookup, seed_number
from .expert import (
    ExpertConfig,
    ExpertIterate,
    GoalConditioned,
    expert_config,
    load_expert,
    train_expert,
)

SHIPPED = storage.DATA / "experts"
SMALLEST_SIGMA = math.exp(LOG_SIGMA_BOUNDS[0])  # stands for no noise


@dataclass(frozen=True)
class Recipe:
    """What turns an expert's training into demonstrations of one quality (section 4.1)."""

    success_at_stop: float = math.inf
    """Training stops at the first iteration with this success rate on the dense task; inf: never early."""
    action_noise: float = 0.0
    """Standard deviation of noise added to the policy's mean action, in units of the action range."""
    skipped_steps: int = 0
    """This many state-action pairs at the beginning are removed, but one at least is kept of each."""
    short_of_reward: float | None = None
    """Trajectories end before they come closer than this to the region that pays; None keeps them whole."""
    cut: tuple[float, ...] = ()
    """Size, 1 or more, to which each number of an action is cut in the data; empty: kept as it was drawn. The
    paths stay what they are, since the environment clips at 1 itself."""


RECIPES: dict[str, dict[str, Recipe]] = {
    "point2d": {
        "optimal": Recipe(),
        "suboptimal": Recipe(success_at_stop=0.5, action_noise=0.1, short_of_reward=0.2),
    },
    "two_wheeled": {
        "optimal": Recipe(),
        "suboptimal": Recipe(
            success_at_stop=0.5, action_noise=0.1, skipped_steps=8, short_of_reward=0.1
        ),
    },
    "two_wheeled_drift": {
        "optimal": Recipe(),
        "suboptimal": Recipe(
            success_at_stop=0.7, action_noise=0.1, skipped_steps=8, short_of_reward=0.1
        ),
    },
    "two_wheeled_literal_drift": {
        "optimal": Recipe(),
        "suboptimal": Recipe(
            success_at_stop=0.7, action_noise=0.1, skipped_steps=8, short_of_reward=0.1
        ),
    },
    "half_cheetah": {
        "optimal": Recipe(),
        "suboptimal": Recipe(success_at_stop=0.9, action_noise=0.3, short_of_reward=0.5),
    },
}


def recipe_for(env: str, quality: str) -> Recipe:
    """Return what makes data of ``quality`` in ``env``; an unknown one raises InputError."""
    return lookup("quality", quality, lookup("environment", env, RECIPES))


def train_to_quality(
    config: ExpertConfig, quality: str, recipe: Recipe | None = None
) -> Iterator[ExpertIterate]:
    """Yield the iterates of ``train_expert`` up to the one whose policy makes data of ``quality``.

    ``recipe`` replaces the recipe of ``quality``, for experiments.
    """
    enough = (recipe or recipe_for(config.env, quality)).success_at_stop
    for iterate in train_expert(config):
        yield iterate
        if iterate.success >= enough:
            return


def demonstrate(
    params: Params,
    env: str,
    tasks: Float[Tensor, "task task_dim"],
    quality: str,
    seed: int,
    recipe: Recipe | None = None,
    paths: int = 1,
) -> Demonstrations:
    """Return one demonstration per task from a goal-conditioned policy, or several ``paths`` of each.

    ``recipe`` replaces the recipe of ``quality``, for experiments. The maker of the data says what the
    policy reached on the sparse reward, before any cut.
    """
    recipe = recipe or recipe_for(env, quality)
    family = make(env)
    family.check_tasks(tasks)
    sigma = torch.full((family.action_dim,), recipe.action_noise).clamp_min(SMALLEST_SIGMA)
    noisy = dict(params, log_sigma=sigma.log())
    draws = torch.Generator().manual_seed(seed)
    rollout = collect(GoalConditioned(family), tasks, noisy, paths, draws)
    states = rollout.states[..., : family.state_dim]  # (task, path, time, state)
    first, lengths = _kept_steps(family, tasks, states, rollout.mask, recipe)
    longest = int(lengths.max())
    actions = cut_actions(rollout.actions, recipe.cut)
    reached = rollout.success.float().mean()
    returns = episode_returns(rollout).mean()
    maker = (
        f"emrld_lite goal-conditioned TRPO, action noise {recipe.action_noise}, before any cut: "
        f"success {reached:.2f}, mean sparse return {returns:.1f}"
    )
    if recipe.cut:
        maker += f"; actions cut to {', '.join(map(str, recipe.cut))}"
    return from_arrays(
        tasks.numpy(),
        states[:, :, first : first + longest].numpy(),
        actions[:, :, first : first + longest].numpy(),
        lengths.numpy(),
        environment=env,
        quality=quality,
        maker=maker,
        seed=seed,
    )


def cut_actions(
    actions: Float[Tensor, "*at action"], largest: tuple[float, ...]
) -> Float[Tensor, "*at action"]:
    """Return actions with each of their numbers cut to its ``largest`` size; without any, as they are.

    Raises InputError where there is not one size per number, or one under 1, which would change the path.
    """
    if not largest:
        return actions
    if len(largest) != actions.shape[-1]:
        raise InputError(
            f"cut: expected {actions.shape[-1]} sizes, one per number of an action, got {len(largest)}"
        )
    wrong = [size for size in largest if not size >= 1.0]
    if wrong:
        raise InputError(f"cut: expected sizes of 1 or more, where the box ends, got {wrong[0]}")
    bound = torch.tensor(largest, dtype=actions.dtype)
    return actions.clamp(-bound, bound)


def _kept_steps(
    family: Environment,
    tasks: Float[Tensor, "task task_dim"],
    states: Float[Tensor, "task path time state"],
    mask: Float[Tensor, "task path time"],
    recipe: Recipe,
) -> tuple[int, Int[Tensor, "task path"]]:
    """Return the first step kept, and how many steps of each trajectory from there on."""
    end = mask.sum(-1).long()
    if recipe.short_of_reward is not None:
        apart = [family.distance_to_reward(tasks, path) for path in states.unbind(1)]
        far = torch.stack(apart, 1) > recipe.short_of_reward  # (task, path, time)
        end = torch.minimum(end, far.long().cumprod(-1).sum(-1))
    first = max(0, min(recipe.skipped_steps, int(end.min()) - 1))
    return first, end - first


def expert_path(env: str, quality: str) -> Path:
    """Return where the workbook keeps the expert of an environment and a quality."""
    return SHIPPED / f"{env}-{quality}.safetensors"


def load_or_train_expert(env: str, quality: str) -> Params:
    """Return the workbook's expert, or train it anew (a minute to ten) when its file is not there."""
    path = expert_path(env, quality)
    if path.exists():
        return load_expert(path, env, quality)
    return list(train_to_quality(expert_config(env), quality))[-1].params


def unseen_demonstrations(env: str, quality: str, tasks: int, seed: int = 0) -> Demonstrations:
    """Return ``tasks`` test tasks, drawn from ``seed``, each shown once by the workbook's expert."""
    random = np.random.default_rng(seed_number("seed", seed))
    unseen = make(env).test_tasks(tasks, random)
    return demonstrate(load_or_train_expert(env, quality), env, unseen, quality, seed)

"""From experts to demonstrations: what makes data optimal or sub-optimal, and the stored experts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import torch

from . import storage
from .demonstrations import Demonstrations, from_arrays
from .envs import Environment, make
from .expert import ExpertConfig, ExpertIterate, GoalConditioned, expert_config, train_expert
from .policy import Params
from .rollout import collect, episode_returns
from .validation import InputError, lookup

SHIPPED = Path(__file__).resolve().parent.parent / "data" / "experts"


@dataclass(frozen=True)
class Quality:
    """What turns an expert's training into demonstrations of one quality (section 4.1)."""

    success_at_stop: float = math.inf
    """Training stops at the first iteration with this success rate on the dense task; inf: never early."""
    action_noise: float = 0.0
    """Standard deviation of noise added to the policy's mean action, in units of the action range."""
    skipped_steps: int = 0
    """This many state-action pairs at the beginning are removed, but one at least is kept of each."""
    short_of_reward: float | None = None
    """Trajectories end before they come closer than this to the region that pays; None keeps them whole."""


RECIPES: dict[str, dict[str, Quality]] = {
    "point2d": {
        "optimal": Quality(),
        "suboptimal": Quality(success_at_stop=0.5, action_noise=0.1, short_of_reward=0.2),
    },
    "two_wheeled": {
        "optimal": Quality(),
        "suboptimal": Quality(
            success_at_stop=0.5, action_noise=0.1, skipped_steps=8, short_of_reward=0.1
        ),
    },
    "two_wheeled_drift": {
        "optimal": Quality(),
        "suboptimal": Quality(
            success_at_stop=0.7, action_noise=0.1, skipped_steps=8, short_of_reward=0.1
        ),
    },
    "half_cheetah": {
        "optimal": Quality(),
        "suboptimal": Quality(success_at_stop=0.9, action_noise=0.3, short_of_reward=0.5),
    },
}


def recipe(env: str, quality: str) -> Quality:
    """Return what makes data of ``quality`` in ``env``; an unknown one raises InputError."""
    return lookup("quality", quality, lookup("environment", env, RECIPES))


def train_to_quality(config: ExpertConfig, quality: str) -> Iterator[ExpertIterate]:
    """Yield the iterates of ``train_expert`` up to the one whose policy makes data of ``quality``."""
    enough = recipe(config.env, quality).success_at_stop
    for iterate in train_expert(config):
        yield iterate
        if iterate.success >= enough:
            return


def demonstrate(
    params: Params,
    env: str,
    tasks: torch.Tensor,
    quality: str,
    seed: int,
    chosen: Quality | None = None,
) -> Demonstrations:
    """Return one demonstration a task, (task, task_dim), from a goal-conditioned policy.

    ``chosen`` replaces the recipe of ``quality``, for experiments. The maker of the data says what the
    policy reached on the sparse reward, before any cut.
    """
    chosen = chosen or recipe(env, quality)
    family = make(env)
    family.check_tasks(tasks)
    noisy = dict(params, log_sigma=torch.full((family.action_dim,), chosen.action_noise).log())
    rollout = collect(GoalConditioned(family), tasks, noisy, 1, torch.Generator().manual_seed(seed))
    states = rollout.states[:, 0, :, : family.state_dim]  # (task, time, state)
    first, lengths = _kept_steps(family, tasks, states, rollout.mask[:, 0], chosen)
    longest = int(lengths.max())
    reached = rollout.success.float().mean()
    returns = episode_returns(rollout).mean()
    maker = (
        f"emrld_lite goal-conditioned TRPO, action noise {chosen.action_noise}, before any cut: "
        f"success {reached:.2f}, mean sparse return {returns:.1f}"
    )
    return from_arrays(
        tasks.numpy(),
        states[:, first : first + longest].numpy(),
        rollout.actions[:, 0, first : first + longest].numpy(),
        lengths.numpy(),
        environment=env,
        quality=quality,
        maker=maker,
        seed=seed,
    )


def _kept_steps(
    family: Environment,
    tasks: torch.Tensor,
    states: torch.Tensor,
    mask: torch.Tensor,
    chosen: Quality,
) -> tuple[int, torch.Tensor]:
    """Return the first step kept, and how many steps of each trajectory from there on, (task,)."""
    end = mask.sum(-1).long()  # (task,)
    if chosen.short_of_reward is not None:
        far = family.distance_to_reward(tasks, states) > chosen.short_of_reward  # (task, time)
        end = torch.minimum(end, far.long().cumprod(-1).sum(-1))
    first = max(0, min(chosen.skipped_steps, int(end.min()) - 1))
    return first, end - first


def expert_path(env: str, quality: str) -> Path:
    """Return where the workbook keeps the expert of an environment and a quality."""
    return SHIPPED / f"{env}-{quality}.safetensors"


def save_expert(path: Path, params: Params, config: ExpertConfig, quality: str) -> None:
    """Write an expert's policy with its environment, quality and seed."""
    facts = {"environment": config.env, "quality": quality, "seed": str(config.seed)}
    storage.write_tensors(path, params, facts)


def load_expert(path: Path, env: str, quality: str) -> Params:
    """Read an expert's policy; one that is damaged or of another kind raises InputError."""
    params, facts = storage.read_tensors(path, "expert")
    for field_name, wanted in (("environment", env), ("quality", quality)):
        if facts.get(field_name) != wanted:
            raise InputError(
                f"{path}: {field_name}: expected {wanted!r}, got {facts.get(field_name)!r}"
            )
    return params


def load_or_train_expert(env: str, quality: str) -> Params:
    """Return the workbook's expert, or train it anew (a minute to ten) when its file is not there."""
    path = expert_path(env, quality)
    if path.exists():
        return load_expert(path, env, quality)
    return list(train_to_quality(expert_config(env), quality))[-1].params

"""From experts to demonstrations: what makes data optimal or sub-optimal, and the stored experts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import torch

from . import storage
from .demonstrations import QUALITIES, Demonstrations, from_arrays
from .envs import make
from .expert import ExpertConfig, ExpertIterate, GoalConditioned, train_expert
from .policy import Params
from .rollout import collect, episode_returns
from .validation import InputError, known

SHIPPED = Path(__file__).resolve().parent.parent / "data" / "experts"


@dataclass(frozen=True)
class Quality:
    """What turns an expert's training into demonstrations of one quality (section 4.1)."""

    success_at_stop: float
    """Training stops at the first iteration with this success rate on the dense task; inf: never early."""
    action_noise: float
    """Standard deviation of noise added to the policy's mean action, in units of the action range."""
    cut_distance: float
    """Trajectories end before they come closer to the goal than this; 0 keeps them whole."""


POINT2D_QUALITIES = {
    "optimal": Quality(success_at_stop=math.inf, action_noise=0.0, cut_distance=0.0),
    "suboptimal": Quality(success_at_stop=0.5, action_noise=0.1, cut_distance=0.4),
}


def train_to_quality(config: ExpertConfig, quality: str) -> Iterator[ExpertIterate]:
    """Yield the iterates of ``train_expert`` up to the one whose policy makes data of ``quality``."""
    known("quality", quality, QUALITIES)
    for iterate in train_expert(config):
        yield iterate
        if iterate.success >= POINT2D_QUALITIES[quality].success_at_stop:
            return


def demonstrate(
    params: Params, env: str, tasks: torch.Tensor, quality: str, seed: int
) -> Demonstrations:
    """Return one demonstration a task, (task, task_dim), from a goal-conditioned policy."""
    known("quality", quality, QUALITIES)
    recipe = POINT2D_QUALITIES[quality]
    family = make(env)
    family.check_tasks(tasks)
    noisy = dict(params, log_sigma=torch.full((family.action_dim,), recipe.action_noise).log())
    rollout = collect(GoalConditioned(family), tasks, noisy, 1, torch.Generator().manual_seed(seed))
    states = rollout.states[:, 0, :, : family.state_dim]  # (task, time, state)
    lengths = rollout.mask[:, 0].sum(-1).long()  # (task,)
    if recipe.cut_distance:
        lengths = torch.minimum(lengths, _steps_outside(states, tasks, recipe.cut_distance))
    longest = int(lengths.max())
    reached = rollout.success.float().mean()
    returns = episode_returns(rollout).mean()
    maker = (
        f"emrld_lite goal-conditioned TRPO, action noise {recipe.action_noise}, before any cut: "
        f"success {reached:.2f}, mean sparse return {returns:.1f}"
    )
    return from_arrays(
        tasks.numpy(),
        states[:, :longest].numpy(),
        rollout.actions[:, 0, :longest].numpy(),
        lengths.numpy(),
        environment=env,
        quality=quality,
        maker=maker,
        seed=seed,
    )


def _steps_outside(states: torch.Tensor, goals: torch.Tensor, distance: float) -> torch.Tensor:
    """Return how many first steps of each trajectory stay ``distance`` away from its goal, (task,)."""
    far = (states - goals[:, None]).norm(dim=-1) > distance  # (task, time)
    return far.long().cumprod(-1).sum(-1)


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
    """Return the workbook's expert, or train it anew (about a minute) when its file is not there."""
    path = expert_path(env, quality)
    if path.exists():
        return load_expert(path, env, quality)
    return list(train_to_quality(ExpertConfig(env=env), quality))[-1].params

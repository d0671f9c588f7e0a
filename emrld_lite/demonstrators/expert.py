"""The experts behind the demonstrations: goal-conditioned TRPO on the dense reward (appendix C).

One policy for all tasks: the task's parameters are appended to the state. It shares rollouts,
advantages and TRPO with the meta-learner; only the value network is its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from .. import storage
from ..advantage import discounted_returns, generalised_advantage, normalise
from ..envs import ENVIRONMENTS, make
from ..envs.base import Dynamics, Environment, Transition
from ..policy import Params, detach, distribution, initialise
from ..rollout import Rollout, collect, episode_returns, pack, subsample
from ..trpo import TrustRegion, fisher_product, surrogate_and_kl, surrogate_gradient, trpo_step
from ..validation import InputError, check_choice, lookup, positive_count, real_number, seed_number

HIDDEN = (128, 128)  # appendix C
ExpertReward = Literal["dense", "sparse"]


@dataclass(frozen=True)
class ExpertConfig:
    """How an expert is trained; raises InputError for values that cannot be used."""

    env: str = "point2d"
    """Environment it learns in."""
    reward: ExpertReward = "dense"
    """Reward it learns from; sparse is there to be compared."""
    seed: int = 0
    """Seed of its start and of every draw."""
    iterations: int = 80
    """TRPO iterations."""
    tasks: int = 48
    """Tasks drawn afresh from the test distribution each iteration."""
    episodes: int = 4
    """Episodes of each task."""
    discount: float = 0.95
    """gamma."""
    gae_lambda: float = 0.9
    """GAE's lambda: the value network is good enough to lean on."""
    value_rate: float = 1e-3
    """Adam's learning rate for the value network."""
    value_steps: int = 30
    """Adam steps on the value network per iteration."""
    trust_region: TrustRegion = field(
        default_factory=lambda: TrustRegion(
            max_kl=0.03, damping=1e-3, cg_iterations=10, fisher_samples=40
        )
    )
    """TRPO's step."""

    def __post_init__(self) -> None:
        check_choice("environment", self.env, ENVIRONMENTS)
        check_choice("reward", self.reward, get_args(ExpertReward))
        seed_number("seed", self.seed)
        for name in ("iterations", "tasks", "episodes", "value_steps"):
            positive_count(name, getattr(self, name))
        real_number("discount", self.discount, 0.0, 1.0)
        real_number("gae_lambda", self.gae_lambda, 0.0, 1.0)


BY_ENVIRONMENT: dict[str, dict[str, float]] = {
    "point2d": {},
    "two_wheeled": {"iterations": 120},
    "two_wheeled_drift": {"iterations": 200},
    "two_wheeled_literal_drift": {"iterations": 200},
    "half_cheetah": {"iterations": 250, "discount": 0.97, "gae_lambda": 0.95},
}


def expert_config(env: str, seed: int = 0) -> ExpertConfig:
    """Return how the expert of ``env`` is trained; an unknown environment raises InputError."""
    return ExpertConfig(env=env, seed=seed, **lookup("environment", env, BY_ENVIRONMENT))


class GoalConditioned(Dynamics):
    """An environment whose states have the task's parameters appended, (task, episode, state + task)."""

    def __init__(self, environment: Environment) -> None:
        self.environment = environment
        self.horizon = environment.horizon
        self.action_dim = environment.action_dim
        self.state_dim = environment.state_dim + environment.task_dim

    def reset(
        self,
        tasks: Float[Tensor, "task task_dim"],
        episodes: int,
        random: torch.Generator | None = None,
    ) -> Float[Tensor, "task episode state"]:
        """Return the initial states with their tasks."""
        return self._append(tasks, self.environment.reset(tasks, episodes, random))

    def step(
        self,
        tasks: Float[Tensor, "task task_dim"],
        states: Float[Tensor, "task episode state"],
        actions: Float[Tensor, "task episode action"],
        time: int,
    ) -> Transition:
        """Step the environment inside and append the tasks again."""
        inside = states[..., : self.environment.state_dim]
        moved = self.environment.step(tasks, inside, actions, time)
        return moved._replace(states=self._append(tasks, moved.states))

    @staticmethod
    def _append(
        tasks: Float[Tensor, "task task_dim"], states: Float[Tensor, "task episode inside"]
    ) -> Float[Tensor, "task episode state"]:
        context = tasks[:, None].expand(*states.shape[:2], tasks.shape[-1])
        return torch.cat([states, context], dim=-1)


class ExpertIterate(NamedTuple):
    """What one iteration of expert training leaves behind."""

    iteration: int
    """Number of the iteration, from 0."""
    params: Params
    """Goal-conditioned policy after it."""
    dense_return: float
    """Mean return of the episodes it learned from, in the reward it learns from."""
    success: float
    """Share of those episodes that reached their goal."""


def train_expert(config: ExpertConfig) -> Iterator[ExpertIterate]:
    """Train the goal-conditioned policy by TRPO with a learned value; yields after every iteration."""
    family = make(config.env, reward=config.reward)
    environment = GoalConditioned(family)
    params = initialise(environment.state_dim, environment.action_dim, config.seed, HIDDEN)
    value = initialise(environment.state_dim, 1, config.seed + 1, HIDDEN, learn_sigma=False)
    value = detach(value, requires_grad=True)
    optimiser = torch.optim.Adam(value.values(), lr=config.value_rate)
    for iteration in range(config.iterations):
        random = np.random.default_rng([config.seed, iteration])
        draws = torch.Generator().manual_seed(int(random.integers(2**62)))
        tasks = family.sample_tasks(config.tasks, random)
        rollout = collect(environment, tasks, params, config.episodes, draws)
        together = _as_one_task(rollout)
        scored = _with_advantages(together, value, config)
        _fit_value(value, optimiser, together, config, draws)
        params = _improve(params, scored, config.trust_region, draws)
        dense_return = float(episode_returns(rollout).mean())
        yield ExpertIterate(iteration, params, dense_return, float(rollout.success.float().mean()))


def _as_one_task(rollout: Rollout) -> Rollout:
    """Return all episodes under a single task: there is one policy."""
    return Rollout(*(None if part is None else part.flatten(0, 1)[None] for part in rollout))


def _values(value: Params, rollout: Rollout) -> Float[Tensor, "1 episode time"]:
    """Return the value network's V(s), in units of 1 / (1 - gamma)."""
    return distribution(value, rollout.states).mean[..., 0] * rollout.mask


def _with_advantages(rollout: Rollout, value: Params, config: ExpertConfig) -> Rollout:
    scale = 1.0 / (1.0 - config.discount)
    with torch.no_grad():
        values = _values(value, rollout) * scale
    advantage = generalised_advantage(rollout.rewards, values, config.discount, config.gae_lambda)
    return rollout._replace(advantages=normalise(advantage * rollout.mask, rollout.mask))


def _fit_value(
    value: Params,
    optimiser: torch.optim.Optimizer,
    rollout: Rollout,
    config: ExpertConfig,
    draws: torch.Generator,
) -> None:
    """Regress the value network on the discounted returns, in random batches."""
    scale = 1.0 / (1.0 - config.discount)
    target = discounted_returns(rollout.rewards, config.discount) / scale
    labelled = rollout._replace(rewards=target)
    for _ in range(config.value_steps):
        batch = subsample(labelled, 1024, draws)
        loss = (_values(value, batch) - batch.rewards).square().mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()


def _improve(
    params: Params, rollout: Rollout, region: TrustRegion, draws: torch.Generator
) -> Params:
    """Return the policy after one TRPO step on the rollout."""
    region = region.for_actions(rollout.actions.shape[-1])
    samples = region.fisher_samples * 12  # one task here against twelve in meta-training
    sampled = subsample(rollout, samples, draws)
    packed = pack(rollout)
    piece = surrogate_gradient(params, lambda trial: distribution(trial, packed.states), packed)

    def exact(trial: Params) -> tuple[float, float]:
        return surrogate_and_kl(distribution(trial, packed.states), piece.old, packed)

    leaves = detach(params, requires_grad=True)
    weight = sampled.mask / sampled.mask.sum()
    product = fisher_product(distribution(leaves, sampled.states), weight, leaves, region.damping)
    return trpo_step(params, piece.surrogate, piece.gradient, product, exact, region)[0]


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
    inside = make(env)
    expected = initialise(inside.state_dim + inside.task_dim, inside.action_dim, 0, HIDDEN)
    return storage.fitting(path, params, expected)

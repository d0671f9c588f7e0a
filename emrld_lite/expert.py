"""The experts behind the demonstrations: goal-conditioned TRPO on the dense reward (appendix C).

One policy for all tasks: the task's parameters are appended to the state. It shares rollouts,
advantages and TRPO with the meta-learner; only the value network is its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import torch
from matplotlib.axes import Axes

from .advantage import discounted_returns, generalised_advantage, normalise
from .envs import ENVIRONMENTS, Environment, Transition, make
from .losses import surrogate_loss, task_mean
from .policy import Gaussian, Params, detach, distribution, initialise, kl_divergence
from .rollout import Rollout, collect, episode_returns, pack, subsample
from .trpo import TrustRegion, trpo_step
from .validation import known, lookup, positive_count, real_number

HIDDEN = (128, 128)  # appendix C


@dataclass(frozen=True)
class ExpertConfig:
    """How an expert is trained; raises InputError for values that cannot be used."""

    env: str = "point2d"
    """Environment it learns in."""
    reward: str = "dense"
    """Reward it learns from; "sparse" is there to be compared."""
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
    """Adam steps on the value network an iteration."""
    trust_region: TrustRegion = field(
        default_factory=lambda: TrustRegion(
            max_kl=0.03, damping=1e-3, cg_iterations=10, fisher_samples=40
        )
    )
    """TRPO's step."""

    def __post_init__(self) -> None:
        known("environment", self.env, ENVIRONMENTS)
        known("reward", self.reward, ("dense", "sparse"))
        positive_count("seed", self.seed, minimum=0)
        for name in ("iterations", "tasks", "episodes", "value_steps"):
            positive_count(name, getattr(self, name))
        real_number("discount", self.discount, 0.0, 1.0)
        real_number("gae_lambda", self.gae_lambda, 0.0, 1.0)


BY_ENVIRONMENT: dict[str, dict[str, float]] = {
    "point2d": {},
    "two_wheeled": {"iterations": 120},
    "two_wheeled_drift": {"iterations": 200},
    "half_cheetah": {"iterations": 250, "discount": 0.97, "gae_lambda": 0.95},
}


def expert_config(env: str, seed: int = 0) -> ExpertConfig:
    """Return how the expert of ``env`` is trained; an unknown environment raises InputError."""
    return ExpertConfig(env=env, seed=seed, **lookup("environment", env, BY_ENVIRONMENT))


class GoalConditioned(Environment):
    """An environment whose states have the task's parameters appended, (task, episode, state + task)."""

    def __init__(self, environment: Environment) -> None:
        self.environment = environment
        self.name = environment.name
        self.horizon = environment.horizon
        self.action_dim = environment.action_dim
        self.task_dim = environment.task_dim
        self.state_dim = environment.state_dim + environment.task_dim

    def training_tasks(self) -> torch.Tensor:
        """Return the tasks of the environment inside."""
        return self.environment.training_tasks()

    def sample_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return tasks of the environment inside."""
        return self.environment.sample_tasks(count, random)

    def check_tasks(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return tasks that the environment inside accepts."""
        return self.environment.check_tasks(tasks)

    def reset(self, tasks: torch.Tensor, episodes: int) -> torch.Tensor:
        """Return the initial states with their tasks."""
        return self._append(tasks, self.environment.reset(tasks, episodes))

    def step(
        self, tasks: torch.Tensor, states: torch.Tensor, actions: torch.Tensor, time: int
    ) -> Transition:
        """Step the environment inside and append the tasks again."""
        inside = states[..., : self.environment.state_dim]
        moved = self.environment.step(tasks, inside, actions, time)
        return moved._replace(states=self._append(tasks, moved.states))

    def distance_to_reward(self, tasks: torch.Tensor, states: torch.Tensor) -> torch.Tensor:
        """Return that of the environment inside."""
        return self.environment.distance_to_reward(tasks, states[..., : self.environment.state_dim])

    def draw(self, axes: Axes, task: torch.Tensor, states: torch.Tensor) -> None:
        """Draw with the environment inside."""
        self.environment.draw(axes, task, states[:, : self.environment.state_dim])

    @staticmethod
    def _append(tasks: torch.Tensor, states: torch.Tensor) -> torch.Tensor:
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
    environment = GoalConditioned(make(config.env, reward=config.reward))
    params = initialise(environment.state_dim, environment.action_dim, config.seed, HIDDEN)
    value = initialise(environment.state_dim, 1, config.seed + 1, HIDDEN, learn_sigma=False)
    value = detach(value, requires_grad=True)
    optimiser = torch.optim.Adam(value.values(), lr=config.value_rate)
    for iteration in range(config.iterations):
        random = np.random.default_rng([config.seed, iteration])
        draws = torch.Generator().manual_seed(int(random.integers(2**62)))
        tasks = environment.sample_tasks(config.tasks, random)
        rollout = collect(environment, tasks, params, config.episodes, draws)
        together = _as_one_task(rollout)
        scored = _with_advantages(together, value, config)
        _fit_value(value, optimiser, together, config, draws)
        params = _improve(params, scored, config.trust_region, draws)
        dense_return = float(episode_returns(rollout).mean())
        yield ExpertIterate(iteration, params, dense_return, float(rollout.success.float().mean()))


def _as_one_task(rollout: Rollout) -> Rollout:
    """Return all episodes under a single task, (1, task * episode, time, dim): there is one policy."""
    return Rollout(*(None if part is None else part.flatten(0, 1)[None] for part in rollout))


def _values(value: Params, rollout: Rollout) -> torch.Tensor:
    """Return the value network's V(s), (1, episode, time), in units of 1 / (1 - gamma)."""
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
    samples = region.fisher_samples * 12  # one task here against twelve in meta-training
    sampled = subsample(rollout, samples, draws)
    packed = pack(rollout)
    leaves = detach(params, requires_grad=True)
    new = distribution(leaves, packed.states)
    old = Gaussian(*(output.detach() for output in new))
    surrogate = surrogate_loss(new, old, packed).mean()
    parts = torch.autograd.grad(surrogate, list(leaves.values()))
    gradient = torch.cat([part.reshape(-1) for part in parts])

    def fisher(trial: Params) -> tuple[Gaussian, torch.Tensor]:
        return distribution(trial, sampled.states), sampled.mask / sampled.mask.sum()

    def surrogate_and_kl(trial: Params) -> tuple[float, float]:
        new = distribution(trial, packed.states)
        kl = task_mean(kl_divergence(old, new), packed.mask).mean()
        return float(surrogate_loss(new, old, packed).mean()), float(kl)

    surrogate_value = float(surrogate.detach())
    return trpo_step(params, surrogate_value, gradient, fisher, surrogate_and_kl, region)[0]

"""The experts behind the demonstrations: goal-conditioned TRPO on the dense reward (appendix C).

One policy for all tasks: the task's parameters are appended to the state. It shares rollouts,
advantages and TRPO with the meta-learner; only the value network is its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

from . import storage
from .advantage import discounted_returns, generalised_advantage, normalise
from .demonstrations import QUALITIES, Demonstrations, from_arrays
from .envs import ENVIRONMENTS, Environment, Transition, make
from .losses import surrogate_loss, task_mean
from .policy import Gaussian, Params, detach, distribution, initialise, kl_divergence
from .rollout import Rollout, collect, episode_returns, pack, subsample
from .trpo import TrustRegion, trpo_step
from .validation import InputError, known, positive_count, real_number

SHIPPED = Path(__file__).resolve().parent.parent / "data" / "experts"
HIDDEN = (128, 128)  # appendix C


@dataclass(frozen=True)
class ExpertConfig:
    """How an expert is trained; raises InputError for values that cannot be used."""

    env: str = "point2d"
    """Environment whose dense reward it learns from."""
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
        positive_count("seed", self.seed, minimum=0)
        for name in ("iterations", "tasks", "episodes", "value_steps"):
            positive_count(name, getattr(self, name))
        real_number("discount", self.discount, 0.0, 1.0)
        real_number("gae_lambda", self.gae_lambda, 0.0, 1.0)


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

    @staticmethod
    def _append(tasks: torch.Tensor, states: torch.Tensor) -> torch.Tensor:
        context = tasks[:, None].expand(*states.shape[:2], tasks.shape[-1])
        return torch.cat([states, context], dim=-1)


class ExpertIterate(NamedTuple):
    """What one iteration of expert training leaves behind."""

    iteration: int
    params: Params
    dense_return: float
    success: float


def train_expert(config: ExpertConfig) -> Iterator[ExpertIterate]:
    """Train the goal-conditioned policy by TRPO with a learned value; yields after every iteration."""
    environment = GoalConditioned(make(config.env, reward="dense"))
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


@dataclass(frozen=True)
class Quality:
    """What turns an expert's training into demonstrations of one quality (section 4.1)."""

    success_at_stop: float
    """Training stops at the first iteration with this success rate on the dense task."""
    action_noise: float
    """Standard deviation of noise added to the policy's mean action, in units of the action range."""
    cut_distance: float
    """Trajectories end before they come closer to the goal than this; 0 keeps them whole."""


POINT2D_QUALITIES = {
    "optimal": Quality(success_at_stop=2.0, action_noise=0.0, cut_distance=0.0),
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

"""Rollouts: every episode of every task in one batch, as one NamedTuple."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from .envs.base import Actions, Dynamics, States
from .policy import Params, distribution, mean

PerTask = Float[Tensor, " task"]
PerStep = Float[Tensor, "task episode time"]


class Rollout(NamedTuple):
    """Episodes in one batch, as long as the longest of them; after an episode's end everything is zero."""

    states: Float[Tensor, "task episode time state"]
    """State s_t in which the policy acted, as it saw it."""
    actions: Float[Tensor, "task episode time action"]
    """Action a_t as the policy drew it, before clipping."""
    rewards: PerStep
    """Reward R_t that followed."""
    mask: PerStep
    """1 where the step was taken, 0 after the end."""
    success: Bool[Tensor, "task episode"]
    """Whether the episode reached its goal."""
    advantages: PerStep | None = None
    """Estimates of A(s_t, a_t), once they have been made."""

    def take(self, tasks: slice) -> Rollout:
        """Return the episodes of some tasks."""
        return Rollout(*(None if values is None else values[tasks] for values in self))


@torch.no_grad()
def collect(
    environment: Dynamics,
    tasks: Float[Tensor, "task task_dim"],
    params: Params,
    episodes: int,
    random: torch.Generator,
) -> Rollout:
    """Execute pi_theta on every task (Algorithm 1, lines 6 and 8) and return its episodes.

    ``params`` is one set for all tasks or one per task; ``random`` is a CPU generator whatever the
    device, so a GPU draws the same numbers. The batch ends with its longest episode.
    """
    shape = (len(tasks), episodes, environment.horizon, environment.action_dim)
    noise = torch.randn(shape, generator=random).to(tasks.device)
    anywhere = tasks.new_zeros(
        len(tasks), 1, environment.state_dim
    )  # sigma is the same in all states
    sigma = distribution(params, anywhere).log_sigma.exp()  # (task, 1, action)
    noise = noise * sigma[:, :, None]  # (task, episode, time, action)

    def act(seen: States, time: int) -> Actions:
        return mean(params, seen) + noise[:, :, time]

    return follow(environment, tasks, act, episodes, random)


@torch.no_grad()
def follow(
    environment: Dynamics,
    tasks: Float[Tensor, "task task_dim"],
    act: Callable[[States, int], Actions],
    episodes: int,
    random: torch.Generator,
) -> Rollout:
    """Return the episodes of whatever ``act`` does: it takes what is seen and the time index."""
    steps: list[tuple[Tensor, ...]] = []
    with torch.inference_mode():  # the cheapest way through a hundred small steps
        states = environment.reset(tasks, episodes, random)
        seen = environment.observe(states)
        alive = torch.ones(len(tasks), episodes, device=tasks.device)
        for time in range(environment.horizon):
            actions = act(seen, time)
            moved = environment.step(tasks, states, actions, time)
            steps.append((seen, actions, moved.rewards, alive, moved.success * alive))
            alive = alive * ~moved.terminated
            states = moved.states
            seen = environment.observe(states)
            if not alive.any():
                break
    parts = (torch.stack(part, dim=2) for part in zip(*steps, strict=True))
    states, actions, rewards, mask, success = parts
    taken = mask[..., None]
    return Rollout(states * taken, actions * taken, rewards * mask, mask, success.any(-1))


def episode_returns(rollout: Rollout) -> Float[Tensor, "task episode"]:
    """Return the undiscounted sum of rewards of each episode."""
    return rollout.rewards.sum(-1)


def first_to_end(rollout: Rollout, count: int) -> Rollout:
    """Return the ``count`` episodes of every task that ended first; of equals, the first drawn.

    The released code starts 30 episodes in parallel and learns from the first 20 that are done:
    where reaching the goal ends an episode, the rewarded ones are favoured.
    """
    lengths = rollout.mask.sum(-1)  # (task, episode)
    if count >= lengths.shape[1]:
        return rollout
    kept = lengths.argsort(dim=-1, stable=True)[:, :count]
    task = torch.arange(len(kept), device=kept.device)[:, None]
    return Rollout(*(None if values is None else values[task, kept] for values in rollout))


def pack(rollout: Rollout) -> Rollout:
    """Move every task's taken steps to the front and cut the rest, so no work is spent on padding.

    The result has the axes (task, 1, sample, dim): the losses, which are means over the steps of a
    task, do not change.
    """
    taken = rollout.mask.flatten(1)  # (task, sample)
    longest = int(taken.sum(-1).max())
    return gather(rollout, taken.argsort(dim=-1, descending=True, stable=True)[:, :longest])


def subsample(rollout: Rollout, count: int, random: torch.Generator) -> Rollout:
    """Draw ``count`` taken steps of every task with replacement, axes (task, 1, sample, dim)."""
    taken = rollout.mask.flatten(1).cpu()  # (task, sample)
    chosen = torch.multinomial(taken, count, replacement=True, generator=random)
    return gather(rollout, chosen.to(rollout.mask.device))


def gather(rollout: Rollout, order: Int[Tensor, "task sample"]) -> Rollout:
    """Return the steps at ``order``, indices into the joined episode and time axes."""
    task = torch.arange(len(order), device=order.device)[:, None]

    def pick(values: Tensor | None) -> Tensor | None:
        return None if values is None else values.flatten(1, 2)[task, order][:, None]

    return Rollout(
        states=pick(rollout.states),
        actions=pick(rollout.actions),
        rewards=pick(rollout.rewards),
        mask=pick(rollout.mask),
        success=rollout.success,
        advantages=pick(rollout.advantages),
    )

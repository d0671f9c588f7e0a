"""Episodes driven over ROS as a Rollout, kept on disk as they end, whatever becomes of the robot."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

from ..archives import read_arrays, write_arrays
from ..policy import Params, distribution, has_task_axis, to_vector
from ..rollout import Rollout
from ..storage import check_target
from ..validation import InputError, ends_in, positive_count
from .driver import Driver
from .errors import RobotError

WHAT = "file of driven episodes"
ARRAYS = ("states", "actions", "rewards", "lengths", "success", "policy")


class Episode(NamedTuple):
    """One driven episode."""

    states: np.ndarray
    """What the policy saw before each step, (time, state)."""
    actions: np.ndarray
    """What it drew, before clipping, (time, action)."""
    rewards: np.ndarray
    """What followed, (time)."""
    success: bool
    """Whether it reached the goal."""


def collect_driven(
    driver: Driver, params: Params, episodes: int, out: Path, random: torch.Generator
) -> Rollout:
    """Let one policy drive until ``out`` (.npz) holds ``episodes`` episodes; returns them as one task.

    Each finished episode is written at once, so a robot that fails costs one: its RobotError says how
    many are kept, and the same call goes on after them. A file of another policy raises InputError.
    """
    positive_count("episodes", episodes)
    ends_in("out", check_target("out", out), ".npz")
    mark = fingerprint(params)
    kept = load_episodes(out, mark) if Path(out).exists() else []
    for _ in kept:  # as if they had been drawn now, so the next are not the same again
        _noise(driver, random)
    while len(kept) < episodes:
        try:
            kept.append(drive_episode(driver, params, random))
        except RobotError as error:
            held = (
                f"{len(kept)} finished episodes are kept in {out}" if kept else "none was finished"
            )
            raise type(error)(f"{error}; {held}") from error
        save_episodes(out, kept, mark)
    return as_rollout(kept[:episodes])


@torch.no_grad()
def drive_episode(driver: Driver, params: Params, random: torch.Generator) -> Episode:
    """Drive one episode with actions drawn from the policy."""
    noise = _noise(driver, random)
    steps: list[tuple[np.ndarray, np.ndarray, float]] = []
    seen, info = driver.reset()
    ended = False
    while not ended:
        gaussian = distribution(params, torch.from_numpy(seen)[None, None])
        drawn = gaussian.mean + gaussian.log_sigma.exp() * noise[len(steps)]
        action = drawn[0, 0].numpy()
        after, reward, terminated, truncated, info = driver.step(action)
        steps.append((seen, action, reward))
        seen, ended = after, terminated or truncated
    states, actions, rewards = (
        np.array(part, dtype=np.float32) for part in zip(*steps, strict=True)
    )
    return Episode(states, actions, rewards, info["success"])


def as_rollout(episodes: list[Episode]) -> Rollout:
    """Return episodes of one task in one batch, (1, episode, time), zero after their ends."""
    longest = max(len(episode.rewards) for episode in episodes)

    def padded(parts: list[np.ndarray]) -> torch.Tensor:
        whole = np.zeros((len(parts), longest, *parts[0].shape[1:]), dtype=np.float32)
        for place, part in zip(whole, parts, strict=True):
            place[: len(part)] = part
        return torch.from_numpy(whole)[None]

    return Rollout(
        states=padded([episode.states for episode in episodes]),
        actions=padded([episode.actions for episode in episodes]),
        rewards=padded([episode.rewards for episode in episodes]),
        mask=padded([np.ones_like(episode.rewards) for episode in episodes]),
        success=torch.tensor([[episode.success for episode in episodes]]),
    )


def fingerprint(params: Params) -> np.ndarray:
    """Return 32 bytes that tell policies apart; per-task parameters raise InputError unless of one task."""
    if has_task_axis(params) and len(params["weight_0"]) != 1:
        raise InputError(f"params: expected one policy, got {len(params['weight_0'])}")
    content = to_vector(params).detach().cpu().numpy().tobytes()
    return np.frombuffer(hashlib.sha256(content).digest(), dtype=np.uint8)


def save_episodes(path: Path, episodes: list[Episode], mark: np.ndarray) -> None:
    """Write episodes and the fingerprint of their policy."""
    joined = {
        name: np.concatenate([getattr(episode, name) for episode in episodes])
        for name in ("states", "actions", "rewards")
    }
    lengths = np.array([len(episode.rewards) for episode in episodes], dtype=np.int64)
    success = np.array([episode.success for episode in episodes])
    write_arrays(path, {**joined, "lengths": lengths, "success": success, "policy": mark})


def load_episodes(path: Path, mark: np.ndarray | None = None) -> list[Episode]:
    """Read episodes; raises InputError for a damaged file, or one of a policy other than ``mark``'s."""
    arrays = read_arrays(path, WHAT, ARRAYS)
    lengths, steps = arrays["lengths"], len(arrays["rewards"])
    kinds = {
        "states": ("f", 2), "actions": ("f", 2), "rewards": ("f", 1),
        "lengths": ("i", 1), "success": ("b", 1), "policy": ("u", 1),
    }  # fmt: skip
    for name, (kind, axes) in kinds.items():
        array = arrays[name]
        if array.dtype.kind != kind or array.ndim != axes or not np.isfinite(array).all():
            raise InputError(
                f"{path}: {name}: expected finite numbers of kind {kind!r} on {axes} axes, got "
                f"{array.dtype} of shape {array.shape}"
            )
    same = len(arrays["states"]) == len(arrays["actions"]) == steps
    whole = (
        len(lengths) == len(arrays["success"]) and (lengths > 0).all() and lengths.sum() == steps
    )
    if not same or not whole:
        raise InputError(
            f"{path}: expected episodes of {steps} steps in all, got {lengths.tolist()}"
        )
    if mark is not None and not np.array_equal(arrays["policy"], mark):
        raise InputError(f"{path}: holds episodes of another policy; choose another file")
    cuts = np.cumsum(lengths)[:-1]
    parts = (np.split(arrays[name], cuts) for name in ("states", "actions", "rewards"))
    return [Episode(*part, bool(won)) for *part, won in zip(*parts, arrays["success"], strict=True)]


def _noise(driver: Driver, random: torch.Generator) -> torch.Tensor:
    """Return the standard normal noise of one episode, (time, action)."""
    return torch.randn(driver.environment.horizon, driver.environment.action_dim, generator=random)

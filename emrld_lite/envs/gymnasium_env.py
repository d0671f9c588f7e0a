"""The thin shell that makes any of our batched environments a standard ``gymnasium.Env``."""

from __future__ import annotations

from typing import Any, ClassVar

import gymnasium
import numpy as np
import torch

from ..validation import InputError, check_choice
from .base import Environment
from .drawing import Window


class SingleEpisode(gymnasium.Env):
    """One episode of one task of a batched environment, through the very same functions.

    ``reset(options={"task": values})`` chooses the task; without it a task is drawn from the test
    distribution. ``info["task"]`` holds the task and ``info["success"]`` whether the goal was reached.
    Actions are those of a policy, in [-1, 1]. An action that is not finite or has the wrong shape
    raises InputError.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array", "human"], "render_fps": 20}

    def __init__(self, environment: Environment, render_mode: str | None = None) -> None:
        if render_mode is not None:
            check_choice("render mode", render_mode, self.metadata["render_modes"])
        self.environment = environment
        self.render_mode = render_mode
        self._window: Window | None = None
        self.observation_space = gymnasium.spaces.Box(
            np.array(environment.observation_low, dtype=np.float32),
            np.array(environment.observation_high, dtype=np.float32),
            dtype=np.float32,
        )
        self.action_space = gymnasium.spaces.Box(
            -1.0, 1.0, (environment.action_dim,), dtype=np.float32
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode; returns the first observation (state,) and its info."""
        super().reset(seed=seed)
        chosen = (options or {}).get("task")
        if chosen is None:
            self._task = self.environment.sample_tasks(1, self.np_random)
        else:
            values = np.asarray(chosen, dtype=np.float32).reshape(1, -1)
            self._task = self.environment.check_tasks(torch.from_numpy(values))
        start = torch.Generator().manual_seed(int(self.np_random.integers(2**63)))
        self._states = self.environment.reset(self._task, 1, start)
        self._time, self._path = 0, [self._states[0, 0]]
        self._show()
        return self._observation(), self._info(success=False)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Act once; returns observation, reward, terminated, truncated, info."""
        values = np.asarray(action, dtype=np.float32)
        if values.shape != self.action_space.shape or not np.isfinite(values).all():
            raise InputError(
                f"action: expected {self.action_space.shape} finite numbers, got {action!r}"
            )
        if self._time >= self.environment.horizon:
            raise InputError(f"the episode ended after {self._time} steps: call reset first")
        actions = torch.from_numpy(values).reshape(1, 1, -1)
        moved = self.environment.step(self._task, self._states, actions, self._time)
        self._states, self._time = moved.states, self._time + 1
        self._path.append(self._states[0, 0])
        self._show()
        truncated = self._time >= self.environment.horizon
        info = self._info(success=bool(moved.success))
        return self._observation(), float(moved.rewards), bool(moved.terminated), truncated, info

    def render(self) -> np.ndarray | None:
        """Return the picture of "rgb_array", (480, 480, 3), uint8; with "human" it is on the screen."""
        if self.render_mode != "rgb_array":
            return None
        if not hasattr(self, "_path"):
            raise InputError("render: call reset first")
        return self._picture()

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
            self._window = None

    def _picture(self) -> np.ndarray:
        return self.environment.picture(self._task[0], torch.stack(self._path))

    def _show(self) -> None:
        """With "human", put the picture on the screen."""
        if self.render_mode == "human":
            self._window = self._window or Window(self.environment.name)
            self._window.show(self._picture())

    def _observation(self) -> np.ndarray:
        return self.environment.observe(self._states[0, 0]).numpy().copy()

    def _info(self, success: bool) -> dict[str, Any]:
        return {"task": self._task[0].numpy().copy(), "success": success}

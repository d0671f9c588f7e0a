"""The simulated TurtleBot by itself: what its firmware does with commands, and its physics. No ROS."""

from __future__ import annotations

import math
import threading
from typing import NamedTuple

import mujoco
import numpy as np

from ..envs.turtlebot import DRIFT_LIMIT, READING_STEPS
from ..envs.turtlebot_body import (
    OMEGA_MAX,
    PHYSICS_STEP,
    V_MAX,
    Hardware,
    Odometry,
    turtlebot_model,
    wheel_speeds,
)
from ..validation import real_number, seed_number

WATCHDOG = 1.0  # seconds without a command, after which the wheels stop
STAND_STILL = (0.0, 0.0)


def clamped(v: float, omega: float) -> tuple[float, float]:
    """Return a command within what the robot's firmware allows, m/s and rad/s."""
    return min(max(v, -V_MAX), V_MAX), min(max(omega, -OMEGA_MAX), OMEGA_MAX)


class Command(NamedTuple):
    """Wheel speeds and the step of the physics from which on they act."""

    due: int
    wheels: np.ndarray


class SimulatedRobot:
    """One TurtleBot in MuJoCo that guards itself; safe to command from another thread.

    Speeds are clamped. A command that is not finite stops it. So does hearing nothing for WATCHDOG
    seconds of its own time, and so do commands from two callers within this time, until one of them is
    silent for as long. ``bias`` turns it, unseen, while it follows a command; told to stand still it does.
    """

    def __init__(self, hardware: Hardware | None = None, bias: float = 0.0, seed: int = 0) -> None:
        self.hardware = hardware or Hardware()
        self.bias = real_number("bias", bias, -DRIFT_LIMIT, DRIFT_LIMIT)
        self._model = turtlebot_model(self.hardware)
        self._data = mujoco.MjData(self._model)
        random = np.random.default_rng(seed_number("seed", seed))
        self._odometry = Odometry(1, self.hardware, random)
        self._steps = 0
        self._coming: list[Command] = []
        self._heard: float | None = (
            None  # when the last command came, unless the wheels were stopped since
        )
        self._movers: dict[str, float] = {}  # caller: when it last commanded a motion
        self._lock = threading.Lock()

    @property
    def time(self) -> float:
        """Seconds that it has lived."""
        return self._steps * PHYSICS_STEP

    @property
    def seen(self) -> np.ndarray:
        """x, y and heading by its odometry."""
        return self._odometry.seen[0]

    @property
    def true(self) -> np.ndarray:
        """x, y and heading as they are."""
        return self._odometry.true[0]

    @property
    def fallen(self) -> bool:
        """Whether it lies on its side."""
        return bool(self._odometry.fallen[0])

    def command(self, v: float, omega: float, caller: str = "") -> str | None:
        """Take a command in m/s and rad/s; returns why it stopped instead, or None."""
        with self._lock:
            if not (math.isfinite(v) and math.isfinite(omega)):
                self._stop()
                return f"{caller or 'somebody'} commands v {v}, omega {omega}: not finite"
            since = self.time - WATCHDOG
            self._movers = {who: when for who, when in self._movers.items() if when > since}
            self._movers.pop(caller, None)
            if (v, omega) != STAND_STILL:
                self._movers[caller] = self.time
            if len(self._movers) > 1:
                self._stop()
                return f"{len(self._movers)} drivers at once: {', '.join(sorted(self._movers))}"
            self._heard = self.time
            if (v, omega) == STAND_STILL:
                self._stop()
                return None
            v, omega = clamped(v, clamped(v, omega)[1] + self.bias)
            self._send(wheel_speeds(np.array([v]), np.array([omega]))[0])
            return None

    def stop(self) -> None:
        """Stop the wheels."""
        with self._lock:
            self._stop()

    def advance(self) -> str | None:
        """Drive until the next reading of the odometry; returns why it stopped, if it did just now."""
        with self._lock:
            why = None
            if self._heard is not None and self.time - self._heard >= WATCHDOG:
                self._stop()
                why = f"no command for {WATCHDOG} s"
            for _ in range(READING_STEPS):
                while self._coming and self._coming[0].due <= self._steps:
                    self._data.ctrl[:] = self._coming.pop(0).wheels
                mujoco.mj_step(self._model, self._data)
                self._steps += 1
            self._odometry.read(self._data.qpos[None], READING_STEPS * PHYSICS_STEP)
            return why

    def _stop(self) -> None:
        self._heard = None
        self._send(np.zeros(2))

    def _send(self, wheels: np.ndarray) -> None:
        self._coming.append(Command(self._steps + self.hardware.delay_steps, wheels))

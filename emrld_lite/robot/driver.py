"""An environment that drives a TurtleBot over ROS, simulated or real: /odom in, /cmd_vel out."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import gymnasium
import numpy as np
import torch

from ..envs.two_wheeled import ARENA, HORIZON, sparse_reward, velocities
from ..envs.two_wheeled_drift import DRIFT_GOAL, TwoWheeledDrift
from ..validation import InputError, real_number
from .errors import RobotError, RobotSilent, TwoDrivers
from .node import COMMANDS, ODOMETRY
from .odometry import Limits, Odometer, Reading, reading_of, relative
from .ros import join
from .simulated import STAND_STILL, clamped
from .watch import Watch

NAME = "emrld_driver"
LAST_COMMAND = 0.1  # seconds that the wheels' last command gets to leave before the topic is left
TURN_AROUND = 1.0  # seconds by the robot's clock that a command stays in force after its step


class Driver(gymnasium.Env):
    """TwoWheeledDrift's task on a robot that is reached by callbacks alone.

    A reset stops the robot, and takes where it stands, and where it looks, as the origin; ``carry``,
    if given, is called before, so that a person can bring it back. A step commands it, waits for the
    first odometry that is dT newer than the command, and pays by it. Each reading repeats the command,
    since firmware stops a robot that hears nothing for half a second; a command ends by itself
    TURN_AROUND after its step. ``info`` has the seconds from command to reading ("period") and from the
    observation that the policy saw to the command ("delay"), by the robot's clock.

    ``bias``, rad/s, is added to every angular velocity, unseen by the policy: for a real robot, which
    does not drift by itself; ``topics`` are its odometry and its commands. After a RobotError, and at
    the end of every episode, the robot is told to stand still; a new reset begins anew. One driver per
    program and per robot; close it after use.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}
    _open: ClassVar[threading.Lock] = threading.Lock()  # held by the one driver of this program

    def __init__(
        self,
        environment: TwoWheeledDrift | None = None,
        limits: Limits | None = None,
        bias: float = 0.0,
        carry: Callable[[], None] | None = None,
        topics: tuple[str, str] = (ODOMETRY, COMMANDS),
    ) -> None:
        self.environment = environment or TwoWheeledDrift()
        self.limits = limits or Limits()
        self.bias = real_number("bias", bias, -2.0, 2.0)
        self._carry, self._topics = carry, topics
        high = np.array(self.environment.observation_high, dtype=np.float32)
        self.observation_space = gymnasium.spaces.Box(-high, high, dtype=np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), dtype=np.float32)
        self._ros = join(NAME)
        if not self._open.acquire(blocking=False):
            raise TwoDrivers("this program has another open driver: close it first")
        self._heard = threading.Condition()
        self._odometer = Odometer(self.limits)
        self._command: tuple[float, float] | None = None
        self._last = 0.0  # by this computer's clock, when the last message came
        self._until = 0.0  # by the robot's clock, when the command in force ends
        self._state: np.ndarray | None = None
        self._closed = False
        try:
            self._connect()
        except BaseException:
            self._open.release()
            raise

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Stop, let the robot be carried, take its place as the origin; returns the observation there."""
        super().reset(seed=seed)
        self._state = None
        with self._stopping():
            self.stop()
            if self._carry is not None:
                self._carry()
            with self._heard:
                self._odometer.forget()
            first = self._wait(None)
            self._wait(first.stamp + self.limits.period)  # the robot comes to rest
            with self._heard:
                self._odometer.set_origin()
                self._seen = self._odometer.newest
        self._time, self._state = 0, np.zeros(3, dtype=np.float32)
        return self._observation(), {"success": False}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Drive for dT; returns observation, reward, terminated, truncated, info.

        Raises a RobotError that says what was waited for, after telling the robot to stand still.
        """
        with self._stopping():
            values = np.asarray(action, dtype=np.float32)
            if values.shape != (2,) or not np.isfinite(values).all():
                raise InputError(f"action: expected 2 finite numbers, got {action!r}")
            if self._state is None:
                raise InputError("the episode has ended, or never began: call reset first")
            start = self._send(values)
            reading = self._wait(start.stamp + self.limits.period)
        delay, self._seen = start.stamp - self._seen.stamp, reading
        place = relative(reading, self._odometer.origin)
        self._state = np.array([place.x, place.y, place.heading], dtype=np.float32)
        reward, reached = self._pay()
        self._time += 1
        outside = bool((np.abs(self._state[:2]) > ARENA).any())
        truncated = self._time >= HORIZON
        observation = self._observation()
        if reached or outside or truncated:
            self._state = None
            self.stop()
        info = {"success": reached, "period": reading.stamp - start.stamp, "delay": delay}
        return observation, reward, reached or outside, truncated, info

    def stop(self) -> None:
        """Tell the robot to stand still."""
        with self._heard:
            self._command = None
            if not self._closed:
                self._publish(*STAND_STILL)

    def close(self) -> None:
        """Tell the robot to stand still and leave the topics."""
        if self._closed:
            return
        self._state = None
        self.stop()
        time.sleep(LAST_COMMAND)
        self._leave()
        self._open.release()

    def _connect(self) -> None:
        """Find the robot; raises RobotSilent where none is, TwoDrivers where it has a driver."""
        rospy = self._ros.rospy
        odometry, commands = self._topics
        self._watch = Watch(rospy.get_name(), self.limits.patience, commands, odometry)
        self._publisher = rospy.Publisher(commands, self._ros.Twist, queue_size=1)
        self._subscriber = rospy.Subscriber(
            odometry, self._ros.Odometry, self._take, queue_size=100
        )
        try:
            self._wait(None)
            deadline = time.monotonic() + self.limits.patience
            while not self._publisher.get_num_connections():
                if time.monotonic() > deadline:
                    raise RobotSilent(
                        f"waited {self.limits.patience:.1f} s: nobody listens to {commands}"
                    )
                time.sleep(0.02)
        except BaseException:
            self._leave()
            raise
        rospy.on_shutdown(self.stop)

    def _leave(self) -> None:
        """Leave the topics."""
        self._closed = True
        self._watch.close()
        self._subscriber.unregister()
        self._publisher.unregister()

    def _take(self, message: Any) -> None:
        """Take one message of odometry, in the thread of the callbacks, and repeat the command."""
        with self._heard:
            self._last = time.monotonic()
            try:
                fresh = self._odometer.add(reading_of(message), time.time())
            except RobotError as error:
                self._odometer.failure, fresh = error, False
            if fresh and self._command is not None:
                if self._odometer.newest.stamp > self._until:
                    self._command = None
                    self._publish(*STAND_STILL)
                else:
                    self._publish(*self._command)
            self._heard.notify_all()

    def _send(self, action: np.ndarray) -> Reading:
        """Command a policy's action; returns the newest reading then."""
        limits = self.environment.v_limit, self.environment.omega_limit
        v, omega = velocities(torch.from_numpy(action), *limits).tolist()
        with self._heard:
            newest = self._odometer.newest
            assert newest is not None
            self._odometer.take(newest.stamp)
            self._command = clamped(v, omega + self.bias)
            self._until = newest.stamp + self.limits.period + TURN_AROUND
            self._publish(*self._command)
            return newest

    def _wait(self, target: float | None) -> Reading:
        """Return the first reading at or after ``target`` by the robot's clock, or the next one at all."""
        begun = self._last = time.monotonic()
        with self._heard:
            self._odometer.listen()
            while True:
                self._watch.check()
                reading = self._odometer.take(-np.inf if target is None else target)
                if reading is not None:
                    return reading
                now = time.monotonic()
                waited = now - begun
                if waited > self.limits.patience:
                    raise self._odometer.why_not(target or 0.0, waited, quiet=now - self._last)
                self._heard.wait(0.1)

    def _publish(self, v: float, omega: float) -> None:
        twist = self._ros.Twist()
        twist.linear.x, twist.angular.z = v, omega
        self._publisher.publish(twist)

    def _pay(self) -> tuple[float, bool]:
        """Return the reward of the state and whether it is the goal."""
        state, goal = torch.from_numpy(self._state), torch.tensor(DRIFT_GOAL)
        reward, reached = sparse_reward(state, goal, self._time, self.environment.reached_box)
        return float(reward), bool(reached)

    def _observation(self) -> np.ndarray:
        return self.environment.observe(torch.from_numpy(self._state)).numpy().copy()

    @contextmanager
    def _stopping(self) -> Iterator[None]:
        """Stop the robot and end the episode on any error, Ctrl-C included."""
        try:
            yield
        except BaseException:
            self._state = None
            self.stop()
            raise

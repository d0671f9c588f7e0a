"""The simulated TurtleBot as a ROS node: publishes /odom, takes /cmd_vel, in real time or faster."""

from __future__ import annotations

import logging
import time
from typing import Any

import numpy as np

from ..envs.turtlebot import READING_STEPS
from ..envs.turtlebot_body import PHYSICS_STEP
from ..validation import real_number
from .errors import MasterGone
from .ros import join
from .simulated import SimulatedRobot
from .watch import Watch

ODOMETRY, COMMANDS = "/odom", "/cmd_vel"
TICK = READING_STEPS * PHYSICS_STEP  # seconds of simulated time
TICKS_PER_MESSAGE = 2  # so 20 messages of odometry per second
LARGEST_PACE = 100.0
WITHOUT_MASTER = 2.0  # seconds by the clock, after which the robot stops
LAST_WORDS = 1.0  # seconds of simulated time that it goes on to publish, stopped
BEHIND = 0.2  # seconds by the clock; what a busy machine loses beyond it is not caught up with
NAME = "emrld_robot"

logger = logging.getLogger(__name__)


class RobotNode:
    """A simulated robot on ROS.

    It lives ``pace`` seconds per second by the clock; the time stamps of its odometry start at the
    computer's time and go on at its own.
    """

    def __init__(self, robot: SimulatedRobot, pace: float = 1.0) -> None:
        self.robot, self.pace = robot, real_number("pace", pace, 0.01, LARGEST_PACE)
        self._ros = join(NAME)
        rospy = self._ros.rospy
        self._born = time.time()
        self._said: str | None = None
        self._watch = Watch(rospy.get_name(), WITHOUT_MASTER)
        self._before = robot.seen.copy()
        self._odometry = rospy.Publisher(ODOMETRY, self._ros.Odometry, queue_size=100)
        self._commands = rospy.Subscriber(COMMANDS, self._ros.Twist, self._command, queue_size=10)

    def run(self, seconds: float | None = None) -> None:
        """Drive for ``seconds`` of simulated time, or until ROS shuts down.

        Raises MasterGone when the master is gone, after the robot has stopped.
        """
        due = time.monotonic()
        while not self._ros.rospy.is_shutdown():
            if seconds is not None and self.robot.time >= seconds:
                return
            try:
                self._watch.check()
            except MasterGone as error:
                self._end(error)
            self._live()
            due = max(due + TICKS_PER_MESSAGE * TICK / self.pace, time.monotonic() - BEHIND)
            time.sleep(max(0.0, due - time.monotonic()))

    def close(self) -> None:
        """Leave the topics."""
        self._watch.close()
        self._commands.unregister()
        self._odometry.unregister()

    def _live(self) -> None:
        """Live until the next message, and send it."""
        for _ in range(TICKS_PER_MESSAGE):
            if why := self.robot.advance():
                logger.warning("stopped: %s", why)
        self._odometry.publish(self._message())

    def _end(self, error: MasterGone) -> None:
        """Stop, and be seen to."""
        self._commands.unregister()
        until = self.robot.time + LAST_WORDS
        while self.robot.time < until:
            self.robot.stop()
            self._live()
            time.sleep(TICKS_PER_MESSAGE * TICK / self.pace)
        raise MasterGone(f"stopped: {error}") from error

    def _command(self, twist: Any) -> None:
        """Hand a command to the robot; each new reason to stop is logged once."""
        caller = twist._connection_header.get("callerid", "somebody")
        why = self.robot.command(twist.linear.x, twist.angular.z, caller)
        if why is not None and why != self._said:
            logger.warning("stopped: %s", why)
        self._said = why

    def _message(self) -> Any:
        """Return the odometry of now."""
        message = self._ros.Odometry()
        message.header.stamp = self._ros.rospy.Time.from_sec(self._born + self.robot.time)
        message.header.frame_id, message.child_frame_id = "odom", "base_footprint"
        x, y, heading = (float(value) for value in self.robot.seen)
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z = float(np.sin(heading / 2.0))
        message.pose.pose.orientation.w = float(np.cos(heading / 2.0))
        dx, dy, turned = (self.robot.seen - self._before) / (TICKS_PER_MESSAGE * TICK)
        self._before = self.robot.seen.copy()
        message.twist.twist.linear.x = float(dx * np.cos(heading) + dy * np.sin(heading))
        message.twist.twist.angular.z = float(turned)
        return message

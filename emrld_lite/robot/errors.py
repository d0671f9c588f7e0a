"""What can go wrong with a robot that other programs drive; every message says for what was waited."""

from __future__ import annotations

from ..validation import InputError, one_line


class RosMissing(InputError):
    """ROS is not installed here; the message says what to install."""


class RobotError(ConnectionError):
    """The robot cannot be driven on; its wheels were told to stop."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class RobotSilent(RobotError):
    """No odometry came, or nobody listened to the commands."""


class StaleOdometry(RobotError):
    """Odometry came whose time stamps do not advance, or that is too old."""


class LateOdometry(RobotError):
    """Odometry came and advanced, but too slowly to reach the end of the control step."""


class LostOdometry(RobotError):
    """Too much odometry is missing between two readings."""


class UnusableOdometry(RobotError):
    """Odometry came that is no pose: not finite, or not a rotation."""


class MasterGone(RobotError):
    """No ROS master answers."""


class TwoDrivers(RobotError):
    """Somebody else drives, too."""


class TwoRobots(RobotError):
    """Two robots publish the same odometry."""

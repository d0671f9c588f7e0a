"""Odometry as it arrives: poses relative to an origin, and readings that are stale, late or lost.

Nothing here knows ROS or reads a clock. Two clocks are kept apart: time stamps are the robot's own,
which a simulated robot may let run faster, and patience is by the clock of whoever waits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..envs.two_wheeled import TIME_STEP
from ..validation import real_number
from .errors import (
    LateOdometry,
    LostOdometry,
    RobotError,
    RobotSilent,
    StaleOdometry,
    UnusableOdometry,
)

ROUNDING = 0.005  # seconds by which a reading may come early and still end the control step


@dataclass(frozen=True)
class Limits:
    """How long to wait for a robot, and what to accept; raises InputError for what cannot be."""

    period: float = TIME_STEP
    """dT, the seconds of a control step, by the robot's clock."""
    patience: float = 3.0
    """Seconds to wait for the end of a step or for the master, by the driver's clock."""
    gap: float = 0.3
    """Longest time without a reading within a step, seconds by the robot's clock."""
    age: float | None = None
    """Oldest reading to accept, seconds; only where robot and driver have the same clock (NTP, say)."""

    def __post_init__(self) -> None:
        real_number("period", self.period, 0.01, 60.0)
        real_number("patience", self.patience, 0.01, 3600.0)
        real_number("gap", self.gap, 0.01, 60.0)
        if self.age is not None:
            real_number("age", self.age, 0.0, 3600.0)


class Reading(NamedTuple):
    """One message of /odom."""

    stamp: float
    """Seconds by the robot's clock."""
    x: float
    y: float
    heading: float
    """Radians, within half a turn until ``Odometer`` unwraps it."""


def reading_of(message: Any) -> Reading:
    """Return what a nav_msgs/Odometry says; raises UnusableOdometry for what is no pose."""
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    w, x, y, z = turn.w, turn.x, turn.y, turn.z
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if not math.isfinite(place.x + place.y) or not abs(length - 1.0) < 0.1:
        raise UnusableOdometry(
            "odometry: expected finite x, y and a rotation of length 1, got "
            f"x {place.x!r}, y {place.y!r}, orientation ({x!r}, {y!r}, {z!r}, {w!r})"
        )
    heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return Reading(message.header.stamp.to_sec(), place.x, place.y, heading)


def relative(reading: Reading, origin: Reading) -> Reading:
    """Return a reading as seen from ``origin``: there (0, 0), looking along x."""
    dx, dy = reading.x - origin.x, reading.y - origin.y
    cosine, sine = math.cos(origin.heading), math.sin(origin.heading)
    return Reading(
        reading.stamp,
        cosine * dx + sine * dy,
        cosine * dy - sine * dx,
        reading.heading - origin.heading,
    )


class Odometer:
    """The readings since the last step; callbacks add to it, and the driver takes states out of it."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.forget()

    def forget(self) -> None:
        """Start anew: the next reading may have any time stamp."""
        self.newest: Reading | None = None
        self.origin: Reading | None = None
        self._kept: list[Reading] = []
        self.failure: RobotError | None = None
        self.listen()

    def listen(self) -> None:
        """Start to count what is heard, for the message should it not be enough."""
        self.fresh = self.stale = 0

    def add(self, reading: Reading, now: float | None = None) -> bool:
        """Take a reading that came at ``now`` (the driver's clock); returns whether it is a newer one.

        One that is not newer counts as stale. One that is too old, or that came after a gap, sets
        ``failure``.
        """
        before = self.newest
        if before is not None and reading.stamp <= before.stamp:
            self.stale += 1
            return False
        age = self.limits.age
        if age is not None and now is not None and now - reading.stamp > age:
            self.failure = StaleOdometry(
                f"odometry: expected readings of the last {age} s, got one that is "
                f"{now - reading.stamp:.2f} s old by this computer's clock"
            )
        if before is not None:
            turned = math.remainder(reading.heading - before.heading, 2.0 * math.pi)
            reading = reading._replace(heading=before.heading + turned)
            gap = reading.stamp - before.stamp
            if gap > self.limits.gap + ROUNDING:
                self.failure = LostOdometry(
                    f"odometry: expected a reading at least every {self.limits.gap} s, got none for "
                    f"{gap:.2f} s by the robot's clock"
                )
        self.fresh += 1
        self.newest = reading
        self._kept.append(reading)
        return True

    def set_origin(self) -> None:
        """Let the newest reading be (0, 0), looking along x."""
        self.origin = self.newest

    def take(self, target: float) -> Reading | None:
        """Return the first reading at or after ``target`` by the robot's clock, forgetting older ones.

        None where it has not come yet; raises what a reading has set as ``failure``.
        """
        if self.failure is not None:
            raise self.failure
        while self._kept and self._kept[0].stamp < target - ROUNDING:
            self._kept.pop(0)
        return self._kept[0] if self._kept else None

    def why_not(self, target: float, waited: float, quiet: float) -> RobotError:
        """Return the error of a wait of ``waited`` seconds in vain, the last ``quiet`` of them in silence."""
        wanted = f"waited {waited:.1f} s for the robot's odometry at {target:.2f} s by its clock"
        if quiet > 0.5 * waited:
            return RobotSilent(
                f"{wanted}: nothing came for the last {quiet:.1f} s; is the robot on, and in reach?"
            )
        if not self.fresh:
            return StaleOdometry(
                f"{wanted}: {self.stale} messages came, none newer than "
                f"{'the first' if self.newest is None else f'{self.newest.stamp:.2f} s'}"
            )
        assert self.newest is not None
        return LateOdometry(
            f"{wanted}: {self.fresh} readings came, the newest of {self.newest.stamp:.2f} s"
        )

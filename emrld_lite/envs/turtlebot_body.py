"""The TurtleBot's body: a differential drive like the TurtleBot3 Burger, as a MuJoCo model.

Two driven wheels and a caster that slides; the wheels are ellipsoids, since a cylinder's edge scrubs when
the robot turns. Sizes and masses are the Burger's (ROBOTIS e-Manual, "Specifications").
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Float, UInt8

from ..validation import real_number
from .rendering import picture

WHEEL_RADIUS = 0.033  # metres
HALF_TRACK = 0.080  # metres from the middle to a wheel
PHYSICS_STEP = 0.005  # seconds
V_MAX, OMEGA_MAX = 0.22, 2.84  # m/s and rad/s, which the robot's own firmware clamps to
SEEN = 3  # x, y and heading, by odometry; a state has the true ones after them
FALLEN = 0.5  # rad off the vertical, from which a robot does not come back
BASE_POSE = (
    7  # where qpos has the free joint: position (3), quaternion (4); the wheels' angles follow
)


@dataclass(frozen=True)
class Hardware:
    """What a real robot has and the kinematic model lacks; raises InputError for what cannot be."""

    friction: float = 1.0
    """Sliding friction between wheels and floor (rubber on wood: about 1); little of it lets them slip."""
    motor_gain: float = 0.05
    """Torque of a motor per error of its wheel's speed, N m s; little of it lets the wheels lag."""
    motor_torque: float = 0.3
    """Largest torque of a motor, N m."""
    delay: float = 0.05
    """Seconds from a command to the motors: radio, driver and firmware."""
    odometry_slide: float = 0.02
    """Deviation of a measured distance, as a share of it."""
    odometry_turn: float = 0.01
    """Deviation of the measured heading after one second, rad; it grows with the root of the time."""

    def __post_init__(self) -> None:
        real_number("friction", self.friction, 0.01, 10.0)
        real_number("motor_gain", self.motor_gain, 0.001, 0.2)
        real_number("motor_torque", self.motor_torque, 0.01, 10.0)
        real_number("delay", self.delay, 0.0, 5.0)
        real_number("odometry_slide", self.odometry_slide, 0.0, 1.0)
        real_number("odometry_turn", self.odometry_turn, 0.0, 1.0)

    @property
    def delay_steps(self) -> int:
        """The delay in steps of the physics."""
        return round(self.delay / PHYSICS_STEP)


@functools.cache
def turtlebot_model(hardware: Hardware) -> mujoco.MjModel:
    """Return the robot on a floor, with motors that hold their wheels' speeds."""
    return mujoco.MjModel.from_xml_string(
        f"""
<mujoco model="turtlebot">
  <compiler angle="radian"/>
  <option timestep="{PHYSICS_STEP}" integrator="implicitfast" cone="elliptic" impratio="10"/>
  <visual><headlight ambient="0.4 0.4 0.4"/></visual>
  <asset>
    <texture name="tiles" type="2d" builtin="checker" rgb1="0.86 0.88 0.9" rgb2="0.78 0.8 0.83"
      width="256" height="256"/>
    <material name="tiles" texture="tiles" texrepeat="10 10"/>
  </asset>
  <default>
    <default class="wheel">
      <joint type="hinge" axis="0 1 0" armature="5e-4" damping="1e-4"/>
      <geom type="ellipsoid" size="{WHEEL_RADIUS} 0.009 {WHEEL_RADIUS}" mass="0.0285" condim="4"
        friction="{hardware.friction} 0.002 0.0001" rgba="0.15 0.15 0.15 1"/>
    </default>
  </default>
  <worldbody>
    <light pos="1 0 4" dir="0 0 -1" directional="true"/>
    <geom name="floor" type="plane" size="4 4 0.1" friction="0 0.001 0.0001" material="tiles"/>
    <camera name="above" pos="1 0.3 5" fovy="45"/>
    <body name="base" pos="0 0 {WHEEL_RADIUS}">
      <freejoint name="base"/>
      <camera name="behind" pos="-0.7 0 0.5" xyaxes="0 -1 0 0.5 0 0.87"/>
      <camera name="side" pos="0.22 -0.3 0.22" xyaxes="0.806 0.591 0 -0.3 0.41 0.86"/>
      <geom name="plates" type="cylinder" pos="-0.032 0 0.05" size="0.069 0.05" mass="0.9"
        contype="0" conaffinity="0" rgba="0.25 0.27 0.3 1"/>
      <geom name="lidar" type="cylinder" pos="-0.032 0 0.125" size="0.035 0.02" mass="0.1"
        contype="0" conaffinity="0" rgba="0.05 0.05 0.05 1"/>
      <geom name="nose" type="box" pos="0.03 0 0.095" size="0.012 0.02 0.006" mass="0.001"
        contype="0" conaffinity="0" rgba="0.84 0.37 0 1"/>
      <geom name="caster" type="sphere" pos="-0.081 0 -0.0225" size="0.0105" mass="0.005"
        friction="0 0 0" condim="1" priority="1"/>
      <body name="left" pos="0 {HALF_TRACK} 0">
        <joint name="left" class="wheel"/>
        <geom class="wheel"/>
      </body>
      <body name="right" pos="0 -{HALF_TRACK} 0">
        <joint name="right" class="wheel"/>
        <geom class="wheel"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <velocity name="left" joint="left" kv="{hardware.motor_gain}"
      forcerange="-{hardware.motor_torque} {hardware.motor_torque}"/>
    <velocity name="right" joint="right" kv="{hardware.motor_gain}"
      forcerange="-{hardware.motor_torque} {hardware.motor_torque}"/>
  </actuator>
</mujoco>"""
    )


def photograph(
    pose: Float[np.ndarray, " 3"], camera: str = "above"
) -> UInt8[np.ndarray, "height width 3"] | None:
    """Return MuJoCo's picture of a robot at x, y, heading, or None where it cannot draw.

    ``camera`` looks from "above", from "behind" or from the "side".
    """
    model = turtlebot_model(Hardware())
    data = mujoco.MjData(model)
    x, y, heading = pose
    data.qpos[:2] = x, y
    data.qpos[3], data.qpos[6] = math.cos(heading / 2), math.sin(heading / 2)
    mujoco.mj_forward(model, data)
    return picture(model, data, camera)


def wheel_speeds(
    v: Float[np.ndarray, "*at"], omega: Float[np.ndarray, "*at"]
) -> Float[np.ndarray, "*at 2"]:
    """Return the speeds of the left and the right wheel, rad/s, for v in m/s and omega in rad/s."""
    across = HALF_TRACK * omega
    return np.stack([v - across, v + across], axis=-1) / WHEEL_RADIUS


def pose_of(qpos: Float[np.ndarray, "*at 9"]) -> Float[np.ndarray, "*at 3"]:
    """Return x, y and heading (within half a turn) of the robot's base."""
    w, x, y, z = np.moveaxis(qpos[..., 3:BASE_POSE], -1, 0)
    heading = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.stack([qpos[..., 0], qpos[..., 1], heading], axis=-1)


def tilt_of(qpos: Float[np.ndarray, "*at 9"]) -> Float[np.ndarray, "*at"]:
    """Return the angle between the robot's axis and the vertical, rad."""
    _, x, y, _ = np.moveaxis(qpos[..., 3:BASE_POSE], -1, 0)
    return np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))


def unwrapped(
    heading: Float[np.ndarray, "*at"], before: Float[np.ndarray, "*at"]
) -> Float[np.ndarray, "*at"]:
    """Return a heading without jumps: the one nearest to ``before`` that differs by whole turns."""
    turn = 2.0 * math.pi
    return heading + turn * np.round((before - heading) / turn)


class Odometry:
    """What robots know of their places: the distance by their wheels, the heading by a gyroscope.

    ``seen`` is what they believe and ``true`` what is so, (robot, 3): x, y in metres, heading in rad,
    which is not wrapped. A wheel that slips measures a distance that nobody drove. A robot that fell
    over, or whose simulation broke, is marked in ``fallen``, and its places stay as they were.
    """

    def __init__(self, count: int, hardware: Hardware, random: np.random.Generator) -> None:
        self.seen, self.true = np.zeros((count, SEEN)), np.zeros((count, SEEN))
        self.fallen = np.zeros(count, dtype=bool)
        self.scale = 1.0 + hardware.odometry_slide * random.standard_normal(count)
        self.turn_noise, self.random = hardware.odometry_turn, random
        self.angles = np.zeros((count, 2))  # of the wheels, at the last reading

    def read(self, qpos: Float[np.ndarray, "robot 9"], seconds: float) -> None:
        """Take one reading, ``seconds`` after the last one."""
        pose, angles = pose_of(qpos), qpos[:, BASE_POSE:].copy()
        broken = ~np.isfinite(qpos).all(-1)
        self.fallen |= broken | (tilt_of(np.where(broken[:, None], 0.0, qpos)) > FALLEN)
        pose[:, 2] = unwrapped(pose[:, 2], self.true[:, 2])
        turned = pose[:, 2] - self.true[:, 2]
        turned += self.turn_noise * np.sqrt(seconds) * self.random.standard_normal(len(turned))
        driven = self.scale * WHEEL_RADIUS * (angles - self.angles).mean(-1)
        middle = self.seen[:, 2] + 0.5 * turned
        moved = np.stack([driven * np.cos(middle), driven * np.sin(middle), turned], axis=-1)
        stands = self.fallen[:, None]
        self.seen = np.where(stands, self.seen, self.seen + moved)
        self.true = np.where(stands, self.true, pose)
        self.angles = np.where(stands, self.angles, angles)

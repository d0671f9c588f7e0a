"""The robot without ROS: poses, stale and lost readings, the robot's own guards, kept episodes."""

import cmath
import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from emrld_lite.__main__ import main
from emrld_lite.adapt import Adaptation, adapt
from emrld_lite.advantage import Score
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.envs.turtlebot import TurtleBot
from emrld_lite.envs.turtlebot_body import OMEGA_MAX, V_MAX, Hardware
from emrld_lite.envs.two_wheeled_drift import TwoWheeledDrift
from emrld_lite.policy import initialise
from emrld_lite.robot import collect, errors, ros
from emrld_lite.robot.odometry import Limits, Odometer, Reading, reading_of, relative
from emrld_lite.robot.simulated import WATCHDOG, SimulatedRobot, clamped
from emrld_lite.storage import DATA
from emrld_lite.validation import InputError

EXACT = Hardware(delay=0.0, odometry_slide=0.0, odometry_turn=0.0)
TICK = 0.025


def message(x=0.0, y=0.0, z=0.0, w=1.0, stamp=0.0):
    """Return what stands in a nav_msgs/Odometry."""
    return SimpleNamespace(
        header=SimpleNamespace(stamp=SimpleNamespace(to_sec=lambda: stamp)),
        pose=SimpleNamespace(
            pose=SimpleNamespace(
                position=SimpleNamespace(x=x, y=y),
                orientation=SimpleNamespace(x=0.0, y=0.0, z=z, w=w),
            )
        ),
    )


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.9, 3.1])
def test_a_message_says_place_and_heading(heading):
    half = heading / 2
    got = reading_of(message(1.5, -0.5, math.sin(half), math.cos(half), stamp=12.25))
    assert got == pytest.approx((12.25, 1.5, -0.5, heading))


@pytest.mark.parametrize(
    "broken", [{"x": math.nan}, {"y": math.inf}, {"w": math.nan}, {"w": 0.0}, {"z": 2.0}]
)
def test_a_message_that_is_no_pose_is_refused(broken):
    with pytest.raises(errors.UnusableOdometry, match="expected finite"):
        reading_of(message(**broken))


def test_a_pose_is_seen_from_the_origin_as_complex_numbers_say():
    random = np.random.default_rng(0)
    for _ in range(20):
        x, y, heading, x0, y0, heading0 = random.uniform(-3, 3, 6)
        got = relative(Reading(1.0, x, y, heading), Reading(0.0, x0, y0, heading0))
        expected = (complex(x, y) - complex(x0, y0)) * cmath.exp(-1j * heading0)
        assert complex(got.x, got.y) == pytest.approx(expected)
        assert got.heading == pytest.approx(heading - heading0)


def heard(stamps, **limits):
    """Return an odometer that has heard readings with these stamps, one metre per second along x."""
    odometer = Odometer(Limits(**limits))
    for stamp in stamps:
        odometer.add(Reading(stamp, stamp, 0.0, 0.0))
    return odometer


def test_the_reading_that_ends_a_step_is_the_first_at_its_end():
    odometer = heard([10.0, 10.2, 10.4, 10.499, 10.6])
    assert odometer.take(10.5).stamp == 10.499  # within the rounding of stamps
    assert odometer.take(10.55).stamp == 10.6
    assert odometer.take(10.7) is None


def test_a_heading_is_unwrapped_over_several_turns():
    odometer = Odometer(Limits())
    true = np.arange(0, 20, 0.3)
    for step, heading in enumerate(true):
        odometer.add(Reading(0.05 * step, 0.0, 0.0, math.remainder(heading, 2 * math.pi)))
    assert odometer.newest.heading == pytest.approx(true[-1])


def test_one_lost_reading_is_nothing_and_a_gap_is_an_error():
    assert heard([0.0, 0.05, 0.15, 0.45]).take(0.4).stamp == 0.45
    with pytest.raises(errors.LostOdometry, match=r"got none for 0\.35 s"):
        heard([0.0, 0.05, 0.40]).take(0.4)


def test_a_reading_that_is_too_old_by_a_shared_clock_is_an_error():
    odometer = Odometer(Limits(age=0.5))
    odometer.add(Reading(100.0, 0.0, 0.0, 0.0), now=100.4)
    assert odometer.take(100.0).stamp == 100.0
    odometer.add(Reading(100.1, 0.0, 0.0, 0.0), now=101.0)
    with pytest.raises(errors.StaleOdometry, match=r"0\.90 s old"):
        odometer.take(100.1)


@pytest.mark.parametrize(
    ("stamps", "quiet", "kind", "words"),
    [
        ([], 3.0, errors.RobotSilent, "nothing came for the last 3.0 s"),
        ([4.1, 4.2], 2.5, errors.RobotSilent, "nothing came for the last 2.5 s"),
        ([4.0, 3.0, 2.0], 0.1, errors.StaleOdometry, "3 messages came, none newer than 4.00 s"),
        ([4.0, 4.01, 4.02], 0.1, errors.LateOdometry, "2 readings came, the newest of 4.02 s"),
    ],
)
def test_a_wait_in_vain_says_what_came_instead(stamps, quiet, kind, words):
    odometer = heard([4.0])
    odometer.listen()
    for stamp in stamps:
        odometer.add(Reading(stamp, 0.0, 0.0, 0.0))
    error = odometer.why_not(4.5, 3.0, quiet)
    assert type(error) is kind
    assert words in str(error) and "waited 3.0 s" in str(error) and "4.50 s" in str(error)


def test_speeds_are_clamped_to_the_firmwares():
    assert clamped(9.0, -7.0) == (V_MAX, -OMEGA_MAX)
    assert clamped(-9.0, 7.0) == (-V_MAX, OMEGA_MAX)
    assert clamped(0.1, 0.2) == (0.1, 0.2)


def test_the_simulated_robot_is_the_environments():
    bias, actions = -0.4, [(1.0, 0.3), (0.2, -0.5), (1.0, 0.0), (-0.5, 0.9)]
    environment, task = TurtleBot(hardware=Hardware(odometry_turn=0.0)), torch.tensor([[bias]])
    states = environment.reset(task, 1, torch.Generator())
    robot = SimulatedRobot(Hardware(odometry_turn=0.0), bias=bias)
    for time, (forward, turn) in enumerate(actions):
        states = environment.step(task, states, torch.tensor([[[forward, turn]]]), time).states
        robot.command((forward + 1) * 0.075, turn * 1.5)
        for _ in range(20):
            robot.advance()
    assert robot.true.tolist() == pytest.approx(states[0, 0, 3:].tolist(), abs=1e-5)


def still_after(robot, seconds):
    """Return the seconds until the robot does not move any more, within ``seconds``."""
    moved = 0.0
    for _ in range(round(seconds / TICK)):
        before = robot.true.copy()
        robot.advance()
        if np.abs(robot.true - before).max() > 1e-3 * TICK:
            moved = robot.time
    return moved


def driving(bias=0.0):
    """Return a robot at full speed."""
    robot = SimulatedRobot(EXACT, bias)
    for _ in range(40):
        robot.command(0.2, 0.0, "driver")
        robot.advance()
    assert robot.true[0] > 0.1
    return robot


@pytest.mark.parametrize("bias", [0.0, -0.65])
def test_it_stops_when_it_hears_nothing(bias):
    robot = driving(bias)
    began = robot.time
    stood = still_after(robot, 3.0) - began
    assert WATCHDOG - 2 * TICK <= stood <= WATCHDOG + 0.5


@pytest.mark.parametrize("command", [(math.nan, 0.0), (0.1, math.inf), (-math.inf, math.nan)])
def test_it_stops_at_a_command_that_is_not_finite(command):
    robot = driving()
    began = robot.time
    assert "not finite" in robot.command(*command, "driver")
    assert still_after(robot, 1.0) - began <= 0.5


def test_it_stops_between_two_drivers_until_one_is_silent():
    robot = driving()
    assert "2 drivers at once: driver, other" in robot.command(0.2, 1.0, "other")
    for _ in range(39):
        assert robot.command(0.1, 0.0, "driver") is not None
        robot.advance()
    assert still_after(robot, 1.0) < robot.time - 0.5
    assert robot.command(0.1, 0.0, "driver") is None


def test_a_driver_that_stopped_makes_room_for_the_next():
    robot = driving()
    robot.command(0.0, 0.0, "driver")
    assert robot.command(0.1, 0.0, "other") is None


def test_told_to_stand_still_it_does_although_it_drifts():
    robot = driving(bias=-0.65)
    robot.command(0.0, 0.0)
    began = robot.time
    assert still_after(robot, 2.0) - began <= 0.5


def test_commands_beyond_the_limits_drive_as_the_limits_do():
    places = []
    for command in ((9.0, 30.0), (V_MAX, OMEGA_MAX)):
        robot = SimulatedRobot(EXACT)
        robot.command(*command)
        for _ in range(20):
            robot.advance()
        places.append(robot.true.tolist())
    assert places[0] == places[1]


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: SimulatedRobot(bias=3.0), "bias"),
        (lambda: SimulatedRobot(seed=-1), "seed"),
        (lambda: Limits(patience=0.0), "patience"),
        (lambda: Limits(gap=math.nan), "gap"),
        (lambda: Limits(age=-1.0), "age"),
        (lambda: Limits(period=0.0), "period"),
    ],
)
def test_what_cannot_be_is_refused(build, words):
    with pytest.raises(InputError, match=words):
        build()


def test_without_ros_a_sentence_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "rospy", None)  # an import of it then fails
    monkeypatch.setattr(ros, "DEBIAN", tmp_path / "none")
    ros.find_ros.cache_clear()
    with pytest.raises(errors.RosMissing, match=r"module rospy is not here.*apt-get install"):
        ros.find_ros()
    ros.find_ros.cache_clear()


def test_a_run_of_another_environment_is_not_driven(tmp_path, capsys):
    run = DATA / "runs" / "point2d-optimal-emrld-seed0"
    with pytest.raises(SystemExit) as stop:
        main(["robot-drive", "--run", str(run), "--out", str(tmp_path)])
    assert stop.value.code == 2
    assert "expected a run of two_wheeled_drift, got point2d" in capsys.readouterr().err


class ScriptedDriver:
    """Stands for a driver: three steps per episode, and a robot that falls silent in one of them."""

    environment = TwoWheeledDrift()

    def __init__(self, silent_in=None):
        self.silent_in, self.episode = silent_in, -1

    def reset(self):
        self.episode, self.time = self.episode + 1, 0
        return np.zeros(3, dtype=np.float32), {"success": False}

    def step(self, action):
        self.time += 1
        if self.episode == self.silent_in and self.time == 2:
            raise errors.RobotSilent("nothing came")
        seen = np.full(3, self.time / 10, dtype=np.float32)
        return seen, float(self.time), self.time == 3, False, {"success": self.time == 3}


PARAMS = initialise(3, 2, 0)


def driven(driver, out, episodes=4):
    return collect.collect_driven(driver, PARAMS, episodes, out, torch.Generator().manual_seed(0))


def test_finished_episodes_are_kept_and_gone_on_with(tmp_path):
    whole = driven(ScriptedDriver(), tmp_path / "whole.npz")
    out = tmp_path / "kept.npz"
    with pytest.raises(errors.RobotSilent, match=r"nothing came; 2 finished episodes are kept in"):
        driven(ScriptedDriver(silent_in=2), out)
    assert len(collect.load_episodes(out)) == 2
    mended = driven(ScriptedDriver(), out)
    assert mended.actions.shape == (1, 4, 3, 2) and mended.success.all()
    assert torch.equal(mended.actions, whole.actions)


def test_a_robot_that_fails_at_once_leaves_no_file(tmp_path):
    with pytest.raises(errors.RobotSilent, match="none was finished"):
        driven(ScriptedDriver(silent_in=0), tmp_path / "none.npz")
    assert list(tmp_path.iterdir()) == []


def test_episodes_of_another_policy_are_refused(tmp_path):
    out = tmp_path / "kept.npz"
    driven(ScriptedDriver(), out)
    with pytest.raises(InputError, match="another policy"):
        collect.load_episodes(out, collect.fingerprint(initialise(3, 2, 1)))


@pytest.mark.parametrize(
    ("field", "value"),
    [("lengths", np.array([3, 4])), ("rewards", np.full(6, np.nan)), ("states", np.zeros(6))],
)
def test_a_damaged_file_is_refused(tmp_path, field, value):
    out = tmp_path / "kept.npz"
    driven(ScriptedDriver(), out, episodes=2)
    arrays = dict(np.load(out)) | {field: value}
    np.savez(out, **arrays)
    with pytest.raises(InputError, match=r"kept\.npz"):
        collect.load_episodes(out)


def test_driven_episodes_adapt_a_policy(tmp_path):
    rollout = driven(ScriptedDriver(), tmp_path / "kept.npz")
    demonstrations = load_demonstrations("optimal", "two_wheeled_drift").take(slice(0, 1))
    adapted = adapt(PARAMS, Score()(rollout), demonstrations, Adaptation(w_rl=1.0, w_bc=1.0))
    assert all(torch.isfinite(value).all() for value in adapted.values())
    assert not torch.equal(adapted["weight_0"][0], PARAMS["weight_0"])

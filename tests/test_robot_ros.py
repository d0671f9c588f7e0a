"""The robot over ROS, with a real master on loopback: it drives, and what goes wrong stops it and is named.

Stated limits: an error at most PATIENCE (or, with the master, PATIENCE and a look) after its cause, and a
robot that stands WATCHDOG seconds of its own time after the last command. Slack is for busy machines.
"""

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env

from emrld_lite.__main__ import main
from emrld_lite.policy import initialise
from emrld_lite.robot import errors, ros
from emrld_lite.robot.collect import collect_driven, load_episodes
from emrld_lite.robot.simulated import WATCHDOG
from emrld_lite.validation import InputError

try:
    ROS = ros.find_ros()
except errors.RosMissing as missing:
    pytest.skip(str(missing), allow_module_level=True)
if shutil.which("rosmaster") is None:
    pytest.skip(f"rosmaster is missing: apt-get install {ros.PACKAGES}", allow_module_level=True)

from emrld_lite.robot.driver import Driver
from emrld_lite.robot.odometry import Limits, Odometer, reading_of, relative
from emrld_lite.storage import DATA

PACE, BIAS = 10.0, -0.65
AHEAD = (1.0, 0.65 / 1.5)  # full speed, steering against the bias
PATIENCE, SLACK = 2.0, 15.0  # seconds by the clock
FAKE = ("/fake/odom", "/fake/cmd_vel")


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def until(holds, seconds=60.0, what="it"):
    """Wait until ``holds()`` is true and return its value."""
    deadline = time.monotonic() + seconds
    while not (value := holds()):
        assert time.monotonic() < deadline, f"waited {seconds} s for {what}"
        time.sleep(0.02)
    return value


def end(process, number=signal.SIGTERM):
    """End a process of ours, and return its exit code."""
    if process.poll() is None:
        process.send_signal(number)
    try:
        return process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def heeding_ctrl_c():
    """Let a process that is about to start end by Ctrl-C, whatever its parent does about it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def surroundings(port, folder):
    """Return the environment variables with which ROS stays on the loopback, and writes into a folder."""
    uri = f"http://127.0.0.1:{port}"
    return {"ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1", "ROS_HOME": str(folder)}


@contextlib.contextmanager
def master_process(port, told):
    """Run a master on a port of the loopback."""
    command, log = ["rosmaster", "--core", "-p", str(port)], subprocess.DEVNULL
    process = subprocess.Popen(command, stdout=log, stderr=log, env={**os.environ, **told})
    try:
        yield process
    finally:
        end(process)


@pytest.fixture(scope="module")
def master(tmp_path_factory):
    """Return the environment variables of a master that answers; this process speaks to it, too."""
    port = free_port()
    told = surroundings(port, tmp_path_factory.mktemp("ros"))
    before = {name: os.environ.get(name) for name in told}
    os.environ.update(told)
    with master_process(port, told):
        until(answers, what="the master")
        ros.join("emrld_driver")  # publishers and subscribers of a test speak through it
        yield dict(os.environ)
        ROS.rospy.signal_shutdown("the tests are over")
    for name, value in before.items():
        os.environ.pop(name) if value is None else os.environ.update({name: value})


def answers():
    with contextlib.suppress(errors.MasterGone):
        return ros.ask(ros.master_uri(), "getPid")


@pytest.fixture(scope="module")
def robot(master, tmp_path_factory):
    """Return the simulated robot, a process of its own, and its log."""
    log = tmp_path_factory.mktemp("robot") / "log.txt"
    command = [sys.executable, "-m", "emrld_lite", "robot-node"]
    command += ["--pace", str(PACE), "--bias", str(BIAS)]
    with log.open("w") as file:
        # a script's background job ignores Ctrl-C, and would hand that on to the node
        process = subprocess.Popen(
            command, stdout=file, stderr=file, env=master, preexec_fn=heeding_ctrl_c
        )
        try:
            until(lambda: "simulated" in log.read_text(), 120.0, "the robot's node")
            process.log = log
            yield process
        finally:
            end(process, signal.SIGKILL)


@contextlib.contextmanager
def driving(topics=("/odom", "/cmd_vel"), **limits):
    driver = Driver(limits=Limits(patience=PATIENCE, **limits), topics=topics)
    try:
        yield driver
    finally:
        driver.close()


@pytest.fixture
def driver(robot):
    with driving(gap=5.0) as driver:  # a busy machine is no lost message
        yield driver


@pytest.fixture
def odometry(robot):
    """Return the messages of /odom as they come: stamp, speed ahead, speed of turning."""
    heard = []

    def take(message):
        twist = message.twist.twist
        heard.append((message.header.stamp.to_sec(), twist.linear.x, twist.angular.z))

    subscriber = ROS.rospy.Subscriber("/odom", ROS.Odometry, take)
    until(lambda: heard, what="odometry")
    yield heard
    subscriber.unregister()


def stands(odometry, seconds=0.5):
    """Wait until the robot has stood still for so long by its own clock."""

    def still():
        since = odometry[-1][0] - seconds
        recent = [row for row in odometry if row[0] >= since]
        noise = 0.3  # rad/s, of a heading that is measured 20 times per second
        return len(recent) > 5 and all(abs(v) < 0.01 and abs(w) < noise for _, v, w in recent)

    until(still, what="the robot to stand")


@pytest.fixture
def commander(robot):
    """Return a function that publishes commands from this process, as a bare driver would."""
    publisher = ROS.rospy.Publisher("/cmd_vel", ROS.Twist, queue_size=10)
    until(publisher.get_num_connections, what="the robot to listen")

    def command(v, omega):
        twist = ROS.Twist()
        twist.linear.x, twist.angular.z = v, omega
        publisher.publish(twist)

    yield command
    command(0.0, 0.0)
    time.sleep(0.1)
    publisher.unregister()


class FakeRobot:
    """Publishes what odometry a test wants, from this process, and hears the commands."""

    def __init__(self):
        self.commands, self.stamps = [], iter(())
        self._closed = threading.Event()
        odometry, commands = FAKE
        self._publisher = ROS.rospy.Publisher(odometry, ROS.Odometry, queue_size=10)
        self._subscriber = ROS.rospy.Subscriber(commands, ROS.Twist, self._hear)
        self.now, self.step, self.orientation, self.lost = 100.0, 0.05, 1.0, 0.0
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _hear(self, twist):
        self.commands.append((twist.linear.x, twist.angular.z))

    def _run(self):
        while not self._closed.wait(0.01):
            message = ROS.Odometry()
            self.now += self.step + self.lost
            self.lost = 0.0
            message.header.stamp = ROS.rospy.Time.from_sec(self.now)
            message.pose.pose.orientation.w = self.orientation
            self._publisher.publish(message)

    def stopped(self):
        until(lambda: self.commands and self.commands[-1] == (0.0, 0.0), what="the stop")

    def close(self):
        self._closed.set()
        self._thread.join()
        self._publisher.unregister()
        self._subscriber.unregister()


@pytest.fixture
def fake(master):
    fake = FakeRobot()
    yield fake
    fake.close()


@contextlib.contextmanager
def raises_within(kind, seconds, words):
    begun = time.monotonic()
    with pytest.raises(kind, match=words) as caught:
        yield caught
    assert time.monotonic() - begun < seconds + SLACK


def drive(driver, action, steps):
    """Drive steps and return the last observation and the robot's seconds, delays included."""
    seconds = 0.0
    for _ in range(steps):
        seen, _, _, _, info = driver.step(np.array(action))
        seconds += info["period"] + info["delay"]
        assert info["period"] >= 0.495
    return seen, seconds


def test_without_a_master_a_sentence_says_so(monkeypatch, capsys):
    """Comes first: once this process speaks to a master, it does not ask again."""
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{free_port()}")
    with pytest.raises(SystemExit) as stop:
        main(["robot-node"])
    assert stop.value.code == 2
    said = capsys.readouterr().err
    assert "rosmaster --core" in said and len(said.splitlines()) == 1, said


def test_it_drives_straight_where_the_policy_steers_against_the_drift(driver):
    seen, _ = driver.reset()
    assert seen.tolist() == [0.0, 0.0, 0.0]
    seen, seconds = drive(driver, AHEAD, 8)
    assert seen[0] == pytest.approx(0.15 * seconds, rel=0.15, abs=0.03)  # less the delay
    assert abs(seen[1]) < 0.1


def test_gymnasium_takes_it_for_an_environment(robot):
    single = gymnasium.make("emrld_lite/TurtleBotOverROS-v0", limits=Limits(gap=5.0))
    try:
        # its check of close() makes a second one, which is refused while the first is open
        check_env(single.unwrapped, skip_render_check=True, skip_close_check=True)
    finally:
        single.close()


def test_every_reset_is_an_origin(driver):
    driver.reset()
    drive(driver, (-1.0, 1.0), 4)  # turn on the spot
    seen, _ = driver.reset()
    assert seen.tolist() == [0.0, 0.0, 0.0]
    seen, _ = drive(driver, AHEAD, 4)
    assert seen[0] > 0.2 and abs(seen[1]) < 0.1


def test_an_ended_episode_and_a_wrong_action_are_refused(driver):
    with pytest.raises(InputError, match="call reset first"):
        driver.step(np.zeros(2))
    driver.reset()
    with pytest.raises(InputError, match="2 finite numbers"):
        driver.step(np.array([np.nan, 0.0]))


def test_the_robot_clamps_its_speeds(commander, odometry):
    begun = len(odometry)
    until(lambda: commander(5.0, 0.0) or odometry[-1][1] > 0.2, what="full speed")
    for _ in range(20):
        commander(5.0, 0.0)
        time.sleep(0.02)
    assert max(v for _, v, _ in odometry[begun:]) < 0.22 * 1.15  # 2 % scale, noise of the heading


def test_it_stands_a_second_after_the_last_command(commander, odometry):
    stands(odometry)
    begun = len(odometry)
    commander(0.2, 0.65)
    until(lambda: odometry[-1][1] > 0.1, what="the robot to move")
    stands(odometry)
    moving = [stamp for stamp, v, _ in odometry[begun:] if v > 0.02]
    assert moving[-1] - moving[0] < WATCHDOG + 0.5


def test_a_command_that_is_not_finite_stops_it(commander, odometry, robot):
    until(lambda: commander(0.2, 0.65) or odometry[-1][1] > 0.1, what="the robot to move")
    deadline = time.monotonic() + 1.0
    while time.monotonic() < deadline:
        commander(float("nan"), 0.0)
        time.sleep(0.01)
    stands(odometry)
    assert "not finite" in robot.log.read_text()


def test_a_robot_that_falls_silent_is_named_and_driven_again(driver, robot, odometry):
    driver.reset()
    drive(driver, AHEAD, 2)
    robot.send_signal(signal.SIGSTOP)
    try:
        with raises_within(errors.RobotSilent, PATIENCE, "nothing came for"):
            for _ in range(5):  # what was under way may still end a step or two
                driver.step(np.array(AHEAD))
    finally:
        robot.send_signal(signal.SIGCONT)
    stands(odometry)
    driver.reset()
    seen, _ = drive(driver, AHEAD, 2)
    assert seen[0] > 0.05


def test_finished_episodes_outlive_the_robot(driver, robot, tmp_path):
    driver.environment = type(driver.environment)(heading=False)
    params, out = initialise(2, 2, 0), tmp_path / "episodes.npz"

    def silence():
        until(out.exists, 120.0, "a finished episode")
        robot.send_signal(signal.SIGSTOP)

    stopping = threading.Thread(target=silence)
    stopping.start()
    try:
        with pytest.raises(errors.RobotSilent, match="finished episodes are kept in"):
            collect_driven(driver, params, 50, out, torch.Generator().manual_seed(0))
    finally:
        stopping.join()
        robot.send_signal(signal.SIGCONT)
    kept = load_episodes(out)
    assert len(kept) >= 1 and all(len(episode.rewards) <= 100 for episode in kept)


def test_stale_odometry(fake):
    with driving(FAKE) as driver:
        driver.reset()
        fake.step = 0.0
        with raises_within(errors.StaleOdometry, PATIENCE, "none newer than"):
            for _ in range(2):
                driver.step(np.array(AHEAD))
        fake.stopped()


def test_late_odometry(fake):
    with driving(FAKE) as driver:
        driver.reset()
        fake.step = 1e-4
        with raises_within(errors.LateOdometry, PATIENCE, "the newest of"):
            for _ in range(2):
                driver.step(np.array(AHEAD))
        fake.stopped()


def test_lost_odometry(fake):
    with driving(FAKE, gap=0.3) as driver:
        driver.reset()
        drive(driver, AHEAD, 1)
        fake.lost = 1.0
        with raises_within(errors.LostOdometry, 0.0, r"got none for 1\.05 s"):
            for _ in range(50):
                driver.step(np.array(AHEAD))
        fake.stopped()


def test_odometry_that_is_too_old_by_a_shared_clock(fake):
    with driving(FAKE) as driver:  # its stamps are those of 1970
        driver.reset()
    with raises_within(errors.StaleOdometry, 0.0, "s old by this computer's clock"):
        Driver(limits=Limits(patience=PATIENCE, age=1.0), topics=FAKE)


def test_odometry_that_is_no_pose(fake):
    with driving(FAKE) as driver:
        driver.reset()
        fake.orientation = float("nan")
        with raises_within(errors.UnusableOdometry, 0.0, "expected finite x, y"):
            for _ in range(50):
                driver.step(np.array(AHEAD))
        fake.stopped()


def test_a_command_is_repeated_while_it_is_in_force(fake):
    """A step of half a second has ten readings; firmware stops a robot that hears nothing for as long."""
    with driving(FAKE) as driver:
        driver.reset()
        drive(driver, AHEAD, 1)
    repeated = [v for v, _ in fake.commands if v == pytest.approx(0.15)]
    assert len(repeated) >= 5


def test_a_policy_that_hangs_lets_the_robot_stop(fake):
    with driving(FAKE) as driver:
        driver.reset()
        drive(driver, AHEAD, 1)
        assert fake.commands[-1][0] == pytest.approx(0.15)
        fake.stopped()  # without another call of the driver


def test_a_real_robot_is_carried_back_and_given_its_drift(fake):
    carried = []
    driver = Driver(bias=BIAS, carry=lambda: carried.append(fake.now), topics=FAKE)
    try:
        for _ in range(2):
            driver.reset()
            drive(driver, AHEAD, 1)
        assert len(carried) == 2
        assert fake.commands[-1] == pytest.approx((0.15, 0.0), abs=1e-6)
    finally:
        driver.close()


def test_ctrl_c_in_a_step_stops_the_robot(fake, monkeypatch):
    def interrupt():
        raise KeyboardInterrupt

    with driving(FAKE) as driver:
        driver.reset()
        drive(driver, AHEAD, 1)
        monkeypatch.setattr(driver._watch, "check", interrupt)  # it is called while a step waits
        with pytest.raises(KeyboardInterrupt):
            driver.step(np.array(AHEAD))
        fake.stopped()


def test_no_robot_at_all(master):
    with raises_within(errors.RobotSilent, PATIENCE, "nothing came for"):
        Driver(limits=Limits(patience=PATIENCE), topics=("/nobody/odom", "/nobody/cmd_vel"))


def test_a_second_driver_of_this_program_is_refused(driver):
    with pytest.raises(errors.TwoDrivers, match="close it first"):
        Driver()


INTRUDER = """
import sys
sys.path.append({debian!r})
import rospy
from geometry_msgs.msg import Twist
rospy.init_node("intruder", disable_signals=True)
publisher, twist = rospy.Publisher("/cmd_vel", Twist, queue_size=1), Twist()
twist.angular.z = 0.5
while True:
    publisher.publish(twist)
    rospy.sleep(0.02)
"""


@contextlib.contextmanager
def intruder(master, log):
    """Run another program that drives."""
    with log.open("w") as file:
        code = INTRUDER.format(debian=str(ros.DEBIAN))
        process = subprocess.Popen(
            [sys.executable, "-c", code],
            env=master,
            stdout=file,
            stderr=file,
        )
        try:
            yield process
        finally:
            end(process, signal.SIGKILL)


def test_a_robot_that_two_command_at_once_stops(robot, commander, master, odometry, tmp_path):
    def both_heard():
        commander(0.2, 0.0)
        return "drivers at once" in robot.log.read_text()

    with intruder(master, tmp_path / "intruder.log"):
        until(both_heard, what="the robot to hear both")
    stands(odometry)


@pytest.mark.usefixtures("robot")
def test_a_driver_beside_another_leaves(master, odometry, tmp_path):
    with driving(gap=5.0) as driver, intruder(master, tmp_path / "intruder.log"):
        deadline = time.monotonic() + 60.0  # for the other program to start
        with pytest.raises(errors.TwoDrivers, match="found /intruder"):
            ended = True
            while time.monotonic() < deadline:
                if ended:
                    driver.reset()
                _, _, terminated, truncated, _ = driver.step(np.array(AHEAD))
                ended = terminated or truncated
        driver.close()
        with pytest.raises(errors.TwoDrivers, match="found /intruder"):
            Driver()
    stands(odometry)
    with driving(gap=5.0) as driver:  # the intruder was killed, but stands in the master's books
        driver.reset()
        drive(driver, AHEAD, 1)


@pytest.fixture(scope="module")
def bag():
    """Return the recorded messages of one run, (topic, message), in the order in which they came."""
    try:
        import rosbag  # noqa: PLC0415
    except ModuleNotFoundError as error:
        pytest.skip(f"{error.name} is missing: apt-get install python3-rosbag")
    with rosbag.Bag(str(DATA / "robot" / "one-run.bag")) as bag:
        return [(topic, message) for topic, message, _ in bag.read_messages()]


def recorded():
    """Return the two episodes of the run, as they were driven."""
    return [load_episodes(DATA / "robot" / f"{name}.npz")[0] for name in ("before", "after")]


def test_a_recorded_run_gives_its_trajectories(bag):
    """Each step ends with the first reading that is half a second newer than the end of the one before it."""
    odometer, episodes, target, stopped = Odometer(Limits()), [], None, True
    for topic, message in bag:
        if topic == "/odom":
            odometer.add(reading_of(message))
            if target is not None and (reading := odometer.take(target)) is not None:
                episodes[-1].append(relative(reading, odometer.origin)[1:])
                target = reading.stamp + odometer.limits.period
        else:
            drives = (message.linear.x, message.angular.z) != (0.0, 0.0)
            if drives and stopped:
                odometer.set_origin()
                episodes.append([(0.0, 0.0, 0.0)])
                target = odometer.newest.stamp + odometer.limits.period
            elif not drives:
                target = None
            stopped = not drives
    for states, episode in zip(episodes, recorded(), strict=True):
        assert episode.success and len(states) == len(episode.states) + 1
        np.testing.assert_allclose(states[:-1], episode.states, atol=1e-6)
        assert np.abs(np.array(states[-1][:2]) - (2.0, 1.0)).max() <= 0.1  # the goal's box


WITHOUT_MASTER = """
import json, threading
import numpy as np
from emrld_lite.robot.driver import Driver
from emrld_lite.robot.node import RobotNode
from emrld_lite.robot.odometry import Limits, Odometer, reading_of, relative
from emrld_lite.storage import DATA
from emrld_lite.robot.simulated import SimulatedRobot

robot, said = SimulatedRobot(), {}
node = RobotNode(robot, 5.0)

def run():
    try:
        node.run()
    except Exception as error:
        said["node"] = type(error).__name__

living = threading.Thread(target=run)
living.start()
driver = Driver(limits=Limits(patience=2.0, gap=5.0))
try:
    while True:
        driver.reset()
        for _ in range(50):
            driver.step(np.array([-1.0, 0.5]))
            print("driving", flush=True)
except Exception as error:
    said["driver"], said["words"] = type(error).__name__, str(error)
living.join()
before = robot.true.copy()
robot.advance()
said["moved"] = float(np.abs(robot.true - before).max())
driver.close()
print(json.dumps(said), flush=True)
"""


def test_a_master_that_goes_away(tmp_path):
    port = free_port()
    told = surroundings(port, tmp_path)
    with master_process(port, told) as master, subprocess.Popen(
        [sys.executable, "-c", WITHOUT_MASTER],
        env={**os.environ, **told},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as program:  # fmt: skip
        stuck = threading.Timer(150.0, program.kill)
        stuck.start()
        try:
            first = program.stdout.readline()
            assert first == "driving\n", first + program.stdout.read()
            end(master, signal.SIGKILL)
            gone = time.monotonic()
            rest = program.stdout.read()
        finally:
            stuck.cancel()
            program.kill()
    said = json.loads(rest.splitlines()[-1])
    assert time.monotonic() - gone < 2.0 + 2.0 + SLACK
    assert said["driver"] == "MasterGone" and said["node"] == "MasterGone", said
    assert f"no ROS master answers at http://127.0.0.1:{port}" in said["words"]
    assert said["moved"] < 1e-4


def test_a_stored_run_is_driven_adapted_and_driven(robot, tmp_path, capsys):
    run = DATA / "runs" / "two_wheeled_drift-optimal-emrld-ws-seed0"
    told = ["--run", str(run), "--out", str(tmp_path), "--episodes", "1", "--patience", "20"]
    main(["robot-drive", *told])
    said = capsys.readouterr().out
    for when, name in (("before adaptation", "before"), ("after one step", "after")):
        reached = int(load_episodes(tmp_path / f"{name}.npz")[0].success)
        assert f"{when}: {reached} of 1 reached the goal" in said


def test_ctrl_c_ends_the_node(robot):  # the last of this file: it takes the robot away
    assert end(robot, signal.SIGINT) == 130
    assert robot.log.read_text().splitlines()[-1].startswith("stopped")

"""The TurtleBot: against the kinematics of a unicycle, its delay, its odometry, its limits, its stability."""

import math

import gymnasium
import pytest
import torch
from gymnasium.utils.env_checker import check_env

from emrld_lite.envs import make
from emrld_lite.envs.turtlebot import TurtleBot
from emrld_lite.envs.turtlebot_body import Hardware
from emrld_lite.envs.two_wheeled import TIME_STEP
from emrld_lite.policy import initialise
from emrld_lite.rollout import collect
from emrld_lite.validation import InputError

EXACT = Hardware(delay=0.0, odometry_slide=0.0, odometry_turn=0.0)
STILL = torch.zeros(1, 1)
V, OMEGA = 0.15, 1.5


def driven(hardware, actions, tasks=STILL, episodes=1, seed=0):
    """Return the states after each of ``actions`` (time, 2), (time + 1, task, episode, 6)."""
    robot = TurtleBot(hardware=hardware)
    states = [robot.reset(tasks, episodes, torch.Generator().manual_seed(seed))]
    for time, action in enumerate(actions):
        command = torch.as_tensor(action, dtype=torch.float32).expand(len(tasks), episodes, 2)
        states.append(robot.step(tasks, states[-1], command, time).states)
    return torch.stack(states)


def unicycle(v, omega, seconds):
    """Return x, y and heading of a robot that drives a circle's arc."""
    if omega == 0:
        return v * seconds, 0.0, 0.0
    turned = omega * seconds
    return v / omega * math.sin(turned), v / omega * (1 - math.cos(turned)), turned


@pytest.mark.parametrize(
    ("action", "v", "omega"),
    [
        ((1.0, 0.0), V, 0.0),
        ((-1.0, 0.6), 0.0, 0.9),
        ((1.0, 0.1), V, 0.15),
        ((0.0, -0.2), 0.075, -0.3),
    ],
    ids=["straight", "spin", "arc", "arc to the right"],
)
def test_it_drives_nearly_as_a_unicycle_does(action, v, omega):
    states = driven(EXACT, [action] * 10)[-1, 0, 0, 3:]
    x, y, heading = unicycle(v, omega, 10 * TIME_STEP)
    assert states[:2].tolist() == pytest.approx([x, y], abs=0.04)
    assert float(states[2]) == pytest.approx(heading, rel=0.06, abs=1e-3)


def test_the_bias_turns_it_as_a_command_would():
    biased = driven(EXACT, [(1.0, 0.0)] * 8, torch.tensor([[-0.3]]))
    steered = driven(EXACT, [(1.0, -0.2)] * 8)
    torch.testing.assert_close(biased, steered, rtol=0, atol=1e-5)


def test_a_command_that_comes_a_step_later_acts_a_step_later():
    actions = [(1.0, 0.5), (0.2, -0.4), (1.0, 0.0), (-1.0, 0.9)]
    now = driven(EXACT, actions)
    late = driven(
        Hardware(delay=TIME_STEP, odometry_slide=0.0, odometry_turn=0.0), [*actions, (0, 0)]
    )
    assert late[1].abs().max() < 1e-4
    torch.testing.assert_close(late[1:], now, rtol=0, atol=5e-3)


def test_a_delay_costs_the_way_that_would_have_been_driven():
    late = Hardware(delay=0.2, odometry_slide=0.0, odometry_turn=0.0)
    missing = driven(EXACT, [(1.0, 0.0)] * 4)[-1] - driven(late, [(1.0, 0.0)] * 4)[-1]
    assert float(missing[0, 0, 3]) == pytest.approx(V * 0.2, abs=0.003)


def test_odometry_without_errors_is_the_truth_but_for_slip():
    states = driven(EXACT, [(1.0, 0.3), (0.0, -0.5), (1.0, 0.0)] * 4)
    assert (states[..., :2] - states[..., 3:5]).abs().max() < 0.02
    torch.testing.assert_close(states[..., 2], states[..., 5])


def test_odometry_errs_as_its_hardware_says():
    noisy = Hardware(delay=0.0, odometry_slide=0.05, odometry_turn=0.02)
    end = driven(noisy, [(1.0, 0.0)] * 8, episodes=400)[-1, 0]
    measured = end[:, 0] / end[:, 3]
    assert float(measured.std()) == pytest.approx(0.05, rel=0.15)
    assert float((end[:, 2] - end[:, 5]).std()) == pytest.approx(
        0.02 * 2.0, rel=0.15
    )  # 4 s: root is 2
    assert float(end[:, 3:].std(0).max()) == 0.0  # the robots themselves drive alike


def test_wheels_that_slip_turn_less_than_they_measure():
    slippery = Hardware(friction=0.02, delay=0.0, odometry_slide=0.0, odometry_turn=0.0)
    states = driven(slippery, [(1.0, 0.0)] * 4)[-1, 0, 0]
    assert float(states[3]) < float(states[0]) - 0.01
    assert float(states[3]) < float(driven(EXACT, [(1.0, 0.0)] * 4)[-1, 0, 0, 3])


def test_commands_beyond_the_limits_are_clamped():
    torch.testing.assert_close(driven(EXACT, [(9.0, 7.0)] * 3), driven(EXACT, [(1.0, 1.0)] * 3))


def test_the_batch_drives_each_robot_as_if_it_were_alone():
    tasks = torch.tensor([[0.4], [-0.9]])
    actions = [(1.0, 0.3), (0.2, -0.5), (1.0, 0.0)]
    together = driven(EXACT, actions, tasks, episodes=3)
    for task in range(2):
        alone = driven(EXACT, actions, tasks[task : task + 1])
        torch.testing.assert_close(together[:, task, 2], alone[:, 0, 0], rtol=0, atol=0)


def test_the_seed_decides_the_odometry():
    one, same, other = (driven(Hardware(), [(1.0, 0.2)] * 3, seed=seed) for seed in (1, 1, 2))
    assert torch.equal(one, same) and not torch.equal(one, other)


def test_random_commands_neither_topple_nor_break_it():
    robot = TurtleBot()
    random = torch.Generator().manual_seed(0)
    tasks = torch.linspace(-2, 2, 5)[:, None]
    states = robot.reset(tasks, 8, random)
    for time in range(30):
        actions = 2 * torch.rand(5, 8, 2, generator=random) - 1
        moved = robot.step(tasks, states, actions, time)
        step = (moved.states[..., 3:5] - states[..., 3:5]).norm(dim=-1)
        assert torch.isfinite(moved.states).all() and float(step.max()) < 2 * V * TIME_STEP
        states = moved.states
    assert not robot._running["odometry"].fallen.any()


def test_it_is_a_gymnasium_environment():
    single = gymnasium.make("emrld_lite/TurtleBot-v0")
    check_env(single.unwrapped, skip_render_check=True)
    observation, info = single.reset(seed=0, options={"task": [-0.65]})
    assert observation.shape == (3,) and info["task"].tolist() == pytest.approx([-0.65])


def test_a_rollout_takes_it_as_any_other_environment():
    robot = make("turtlebot", heading=False)
    rollout = collect(robot, torch.tensor([[0.0]]), initialise(2, 2, 0), 2, torch.Generator())
    assert rollout.states.shape[-1] == 2  # what the policy sees


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: Hardware(friction=0.0), "friction"),
        (lambda: Hardware(delay=-0.1), "delay"),
        (lambda: TurtleBot(threads=0), "threads"),
        (lambda: TurtleBot().check_tasks(torch.tensor([[2.5]])), "TurtleBot task 0"),
        (lambda: TurtleBot().step(STILL, torch.zeros(1, 1, 6), torch.zeros(1, 1, 2), 0), "states"),
    ],
)
def test_what_cannot_be_is_refused(build, words):
    with pytest.raises(InputError, match=words):
        build()

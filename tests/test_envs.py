"""Every environment against the paper's formulas, and the two shells against each other."""

import math
import warnings

import gymnasium
import matplotlib
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env
from hypothesis import given, settings
from hypothesis import strategies as st

from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.envs import (
    GYMNASIUM_IDS,
    cheetah_body,
    drawing,
    half_cheetah,
    make,
    point2d,
    rendering,
    two_wheeled,
)
from emrld_lite.envs.goals import goals_at
from emrld_lite.envs.turtlebot_body import Hardware
from emrld_lite.experiments import plotting
from emrld_lite.policy import initialise
from emrld_lite.rollout import collect
from emrld_lite.validation import InputError

ORIGIN = torch.zeros(1, 1, 2)
EXACT_ODOMETRY = Hardware(odometry_slide=0.0, odometry_turn=0.0)


def reward_by_hand(x, y, goal, time):
    """The paper's R_t, appendix B, as printed."""
    distance = math.sqrt((x - goal[0]) ** 2 + (y - goal[1]) ** 2)
    if distance <= 0.02:
        return 100 - time - 1
    if distance <= 0.2:
        return 1 - distance
    return 0.0


@pytest.mark.parametrize(
    ("offset", "expected"),
    [(0.0, 92.0), (0.019, 92.0), (0.021, 1 - 0.021), (0.199, 1 - 0.199), (0.201, 0.0), (1.5, 0.0)],
)
def test_reward_at_each_branch(offset, expected):
    goal = torch.tensor([[2.0, 0.0]])
    states = torch.tensor([[[2.0 - offset, 0.0]]])
    moved = make("point2d").step(goal, states, torch.zeros(1, 1, 2), time=7)
    assert float(moved.rewards) == pytest.approx(expected, abs=1e-6)
    assert bool(moved.terminated) == (offset < 0.02) == bool(moved.success)


def test_dense_reward_is_minus_the_distance():
    moved = make("point2d", reward="dense").step(
        torch.tensor([[0.0, 2.0]]), ORIGIN, torch.tensor([[[0.0, 1.0]]]), time=0
    )
    assert float(moved.rewards) == pytest.approx(-1.9)


@given(
    st.lists(st.floats(-3, 3), min_size=2, max_size=2),
    st.lists(st.floats(-2, 2), min_size=2, max_size=2),
    st.integers(0, 99),
    st.floats(0, math.pi),
)
@settings(max_examples=60, deadline=None)
def test_step_against_plain_floats(action, start, time, angle):
    dx, dy = (0.1 * min(1.0, max(-1.0, a)) for a in action)
    norm = math.hypot(dx, dy)
    if norm > 0.1:
        dx, dy = 0.1 * dx / norm, 0.1 * dy / norm
    x, y = start[0] + dx, start[1] + dy
    goal = goals_at(np.array([angle]))
    moved = make("point2d").step(goal, torch.tensor([[start]]), torch.tensor([[action]]), time)
    assert moved.states[0, 0].tolist() == pytest.approx([x, y], abs=1e-6)
    distance = math.dist((x, y), goal[0].tolist())
    if min(abs(distance - 0.02), abs(distance - 0.2)) > 1e-5:  # float32 cannot tell at the edge
        expected = reward_by_hand(x, y, goal[0].tolist(), time)
        assert float(moved.rewards) == pytest.approx(expected, abs=1e-5)


def test_exact_step_rule_always_moves_a_tenth():
    actions = torch.tensor([[[0.01, 0.0], [1.0, 1.0], [-0.3, 0.4]]])
    moves = point2d.displacement(actions, "exact")
    assert moves.norm(dim=-1).flatten().tolist() == pytest.approx([0.1] * 3)


def test_training_goals_are_twelve_on_the_semicircle():
    goals = make("point2d").training_tasks()
    assert goals.shape == (12, 2)
    angles = [np.pi * place / 11 for place in range(12)]  # evenly, both ends included
    circle = [[2 * np.cos(angle), 2 * np.sin(angle)] for angle in angles]
    assert sorted(goals.tolist()) == pytest.approx(np.array(sorted(circle)), abs=1e-5)


# --- TwoWheeled -----------------------------------------------------------------------------------


def drive_by_hand(state, action, v_limit, omega_limit, turn_extra=0.0):
    """The paper's kinematics, appendix B, in plain floats."""
    linear, angular = (min(1.0, max(-1.0, a)) for a in action)
    v, omega = v_limit * (linear + 1) / 2, omega_limit * angular
    x, y, theta = state
    return (
        x + v * math.cos(theta) * 0.5,
        y + v * math.sin(theta) * 0.5,
        theta + omega * 0.5 + turn_extra,
    )


poses = st.tuples(st.floats(-2.3, 2.3), st.floats(-2.3, 2.3), st.floats(-9, 9))
pairs = st.lists(st.floats(-3, 3), min_size=2, max_size=2)


@given(poses, pairs, st.floats(0, math.pi))
@settings(max_examples=60, deadline=None)
def test_wheeled_step_against_plain_floats(pose, action, angle):
    goal = goals_at(np.array([angle]))
    moved = make("two_wheeled").step(goal, torch.tensor([[pose]]), torch.tensor([[action]]), 0)
    expected = drive_by_hand(pose, action, 0.22, 2.84)
    assert moved.states[0, 0].tolist() == pytest.approx(expected, abs=1e-5)


@given(poses, pairs, st.floats(-0.7, 0.7), st.sampled_from([("", 0.5), ("literal_", 1.0)]))
@settings(max_examples=60, deadline=None)
def test_drift_step_against_plain_floats(pose, action, drift, reading):
    word, seconds = reading
    environment = make(f"two_wheeled_{word}drift")
    tasks = torch.tensor([[drift]])
    moved = environment.step(tasks, torch.tensor([[pose]]), torch.tensor([[action]]), 0)
    extra = drift * seconds
    expected = drive_by_hand(pose, action, 0.15, 1.5, extra)
    assert moved.states[0, 0].tolist() == pytest.approx(expected, abs=1e-5)


STANDING = torch.tensor([[[-1.0, 0.0]]])  # v = 0, omega = 0


@pytest.mark.parametrize(
    ("name", "box", "tasks", "goal"),
    [
        ("two_wheeled", 0.2, torch.tensor([[0.0, 2.0]]), (0.0, 2.0)),
        ("two_wheeled_drift", 0.1, torch.zeros(1, 1), (2.0, 1.0)),
    ],
)
def test_wheeled_reward_at_each_branch(name, box, tasks, goal):
    for dx, dy in ((0, 0), (box - 0.01, box - 0.01), (box + 0.01, 0), (0.3, 0.3), (0.35, 0.4)):
        states = torch.tensor([[[goal[0] - dx, goal[1] - dy, 0.7]]])
        moved = make(name).step(tasks, states, STANDING, time=30)
        inside, distance = max(dx, dy) <= box, math.hypot(dx, dy)
        expected = 69.0 if inside else 1 - distance if distance <= 0.5 else 0.0
        assert float(moved.rewards) == pytest.approx(expected, abs=1e-5), (dx, dy)
        assert bool(moved.success) == bool(moved.terminated) == inside
        dense = make(name, reward="dense").step(tasks, states, STANDING, time=30)
        assert float(dense.rewards) == pytest.approx(-distance, abs=1e-5)


def test_leaving_the_arena_ends_the_episode_without_success():
    ahead = torch.tensor([[[1.0, 0.0]]])
    for x, outside in ((2.3, False), (2.45, True)):
        moved = make("two_wheeled").step(
            torch.tensor([[0.0, 2.0]]), torch.tensor([[[x, 0.0, 0.0]]]), ahead, 0
        )
        assert bool(moved.terminated) == outside
        assert not moved.success


def test_wheeled_training_tasks():
    goals = make("two_wheeled").training_tasks()
    angles = [np.pi * place / 23 for place in range(24)]  # evenly, both ends included
    circle = [[2 * np.cos(angle), 2 * np.sin(angle)] for angle in angles]
    assert sorted(goals.tolist()) == pytest.approx(np.array(sorted(circle)), abs=1e-5)
    drifts = [-0.8, -0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6, 0.8]
    assert make("two_wheeled_drift").training_tasks()[:, 0].tolist() == pytest.approx(drifts)
    narrow = make("two_wheeled_drift", largest_drift=0.3)
    assert narrow.training_tasks()[[0, -1], 0].tolist() == pytest.approx([-0.3, 0.3])
    assert narrow.sample_tasks(200, np.random.default_rng(0)).abs().max() <= 0.3


def test_the_cheetah_trains_on_five_tasks_per_direction():
    assert sorted(make("half_cheetah").training_tasks()[:, 0].tolist()) == [-1.0] * 5 + [1.0] * 5


@pytest.mark.parametrize("name", ["two_wheeled", "two_wheeled_drift", "two_wheeled_literal_drift"])
def test_a_policy_that_does_not_see_the_heading_drives_the_same_robot(name):
    blind, seeing = make(name, heading=False), make(name)
    policy = initialise(2, 2, seed=0)
    weight = policy["weight_0"]  # one more input, that has no weight
    same = policy | {"weight_0": torch.cat([weight, torch.zeros_like(weight[:1])])}
    tasks = seeing.training_tasks()[:3]
    unseen = collect(blind, tasks, policy, 2, torch.Generator().manual_seed(0))
    seen = collect(seeing, tasks, same, 2, torch.Generator().manual_seed(0))
    assert unseen.states.shape[-1] == 2
    torch.testing.assert_close(unseen.states, seen.states[..., :2], rtol=0, atol=1e-4)
    assert not torch.equal(seen.states[..., 2], torch.zeros_like(seen.states[..., 2]))


def test_a_robot_whose_heading_is_not_seen_is_drawn_along_its_way():
    states = torch.tensor([[0.0, 0.0], [0.3, 0.4]])
    assert two_wheeled.pose(states) == pytest.approx([0.3, 0.4, math.atan2(4, 3)])
    assert two_wheeled.pose(states[:1]) == [0.0, 0.0, 0.0]


# --- HalfCheetah ----------------------------------------------------------------------------------


def test_cheetah_starts_at_random_within_the_noise_of_gymnasium():
    environment = make("half_cheetah", start="random")
    tasks = environment.training_tasks()
    states = environment.reset(tasks, 40, torch.Generator().manual_seed(0))  # (10, 40, 20)
    positions = torch.cat([states[..., :8], states[..., 17:18]], -1)
    assert 0.09 < positions.abs().max() <= 0.1
    assert positions.std() == pytest.approx(0.1 / math.sqrt(3), rel=0.05)  # uniform
    assert states[..., 8:17].std() == pytest.approx(0.1, rel=0.05)
    again = environment.reset(tasks, 40, torch.Generator().manual_seed(0))
    assert torch.equal(states, again)
    with pytest.raises(InputError, match="random: expected a generator"):
        environment.reset(tasks, 40)


def test_cheetah_can_be_paid_on_the_correct_side_only():
    forward = load_demonstrations("optimal", "half_cheetah").actions[0, 0]  # (time, action)
    tasks = torch.tensor([[1.0], [-1.0]])
    paid = {}
    for side in ("both", "correct"):
        environment = make("half_cheetah", paid_side=side)
        states, rewards = environment.reset(tasks, 1), []
        for time, action in enumerate(forward):
            moved = environment.step(tasks, states, action.expand(2, 1, -1), time)
            states = moved.states
            rewards.append(moved.rewards[:, 0])
        paid[side] = torch.stack(rewards, -1)  # (task, time)
    assert paid["both"][0].sum() > 0 > paid["both"][1].sum()
    assert torch.equal(paid["correct"][0], paid["both"][0])
    assert not paid["correct"][1].any()


def test_cheetah_steps_like_mujoco_in_a_plain_loop():
    mujoco = pytest.importorskip("mujoco")
    environment = make("half_cheetah", reward="dense")
    random = np.random.default_rng(0)
    tasks = torch.tensor([[1.0], [-1.0]])
    states = environment.reset(tasks, 2)
    model = cheetah_body.cheetah_model()
    alone = [mujoco.MjData(model) for _ in range(4)]
    for time in range(20):
        actions = random.uniform(-1.3, 1.3, (2, 2, 6)).astype(np.float32)
        moved = environment.step(tasks, states, torch.from_numpy(actions), time)
        for number, data in enumerate(alone):
            task, episode = divmod(number, 2)
            x = data.qpos[0]
            data.ctrl[:] = np.clip(actions[task, episode], -1, 1)
            mujoco.mj_step(model, data, nstep=5)
            seen = [*data.qpos[1:], *data.qvel, data.qpos[0], 0.0, data.qpos[1] + 0.7]
            assert moved.states[task, episode].tolist() == pytest.approx(seen, abs=1e-5)
            cost = 0.05 * (data.ctrl**2).sum()
            reward = float(tasks[task]) * (data.qpos[0] - x) / 0.05 - cost
            assert float(moved.rewards[task, episode]) == pytest.approx(reward, abs=1e-4)
        states = moved.states


def test_the_torso_is_where_mujoco_says():
    mujoco = pytest.importorskip("mujoco")
    model = cheetah_body.cheetah_model()
    data = mujoco.MjData(model)
    data.qpos[:] = np.random.default_rng(1).normal(size=9)
    mujoco.mj_forward(model, data)
    seen = cheetah_body.observation(data.qpos, data.qvel)
    assert seen[17:] == pytest.approx(data.body("torso").xpos)
    restored, _ = cheetah_body.full_state(torch.from_numpy(seen))
    assert restored == pytest.approx(data.qpos)


@pytest.mark.parametrize("task", [0, 9], ids=["forward", "backward"])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_cheetah_is_paid_beyond_two_metres_only(task, direction):
    """Demonstrated runs either way, each paid by its own direction and, wrongly, by the other."""
    environment, tasks = make("half_cheetah"), torch.tensor([[direction]])
    states, paid = environment.reset(tasks, 1), 0
    for time, action in enumerate(load_demonstrations("optimal", "half_cheetah").actions[task, 0]):
        moved = environment.step(tasks, states, action[None, None], time)
        before, after = float(states[0, 0, 17]), float(moved.states[0, 0, 17])
        cost = 0.05 * float(action.clamp(-1, 1) @ action.clamp(-1, 1))
        beyond = abs(after) > 2.0
        expected = direction * (after - before) / 0.05 - cost if beyond else 0.0
        assert float(moved.rewards) == pytest.approx(expected, abs=1e-3)
        assert bool(moved.success) == (beyond and after * direction > 0)
        states, paid = moved.states, paid + beyond
    assert 0 < paid < environment.horizon


def test_cheetah_threads_do_not_change_the_rollout():
    params = initialise(20, 6, seed=0)
    rollouts = []
    for threads in (1, 2):
        environment = make("half_cheetah", threads=threads)
        random = torch.Generator().manual_seed(0)
        rollouts.append(collect(environment, environment.training_tasks(), params, 2, random))
    for one, two in zip(*rollouts, strict=True):
        assert one is two is None or torch.equal(one, two)


def test_a_broken_simulation_ends_and_pays_nothing(monkeypatch):
    """With bounds so narrow that a cheetah at full torque leaves them, and one that lies still does not."""
    environment, tasks = make("half_cheetah", reward="dense"), torch.tensor([[1.0]])
    actions = torch.tensor([[[1.0] * 6, [0.0] * 6]])
    moved = environment.step(tasks, environment.reset(tasks, 2), actions, 0)
    assert not moved.terminated.any() and moved.rewards[0, 0] != 0
    bounds = (100.0,) * 8 + (5.0,) * 9 + (100.0,) * 3
    monkeypatch.setattr(half_cheetah.HalfCheetahForwardBackward, "observation_high", bounds)
    moved = environment.step(tasks, environment.reset(tasks, 2), actions, 0)
    assert moved.terminated[0].tolist() == [True, False]
    assert moved.rewards[0, 0] == 0
    assert torch.isfinite(moved.states).all()


def test_cheetah_refuses_states_that_are_not_its_own():
    environment = make("half_cheetah")
    tasks = environment.training_tasks()
    states = environment.reset(tasks, 1)
    with pytest.raises(InputError, match="states"):
        environment.step(tasks, states + 0.1, torch.zeros(10, 1, 6), 0)


# --- every environment ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", GYMNASIUM_IDS)
def test_batched_and_single_episodes_are_identical_bit_for_bit(name):
    options = {"hardware": EXACT_ODOMETRY} if name == "turtlebot" else {}  # its errors are drawn
    environment = make(name, **options)
    random = np.random.default_rng(3)
    tasks = environment.sample_tasks(3, random)
    actions = random.normal(size=(3, 5, 40, environment.action_dim)).astype(np.float32)
    states = environment.reset(tasks, 5)
    batched = []
    for time in range(40):
        moved = environment.step(tasks, states, torch.from_numpy(actions[:, :, time]), time)
        states = moved.states
        batched.append(moved)
    single = gymnasium.make(GYMNASIUM_IDS[name], **options).unwrapped
    for task in range(3):
        for episode in range(5):
            single.reset(options={"task": tasks[task].numpy()})
            for time in range(40):
                observation, reward, terminated, _, _ = single.step(actions[task, episode, time])
                moved = batched[time]
                seen = environment.observe(moved.states[task, episode])
                assert (observation == seen.numpy()).all()
                assert reward == float(moved.rewards[task, episode])
                assert terminated == bool(moved.terminated[task, episode])


@pytest.mark.parametrize("name", GYMNASIUM_IDS)
def test_gymnasium_accepts_the_environment_without_a_warning(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(GYMNASIUM_IDS[name]).unwrapped)


@pytest.mark.parametrize("name", GYMNASIUM_IDS)
def test_observations_stay_within_their_space(name):
    single = gymnasium.make(GYMNASIUM_IDS[name]).unwrapped
    observation, _ = single.reset(seed=1)
    single.action_space.seed(1)
    push = single.action_space.high
    for time in range(100):
        assert observation in single.observation_space
        observation, _, terminated, _, _ = single.step(
            push if time % 2 else single.action_space.sample()
        )
        if terminated:
            break
    assert observation in single.observation_space


@pytest.mark.parametrize("name", GYMNASIUM_IDS)
def test_a_picture_of_every_environment(name):
    single = gymnasium.make(GYMNASIUM_IDS[name], render_mode="rgb_array").unwrapped
    with pytest.raises(InputError, match="reset"):
        single.render()
    single.reset(seed=0)
    before = single.render()
    for _ in range(8):
        single.step(single.action_space.high)
    assert before.shape == (480, 480, 3)
    assert before.dtype == np.uint8
    assert (single.render() != before).any()


def test_a_picture_does_not_take_the_layout_of_the_style():
    with matplotlib.rc_context(plotting.STYLE), warnings.catch_warnings():
        warnings.simplefilter("error")
        assert drawing.pixels(lambda axes: axes.plot([0, 1])).shape == (480, 480, 3)


@pytest.mark.parametrize("name", GYMNASIUM_IDS)
def test_without_a_screen_human_rendering_says_so_and_goes_on(name, caplog):
    single = gymnasium.make(GYMNASIUM_IDS[name], render_mode="human").unwrapped
    single.reset(seed=0)
    single.step(single.action_space.high)
    single.close()
    assert "no screen" in caplog.text


def test_without_a_gl_library_the_cheetah_is_drawn(monkeypatch):
    def none(*_):
        raise RuntimeError("no GL here")

    monkeypatch.setattr(rendering.mujoco, "Renderer", none)
    rendering.renderer.cache_clear()
    try:
        assert cheetah_body.rendered(torch.zeros(20)) is None
        single = gymnasium.make(GYMNASIUM_IDS["half_cheetah"], render_mode="rgb_array").unwrapped
        single.reset(seed=0)
        assert single.render().std() > 0
    finally:
        rendering.renderer.cache_clear()


@pytest.mark.parametrize("name", GYMNASIUM_IDS)
def test_test_tasks_are_drawn_anew_and_belong(name):
    environment = make(name)
    drawn = environment.sample_tasks(40, np.random.default_rng(0))
    environment.check_tasks(drawn)
    environment.check_tasks(environment.training_tasks())
    if name != "half_cheetah":  # the paper's cheetah has the same two tasks
        gaps = torch.cdist(drawn, environment.training_tasks())
        assert gaps.min() > 0
    else:
        assert set(drawn[:, 0].tolist()) == {-1.0, 1.0}


@pytest.mark.parametrize(
    ("name", "task", "message"),
    [
        ("two_wheeled", [0.0, 1.0], "TwoWheeled task 0"),
        ("two_wheeled", [1.0], "TwoWheeled goals"),
        ("two_wheeled_drift", [0.9], "TwoWheeledDrift task 0"),
        ("two_wheeled_drift", [0.0, 2.0], "TwoWheeledDrift drifts"),
        ("two_wheeled_literal_drift", [0.75], "TwoWheeledLiteralDrift task 0.*0.7 rad per step"),
        ("half_cheetah", [0.5], "HalfCheetah task 0"),
        ("half_cheetah", [0.0, 2.0], "HalfCheetah directions"),
    ],
)
def test_tasks_of_another_environment_are_refused(name, task, message):
    with pytest.raises(InputError, match=message):
        make(name).check_tasks(torch.tensor([task]))


def test_episode_is_truncated_at_the_horizon():
    single = gymnasium.make("emrld_lite/Point2D-v0").unwrapped
    single.reset(seed=0)
    truncated = [single.step(np.zeros(2, dtype=np.float32))[3] for _ in range(100)]
    assert truncated == [False] * 99 + [True]
    with pytest.raises(InputError, match="reset"):
        single.step(np.zeros(2, dtype=np.float32))


@pytest.mark.parametrize(
    ("action", "message"),
    [([0.0], r"\(2,\)"), ([0.0, math.nan], "finite"), ([[0.0, 0.0]], r"\(2,\)")],
)
def test_bad_actions_are_refused(action, message):
    single = gymnasium.make("emrld_lite/Point2D-v0").unwrapped
    single.reset(seed=0)
    with pytest.raises(InputError, match=message):
        single.step(np.array(action))


@pytest.mark.parametrize("goal", [[0.0, 1.0], [0.0, -2.0], [math.nan, 2.0]])
def test_goals_off_the_semicircle_are_refused(goal):
    with pytest.raises(InputError, match="Point2D"):
        make("point2d").check_tasks(torch.tensor([goal]))


def test_unknown_names_suggest_the_nearest(shapes_unchecked):
    with pytest.raises(InputError, match="Did you mean 'point2d'"):
        make("point_2d")
    with pytest.raises(InputError, match="Did you mean 'dense'"):
        make("point2d", reward="dence")
    with pytest.raises(InputError, match="unknown option of two_wheeled 'step_rule'"):
        make("two_wheeled", step_rule="exact")
    with pytest.raises(InputError, match="render mode"):
        gymnasium.make("emrld_lite/Point2D-v0", render_mode="ansi")

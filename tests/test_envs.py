"""Point2D against the paper's formula, and the two shells against each other."""

import math
import warnings

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env
from hypothesis import given, settings
from hypothesis import strategies as st

from emrld_lite.envs import make, point2d
from emrld_lite.validation import InputError

ORIGIN = torch.zeros(1, 1, 2)


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
    goal = point2d.goals_at(np.array([angle]))
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
    assert goals.norm(dim=-1).tolist() == pytest.approx([2.0] * 12)
    assert (goals[:, 1] >= -1e-6).all()


def test_batched_and_single_episodes_are_identical_bit_for_bit():
    environment = make("point2d")
    random = np.random.default_rng(3)
    tasks = environment.sample_tasks(5, random)
    actions = torch.from_numpy(random.normal(size=(5, 7, 40, 2)).astype(np.float32))
    states = environment.reset(tasks, 7)
    batched = []
    for time in range(40):
        moved = environment.step(tasks, states, actions[:, :, time], time)
        states = moved.states
        batched.append(moved)
    single = gymnasium.make("emrld_lite/Point2D-v0").unwrapped
    for task in range(5):
        for episode in range(7):
            single.reset(options={"task": tasks[task].numpy()})
            for time in range(40):
                observation, reward, terminated, _, _ = single.step(
                    actions[task, episode, time].numpy()
                )
                moved = batched[time]
                assert (observation == moved.states[task, episode].numpy()).all()
                assert reward == float(moved.rewards[task, episode])
                assert terminated == bool(moved.terminated[task, episode])


def test_gymnasium_accepts_the_environment_without_a_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version.*")
        check_env(gymnasium.make("emrld_lite/Point2D-v0").unwrapped, skip_render_check=True)


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


def test_unknown_names_suggest_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'point2d'"):
        make("point_2d")
    with pytest.raises(InputError, match="Did you mean 'dense'"):
        make("point2d", reward="dence")

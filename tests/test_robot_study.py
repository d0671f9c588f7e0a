"""The robot study: the controller against a loop by hand, biases in both readings, what is written down."""

import dataclasses
import math

import pytest
import torch

from emrld_lite.__main__ import main
from emrld_lite.adapt import adapt
from emrld_lite.demonstrators import recipes
from emrld_lite.envs import make
from emrld_lite.envs.turtlebot import TurtleBot
from emrld_lite.envs.turtlebot_body import Hardware
from emrld_lite.envs.two_wheeled_drift import DRIFT_GOAL, ROBOT_DRIFT
from emrld_lite.experiments import robot_driving, robot_study, runs, textbook
from emrld_lite.policy import per_task
from emrld_lite.rollout import collect, episode_returns, follow
from emrld_lite.validation import InputError

GOAL = torch.tensor([DRIFT_GOAL])
STORED = (
    runs.SHIPPED / "two_wheeled_drift-headless-optimal-emrld-seed0"
)  # a run that the study drives
LITTLE = Hardware(delay=0.0, odometry_slide=0.0, odometry_turn=0.0)


def by_hand(drift, goal, omega_limit=1.5, v_limit=0.15, time_step=0.5):
    """Return the returns and the path of a robot that aims at the goal, in plain Python."""
    x = y = heading = total = 0.0
    path = []
    for time in range(100):
        off = math.remainder(math.atan2(goal[1] - y, goal[0] - x) - heading, 2 * math.pi)
        v = v_limit * max(0.0, math.cos(off))
        omega = max(-omega_limit, min(omega_limit, off / time_step))
        x, y = x + v * math.cos(heading) * time_step, y + v * math.sin(heading) * time_step
        heading += (omega + drift) * time_step
        path.append((x, y))
        if max(abs(x - goal[0]), abs(y - goal[1])) <= 0.1:
            return total + 100 - time - 1, path
        distance = math.hypot(x - goal[0], y - goal[1])
        total += 1 - distance if distance <= 0.5 else 0.0
    return total, path


@pytest.mark.parametrize("drift", [-0.65, 0.0, 0.3])
def test_the_controller_drives_as_the_same_rule_by_hand(drift):
    world = make("two_wheeled_drift")
    act = textbook.aim(GOAL, world.omega_limit)
    tasks = torch.tensor([[drift]])
    rollout = follow(world, tasks, act, 1, torch.Generator().manual_seed(0))
    expected, path = by_hand(drift, DRIFT_GOAL)
    assert float(episode_returns(rollout)) == pytest.approx(expected, abs=1e-3)
    steps = int(rollout.mask.sum())
    assert steps == len(path)
    driven = rollout.states[0, 0, 1:steps, :2]
    torch.testing.assert_close(driven, torch.tensor(path[:-1]), rtol=0, atol=1e-3)


def test_a_bearing_is_the_short_way_round_from_any_heading():
    states = torch.tensor([[0.0, 0.0, 0.3], [0.0, 0.0, 0.3 + 20 * math.pi], [0.0, 0.0, -3.0]])
    behind = torch.tensor([[math.cos(3.0), math.sin(3.0)]])
    off = textbook.bearing(states, behind)
    assert off.tolist() == pytest.approx([2.7, 2.7, 6.0 - 2 * math.pi], abs=1e-4)


def test_a_steady_drift_leaves_the_controller_off_its_aim():
    world = make("two_wheeled_drift")
    far = torch.tensor([[100.0, 0.0]])  # the bearing of a far goal hardly changes on the way
    for gain in (1.0, 2.0):
        act = textbook.aim(far, world.omega_limit, gain)
        rollout = follow(world, torch.tensor([[-0.4]]), act, 1, torch.Generator().manual_seed(0))
        off = textbook.bearing(rollout.states[0, 0, 20], far[0])
        assert float(off) == pytest.approx(0.4 / gain, rel=0.03)


@pytest.mark.parametrize("gain", [-1.0, 21.0, math.nan])
def test_a_gain_that_no_robot_has_is_refused(gain):
    with pytest.raises(InputError, match="gain: expected"):
        textbook.aim(GOAL, 1.5, gain)


def test_a_literal_drift_turns_the_robot_twice_as_fast():
    drifts = torch.tensor([[-0.65], [0.2]])
    rate = robot_driving.robot_bias(make("two_wheeled_drift"), drifts)
    literal = robot_driving.robot_bias(make("two_wheeled_literal_drift"), drifts)
    assert rate.flatten().tolist() == pytest.approx([-0.65, 0.2])
    assert literal.flatten().tolist() == pytest.approx([-1.3, 0.4])


@pytest.mark.parametrize("name", ["two_wheeled_drift", "two_wheeled_literal_drift"])
def test_the_robot_drifts_as_the_world_that_trained_for_it(name):
    world = make(name)
    drifts = torch.tensor([[-0.65], [0.5]])
    bias = robot_driving.robot_bias(world, drifts)
    robot = robot_driving.robot_for(world, LITTLE)
    ahead = torch.tensor([-1.0, 0.0]).expand(2, 1, 2)  # stands, and turns
    turned = []
    for family, tasks in ((world, drifts), (robot, bias)):
        states = family.reset(tasks, 1)
        for time in range(4):
            states = family.step(tasks, states, ahead, time).states
        turned.append(states[:, 0, 2])
    torch.testing.assert_close(turned[1], turned[0], rtol=0.08, atol=0.02)


def test_the_robot_sees_what_its_policy_was_trained_to_see():
    assert robot_driving.robot_for(make("two_wheeled_drift", heading=False)).state_dim == 2
    assert robot_driving.robot_for(make("two_wheeled_drift")).state_dim == 3


def test_the_witness_writes_down_where_the_robot_was():
    wide = TurtleBot(hardware=Hardware(odometry_slide=0.3))
    witness = robot_driving.Witness(wide)
    tasks = torch.tensor([[0.0], [0.8]])
    act = textbook.aim(GOAL, wide.omega_limit)
    rollout = follow(witness, tasks, act, 6, torch.Generator().manual_seed(0))
    driven = witness.driven(tasks, rollout)
    assert driven.truth.shape == (*rollout.mask.shape, 3)
    assert rollout.success.all()
    for task in range(2):
        for episode in range(6):
            steps = int(rollout.mask[task, episode].sum())
            x, y = driven.truth[task, episode, steps - 1, :2].tolist()
            stands = max(abs(x - DRIFT_GOAL[0]), abs(y - DRIFT_GOAL[1])) <= 0.1
            assert bool(driven.truly[task, episode]) == stands
            assert not driven.truth[task, episode, steps:].any()
    assert 0 < int(driven.truly.sum()) < 12  # odometry of 30 % lets some of them stop elsewhere


def test_the_experiment_is_one_adaptation_step_from_what_the_robot_saw():
    run = runs.load_run(STORED)
    world, drifts = run.config.environment(), torch.tensor([[ROBOT_DRIFT]])
    made = robot_driving.adapt_on_robot(run, drifts, LITTLE, episodes=3, seed=4)
    robot, bias = robot_driving.robot_for(world, LITTLE), robot_driving.robot_bias(world, drifts)
    random = torch.Generator().manual_seed(4)
    meta_params = per_task(run.meta_params, 1)
    before = collect(robot, bias, meta_params, 3, random)
    trial = collect(robot, bias, meta_params, 5, random)
    expert = recipes.load_or_train_expert(run.config.env, "optimal")
    shown = recipes.demonstrate(expert, run.config.env, drifts, "optimal", 4).seen_in(world)
    rule = run.config.adaptation("optimal")
    after = collect(
        robot, bias, adapt(meta_params, run.config.score()(trial), shown, rule), 3, random
    )
    for driven, rollout in zip(made, (before, trial, after), strict=True):
        torch.testing.assert_close(driven.rollout.rewards, rollout.rewards)
        torch.testing.assert_close(driven.rollout.states, rollout.states)


def test_other_worlds_have_no_robot():
    run = runs.load_run(sorted(runs.SHIPPED.glob("point2d-optimal-emrld-seed0"))[0])
    with pytest.raises(InputError, match="point2d: expected a run of changing dynamics"):
        robot_driving.adapt_on_robot(run, torch.tensor([[0.0]]))


def test_every_case_varies_one_thing_at_the_papers_drift():
    for case in robot_study.cases(make("two_wheeled_literal_drift")):
        assert len(case.values) == len(case.drifts)
        if case.varied == "drift":
            assert case.hardware == Hardware()
            assert ROBOT_DRIFT in case.values
        else:
            changed = dataclasses.replace(
                case.hardware, **{case.varied: getattr(Hardware(), case.varied)}
            )
            assert changed == Hardware()
            assert case.drifts.flatten().tolist() == pytest.approx([ROBOT_DRIFT])


@pytest.fixture
def short(monkeypatch):
    """Leave a study of one drift and one delay."""
    monkeypatch.setattr(robot_study, "DRIFTS", (0.5,))
    monkeypatch.setattr(robot_study, "HARDWARE", {"delay": (0.5,)})
    monkeypatch.setattr(robot_study, "TRIES", 2)


@pytest.mark.usefixtures("short")
def test_a_study_that_was_stopped_goes_on(tmp_path, capsys):
    folder, out = tmp_path / "runs", tmp_path / "study.csv"
    folder.mkdir()
    (folder / STORED.name).symlink_to(STORED)
    control = robot_study.study(folder, out)
    assert next(control) == STORED.name
    first = robot_study.load_study(out)
    assert {row.stage for row in first} == {"before", "trial", "after"}
    half = 0.5 * runs.load_config(STORED).environment().drift_limit
    varied = {("drift", ROBOT_DRIFT), ("drift", half), ("delay", 0.5)}
    assert {(row.varied, row.value) for row in first} == varied
    main(["robot-study", "--runs-folder", str(folder), "--out", str(out)])
    said = capsys.readouterr().out
    assert STORED.name not in said
    assert "aim-at-goal" in said
    rows = robot_study.load_study(out)
    assert rows[: len(first)] == first
    assert {row.run for row in rows[len(first) :]} == {
        robot_study.controller_name(runs.load_config(STORED).environment())
    }


@pytest.mark.usefixtures("short")
def test_a_row_is_the_mean_over_tries_and_episodes():
    run, name = runs.load_run(STORED), STORED.name
    rows = list(robot_study.study_run(run, name, seed=3))
    world = run.config.environment()
    drifts = torch.tensor([ROBOT_DRIFT, 0.5 * world.drift_limit]).repeat_interleave(2)[:, None]
    made = robot_driving.adapt_on_robot(run, drifts, seed=3)
    for stage, driven in zip(("before", "trial", "after"), made, strict=True):
        totals = episode_returns(driven.rollout)
        for value, tries in ((ROBOT_DRIFT, totals[:2]), (0.5 * world.drift_limit, totals[2:])):
            (row,) = [r for r in rows if (r.varied, r.value, r.stage) == ("drift", value, stage)]
            assert row.mean_return == pytest.approx(float(tries.mean()), abs=1e-3)
            assert row.bias == pytest.approx(
                float(robot_driving.robot_bias(world, torch.tensor([[value]]))), abs=1e-4
            )


def test_a_folder_without_such_runs_is_refused(tmp_path):
    with pytest.raises(InputError, match="expected runs of changing dynamics, got none"):
        list(robot_study.study(tmp_path, tmp_path / "study.csv"))


def test_a_damaged_table_is_refused(tmp_path):
    path = tmp_path / "study.csv"
    path.write_text(",".join(robot_study.Row._fields) + "\nr,drift,x,0,before,1,1,1\n")
    with pytest.raises(InputError, match="line 2"):
        robot_study.load_study(path)

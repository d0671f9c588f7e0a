"""The slider on the robot's drift, the robot's figures, the drawing of its topics, its parts by hand."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
import torch

from emrld_lite.classroom import robot_by_hand
from emrld_lite.classroom.sketches.topics import topics
from emrld_lite.classroom.widgets import robot_drift
from emrld_lite.envs.turtlebot_body import Hardware
from emrld_lite.envs.two_wheeled import TIME_STEP
from emrld_lite.experiments import robot_driving, robot_figures, runs
from emrld_lite.experiments.robot_study import AFTER, BEFORE, Row
from emrld_lite.rollout import episode_returns
from emrld_lite.validation import InputError

STORED = sorted(runs.SHIPPED.glob("*drift*-emrld-seed0"))[0]


@pytest.fixture(scope="module")
def drives():
    """Return the slider's drives of one policy under three drifts."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(robot_drift, "DRIFTS", (-0.8, 0.0, 0.8))
        patch.setattr(robot_drift, "EPISODES", 2)
        yield robot_drift.drive_everywhere({"emrld": runs.load_run(STORED)})


@pytest.mark.parametrize("drift", [-0.8, 0.0, 0.8])
def test_the_slider_states_the_returns_of_the_ways_it_draws(drives, drift):
    figure = robot_drift.drift_picture(drives, drift)
    (axes,) = figure.axes
    task = robot_drift.DRIFTS.index(drift)
    adapted = drives.adapted["emrld"]
    expected = [
        round(float(episode_returns(driven.rollout)[task].mean()))
        for driven in (adapted.before, adapted.after)
    ]
    stated = [int(number) for number in re.findall(r"-?\d+", axes.get_title())]
    assert stated == expected
    ways = [line for line in axes.lines if len(line.get_xdata()) > 5]
    assert len(ways) == 6  # two episodes each of the controller, before, after
    last = ways[-1].get_xydata()[-1]
    steps = int(adapted.after.rollout.mask[task, 1].sum())
    assert last.tolist() == pytest.approx(adapted.after.truth[task, 1, steps - 1, :2].tolist())


def test_the_slider_knows_only_its_drifts(drives):
    with pytest.raises(InputError, match="drift: expected one of"):
        robot_drift.drift_picture(drives, 0.1)


def rows_of(names, table, varied="drift", stage=AFTER):
    """Return a study's rows from a table (run, value)."""
    return [
        Row(name, varied, value, 2 * value, stage, score, 1.0, 1.0)
        for name, scores in zip(names, table, strict=True)
        for value, score in scores.items()
    ]


def test_a_sweep_is_a_table_of_runs_and_rising_values():
    rows = rows_of(["a", "b"], [{0.4: 1.0, -0.2: 2.0}, {-0.2: 4.0, 0.4: 3.0}])
    rows += rows_of(["a"], [{0.4: 9.0}], stage=BEFORE) + rows_of(["c"], [{0.4: 9.0}])
    sweep = robot_figures.sweep_of(rows, ["b", "a"], "drift", AFTER)
    assert sweep.values.tolist() == [-0.4, 0.8]  # rad/s of the robot
    assert sweep.scores.tolist() == [[4.0, 3.0], [2.0, 1.0]]
    delays = robot_figures.sweep_of(rows_of(["a"], [{1.0: 5.0}], "delay"), ["a"], "delay", AFTER)
    assert delays.values.tolist() == [1.0]


def test_a_sweep_that_lacks_a_case_is_refused():
    rows = rows_of(["a", "b"], [{0.4: 1.0, -0.2: 2.0}, {-0.2: 4.0}])
    with pytest.raises(InputError, match="got less"):
        robot_figures.sweep_of(rows, ["a", "b"], "drift", AFTER)


def test_the_paths_of_fig_6_begin_at_the_start_and_say_who_arrived():
    run, drifts = runs.load_run(STORED), torch.tensor([[-0.65]])
    driven = {"emrld": robot_driving.adapt_on_robot(run, drifts, episodes=2)}
    controller = robot_driving.controller_on_robot(drifts, episodes=2)
    figure = robot_figures.robot_paths(driven, controller)
    titles = [axes.get_title() for axes in figure.axes]
    counts = [
        int(part.rollout.success.sum())
        for part in (driven["emrld"].before, driven["emrld"].after, controller)
    ]
    assert titles[0] == f"EMRLD\n{counts[0]}/2, then {counts[1]}/2"
    assert titles[1] == f"aim at the goal\n{counts[2]}/2"
    for axes in figure.axes:
        ways = [line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 5]
        assert ways
        assert all(way[0].tolist() == [0.0, 0.0] for way in ways)
    plt.close(figure)


def test_without_runs_the_controller_drives_alone(tmp_path):
    figure = robot_figures.paper_robot(tmp_path)
    assert [axes.get_title() for axes in figure.axes] == ["aim at the goal\n4/4"]
    plt.close(figure)


def test_the_drawing_names_both_topics():
    figure = topics()
    said = " ".join(text.get_text() for text in figure.axes[0].texts)
    assert "/cmd_vel" in said
    assert "/odom" in said
    plt.close(figure)


def test_a_ride_holds_its_wheels_speeds():
    left, right = 2.0, 4.0
    ridden = robot_by_hand.ride(lambda action, bias: (left, right), [(0.0, 0.0)] * 6)
    seconds = 6 * TIME_STEP
    assert ridden.angles[-1].tolist() == pytest.approx([left * seconds, right * seconds], rel=0.03)
    assert len(ridden.angles) == len(ridden.truth) == 6 * 20 + 1  # 40 readings per second


def test_a_rides_odometry_is_its_truth_where_nothing_slips():
    random = torch.Generator().manual_seed(1)
    actions = (2 * torch.rand(12, 2, generator=random) - 1).tolist()
    ridden = robot_by_hand.ride(robot_by_hand.wheel_command, actions, bias=0.4)
    poses = robot_by_hand.odometry(ridden.angles, ridden.headings, 0.033)
    assert float((poses[:, :2] - ridden.truth[:, :2]).abs().max()) < 0.02
    unwrapped = np.unwrap(ridden.truth[:, 2].numpy())
    np.testing.assert_allclose(poses[:, 2].numpy(), unwrapped, atol=1e-6)


def test_on_ice_the_wheels_measure_more_than_was_driven():
    full = [(1.0, 0.0)] * 8
    ridden = robot_by_hand.ride(robot_by_hand.wheel_command, full, hardware=Hardware(friction=0.02))
    poses = robot_by_hand.odometry(ridden.angles, ridden.headings, 0.033)
    assert float(poses[-1, 0]) > float(ridden.truth[-1, 0]) + 0.03

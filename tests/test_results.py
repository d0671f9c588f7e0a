"""The stored runs say what the README, the ledger and the notebooks say of them (Section 4.1)."""

import csv
import itertools
import shutil

import matplotlib.pyplot as plt
import numpy as np
import pytest

from emrld_lite.__main__ import main
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.envs import half_cheetah
from emrld_lite.experiments import (
    drift_figures,
    evaluation,
    paper_figures,
    plotting,
    results,
    runs,
    studies,
    study_figures,
)
from emrld_lite.validation import InputError

OURS, BASELINES = ("emrld", "emrld-ws"), ("maml", "meta-bc", "gmps")
STEPS = {"optimal": 1, "suboptimal": 3}  # at which the paper looks: Fig. 5


def unseen(env, quality, algorithm, step):
    """Return the mean return on unseen tasks after ``step`` adaptation steps, a number per seed."""
    folders = results.stored_seeds(runs.SHIPPED, env, quality)[algorithm]
    return np.array([results.returns_by_step(folder)[step] for folder in folders])


def in_direction(folder, goal, step):
    """Return a HalfCheetah run's mean return in one direction, from its file as it stands."""
    rows = [row for row in rows_of(folder) if row["goal"] == goal and row["step"] == str(step)]
    return np.mean([float(row["return"]) for row in rows])


def rows_of(folder):
    with (folder / "unseen.csv").open() as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize(
    ("env", "quality"),
    [*itertools.product(results.TITLES, STEPS), ("two_wheeled_drift", "optimal")],
)
def test_every_algorithm_has_equally_many_seeds_and_three_at_least(env, quality):
    stored = results.stored_seeds(runs.SHIPPED, env, quality)
    assert set(stored) == {*OURS, *BASELINES}
    (number,) = {len(seeds) for seeds in stored.values()}
    assert number >= 3


@pytest.mark.parametrize("algorithm", OURS)
def test_two_wheeled_with_optimal_data_earns_seventy(algorithm):
    assert unseen("two_wheeled", "optimal", algorithm, step=1).mean() >= 70


def test_two_wheeled_with_suboptimal_data_earns_fifty_after_three_steps():
    means = [unseen("two_wheeled", "suboptimal", name, step=3).mean() for name in OURS]
    assert max(means) >= 50


def test_the_cheetah_with_optimal_data_earns_140_running_the_right_way():
    assert unseen("half_cheetah", "optimal", "emrld-ws", step=1).mean() >= 140
    for folder in results.stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")["emrld-ws"]:
        assert len(runs.load_run(folder).curve) <= 250
        for direction in ("1.0", "-1.0"):
            after = [r for r in rows_of(folder) if r["step"] == "1" and r["goal"] == direction]
            assert np.mean([float(row["return"]) for row in after]) > 0
            assert np.mean([float(row["success"]) for row in after]) > 0.9


def test_meta_bc_loses_all_on_the_cheetah_with_one_seed_unless_its_gradient_is_clipped():
    clipped = results.stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")["meta-bc"]
    curves = [runs.load_curve(folder / "curve.csv") for folder in clipped]
    assert max(row.kl for curve in curves for row in curve) < 5.0
    assert min(in_direction(folder, "-1.0", 1) for folder in clipped) > 250
    lost, *whole = results.seeds_of(runs.SHIPPED, "half_cheetah-optimal-meta-bc-unclipped")
    assert max(row.kl for row in runs.load_curve(lost / "curve.csv")) > 100.0  # TRPO allows 0.06
    assert results.best_and_last(lost)[0] > 150 and abs(in_direction(lost, "-1.0", 1)) < 5
    assert min(in_direction(folder, "-1.0", 1) for folder in whole) > 250


@pytest.mark.parametrize("env", list(results.TITLES))
@pytest.mark.parametrize("quality", list(STEPS))
def test_both_variants_are_ahead_of_every_baseline(env, quality):
    step = STEPS[quality]
    ours = [unseen(env, quality, name, step).mean() for name in OURS]
    theirs = [unseen(env, quality, name, step).mean() for name in BASELINES]
    assert min(ours) > max(theirs)


@pytest.mark.parametrize("place", [results.FORWARD, results.BACKWARD], ids=lambda p: p.title)
def test_a_direction_is_read_apart(place):
    folders = results.stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")["gmps"]
    expected = [in_direction(folder, place.goal, 1) for folder in folders]
    assert results.run_scores(folders, 1, place.goal) == pytest.approx(expected)
    assert (min(expected) > 140) if place is results.BACKWARD else (max(expected) < -150)
    with pytest.raises(InputError, match=r"expected tasks with the goal 7\.0, got none"):
        results.run_scores(folders, 1, "7.0")


@pytest.mark.parametrize("place", [results.FORWARD, results.BACKWARD], ids=lambda p: p.title)
def test_the_demonstrations_of_a_direction_earn_what_their_recorded_steps_pay(place):
    """Appendix B's reward of the recorded states; their file holds no outcome of the last step."""
    for quality, expected in (("optimal", place.earned), ("suboptimal", 0.0)):
        data = load_demonstrations(quality, "half_cheetah")
        earned = []
        for task, states, actions, length in zip(
            data.tasks, data.states[:, 0], data.actions[:, 0], data.lengths(), strict=True
        ):
            x, total = states[:, half_cheetah.TORSO_X].double(), 0.0
            for time in range(int(length) - 1):
                pace = float(task[0]) * (x[time + 1] - x[time]) / 0.05
                cost = 0.05 * (actions[time].clamp(-1, 1) ** 2).sum()
                total += float(pace - cost) if abs(x[time + 1]) > 2 else 0.0
            earned += [total] if float(task[0]) == float(place.goal) else []
        assert np.mean(earned) == pytest.approx(expected, abs=0.05)


@pytest.mark.parametrize("env", list(results.TITLES))
@pytest.mark.parametrize("quality", list(STEPS))
def test_our_goal_reaching_runs_have_flattened_and_the_cheetah_climbs(env, quality):
    stored = results.stored_seeds(runs.SHIPPED, env, quality)
    for name in OURS:
        curves = [[row.return_after for row in runs.load_run(f).curve] for f in stored[name]]
        mean = [sum(values) / len(curves) for values in zip(*curves, strict=True)]
        fifth = len(mean) // 5
        last, before = sum(mean[-fifth:]) / fifth, sum(mean[-2 * fifth : -fifth]) / fifth
        rise = results.late_rise(stored[name], results.EARNED[env])
        assert rise == pytest.approx((last - before) / last)
        assert (rise <= results.FLAT) == (env != "half_cheetah")


def test_a_level_near_nothing_does_not_make_a_rise_of_it():
    seeds = results.seeds_of(runs.SHIPPED, "half_cheetah-optimal-maml")
    rise = results.late_rise(seeds, 237.0)
    assert rise == pytest.approx(2 * results.late_rise(seeds, 474.0))  # the floor divides
    assert abs(rise) < results.FLAT


def test_iterations_to_a_return_by_a_plain_loop():
    for folder in results.seeds_of(runs.SHIPPED, "point2d-optimal-emrld"):
        wait = None
        for row in runs.load_curve(folder / "curve.csv"):
            if wait is None and row.return_after >= 70:
                wait = row.iteration + 1
        assert results.iterations_to(folder, 70) == wait
        assert results.iterations_to(folder, 70, end=wait) == wait
        assert results.iterations_to(folder, 70, end=wait - 1) is None
        assert results.iterations_to(folder, 1000.0) is None


@pytest.mark.parametrize("seeds", [slice(0, 1), slice(3, 4), slice(None)], ids=str)
def test_the_largest_fall_by_a_plain_loop(seeds):
    folders = results.seeds_of(runs.SHIPPED, "point2d-optimal-meta-bc")[seeds]
    curves = [[row.return_after for row in runs.load_run(folder).curve] for folder in folders]
    returns = [sum(row) / len(row) for row in zip(*curves, strict=True)]
    means = [sum(returns[i : i + 10]) / 10 for i in range(len(returns) - 9)]
    falls = [max(means[: i + 1]) - mean for i, mean in enumerate(means)]
    assert results.largest_fall(folders) == pytest.approx(max(falls) / max(means))


@pytest.mark.parametrize("env", ["point2d", "two_wheeled", "half_cheetah"])
@pytest.mark.parametrize("quality", ["optimal", "suboptimal"])
def test_emrld_improves_nearly_monotonically(env, quality):
    stored = results.stored_seeds(runs.SHIPPED, env, quality)
    ours = [folder for name in OURS for folder in stored.get(name, [])]
    assert ours
    bound = {"optimal": 0.15, "suboptimal": 0.2}[quality]
    assert max(results.largest_fall([folder]) for folder in ours) < bound
    assert max(results.largest_fall(stored[name]) for name in OURS) < 0.03  # the paper's curve


def test_a_fixed_sigma_keeps_meta_bc_in_bounds_on_point2d_and_a_learned_one_lets_it_break():
    def largest(name):
        curves = [runs.load_run(seed).curve for seed in results.seeds_of(runs.SHIPPED, name)]
        return max(row.kl for curve in curves for row in curve)

    assert largest("point2d-optimal-meta-bc") < 1.0
    assert largest("search-two_wheeled-optimal-meta-bc-table1") > 1000.0  # TRPO allows 0.02


def test_maml_finds_two_wheeled_goals_and_loses_most_of_them():
    found = results.seeds_of(runs.SHIPPED, "two_wheeled-optimal-maml")
    best, last = np.array([results.best_and_last(folder) for folder in found]).T
    assert best.min() > 20 and last.mean() < 0.5 * best.mean()


def test_the_best_and_the_last_mean_by_a_plain_loop():
    (folder, *_) = results.seeds_of(runs.SHIPPED, "two_wheeled-optimal-maml")
    returns = [row.return_after for row in runs.load_run(folder).curve]
    means = [sum(returns[i : i + 10]) / 10 for i in range(len(returns) - 9)]
    assert results.best_and_last(folder) == pytest.approx((max(means), means[-1]))


def test_an_update_takes_no_step_once_every_trial_is_refused():
    (folder, *_) = results.seeds_of(runs.SHIPPED, "ablation-point2d-optimal-meta-bc-cloning-trpo")
    halved = [row.backtracks for row in runs.load_curve(folder / "curve.csv")]
    refused = runs.load_config(folder).trust_region.backtracks
    assert results.updates_without_step(folder) == halved.count(refused) > 0


def test_more_goals_help_meta_bc_on_unseen_ones_and_more_paths_of_the_same_do_not():
    few = results.seeds_of(runs.SHIPPED, "point2d-optimal-meta-bc")
    paths = results.seeds_of(runs.SHIPPED, "point2d-meta-bc-paths")
    goals = results.seeds_of(runs.SHIPPED, "point2d-meta-bc-plentiful")
    assert results.training_scores(paths).mean() > results.training_scores(few).mean() + 5
    seen = [results.run_scores(seeds, 1).mean() for seeds in (paths, few, goals)]
    assert seen[0] + 10 < seen[1] < seen[2]


def test_by_its_mean_action_meta_bc_copies_good_data_and_no_bad_ones():
    for env in ("point2d", "two_wheeled"):
        for quality, (low, high) in {"optimal": (0.9, 1.0), "suboptimal": (0.0, 0.3)}.items():
            seeds = results.stored_seeds(runs.SHIPPED, env, quality)["meta-bc"]
            score = results.run_scores(seeds, 1, table=evaluation.BY_MEAN).mean()
            assert low < score / results.EARNED[env] < high


def test_maml_solves_point2d_with_a_dense_reward():
    curve = runs.load_run(runs.SHIPPED / "point2d-dense-maml-seed0").curve
    assert curve[0].return_after < -150
    assert np.mean([row.return_after for row in curve[-10:]]) > -45  # a straight walk: about -20


@pytest.mark.parametrize("env", ["point2d", "two_wheeled"])
@pytest.mark.parametrize("algorithm", ["meta-bc", "gmps"])
def test_no_setting_of_the_search_rescues_the_supervised_baselines(env, algorithm):
    found = sorted(runs.SHIPPED.glob(f"search-{env}-*-{algorithm}-*-seed0"))
    assert len(found) == 10  # five settings with either data
    assert max(results.training_scores(found, window=20)) < 50


def test_every_figure_is_drawn_from_the_stored_runs(tmp_path):
    main(["figures", "--out", str(tmp_path)])
    names = {path.name for path in tmp_path.iterdir()}
    stems = (
        "fig-2-demonstrations",
        "fig-3-optimal",
        "fig-4-suboptimal",
        "fig-5-trajectories",
        "fig-6-drift",
        "drift-readings",
        "drift-narrow",
        "fig-6-robot",
        "fig-7-sensitivity",
        "fig-8-ablation",
        "switches",
    )
    assert names == {f"{stem}.{suffix}" for stem in stems for suffix in ("png", "svg")}


def test_the_readme_has_the_table_of_the_stored_runs():
    readme = (runs.SHIPPED.parent.parent / "README.md").read_text()
    assert results.summary(runs.SHIPPED) in readme


def test_a_column_shows_the_means_of_its_runs_and_names_its_axes():
    figure = paper_figures.results(runs.SHIPPED, "optimal")
    top, bottom = figure.axes[1], figure.axes[4]  # TwoWheeled
    assert (top.get_title(), top.get_xlabel()) == ("TwoWheeled, training", "meta-iteration")
    assert bottom.get_xlabel() == "adaptation steps"
    lines = {line.get_label(): line.get_ydata() for line in bottom.get_lines()}
    expected = [unseen("two_wheeled", "optimal", "emrld-ws", step).mean() for step in range(4)]
    assert lines["EMRLD-WS"] == pytest.approx(expected)
    assert len(figure.legends[0].get_texts()) == 5
    forward, backward = figure.axes[5:]
    for axes, goal in ((forward, "1.0"), (backward, "-1.0")):
        lines = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
        seeds = results.stored_seeds(runs.SHIPPED, "half_cheetah", "optimal")["gmps"]
        expected = np.mean([in_direction(seed, goal, 2) for seed in seeds])
        assert lines["GMPS"][2] == pytest.approx(expected)


def test_the_figure_by_drift_has_each_drift_at_its_place():
    lower = drift_figures.by_drift(runs.SHIPPED).axes[4]  # narrow drifts, a rate, the heading seen
    line = next(line for line in lower.get_lines() if line.get_label() == "MAML")
    shown = dict(zip(*line.get_data(), strict=True))
    assert len(shown) == 20
    found = {}
    for seed in results.seeds_of(runs.SHIPPED, "two_wheeled_drift-narrow-optimal-maml"):
        for row in rows_of(seed):
            if row["step"] == "1":
                found.setdefault(np.float32(row["goal"]), []).append(float(row["return"]))
    assert shown == pytest.approx({drift: np.mean(returns) for drift, returns in found.items()})


def test_the_figure_of_steering_shows_what_the_demonstrations_ask_for():
    left, right = drift_figures.steering().axes
    data = load_demonstrations("optimal", "two_wheeled_drift")
    lines = {line.get_label(): line for line in left.get_lines()}
    assert list(lines) == ["drift -0.8 rad/s", "drift +0.0 rad/s", "drift +0.8 rad/s"]
    last = lines["drift +0.8 rad/s"].get_ydata()
    assert len(last) == int(data.lengths()[-1])
    assert last[-1] == float(data.actions[-1, 0, int(data.lengths()[-1]) - 1, 1])
    training, test = right.get_lines()
    assert (len(training.get_xdata()), len(test.get_xdata())) == (9, 20)
    assert max(training.get_ydata()) == float(data.actions[..., 1].abs().max())


@pytest.mark.parametrize(
    ("panel", "cut", "usual"),  # the heading seen: trained on all drifts, and on narrow ones
    [(0, "two_wheeled_drift-cut", "two_wheeled_drift"), (2, *["two_wheeled_drift-narrow"] * 2)],
)
def test_the_figure_by_steering_tells_what_the_cut_changes(panel, cut, usual):
    axes = drift_figures.by_drift_and_steering(runs.SHIPPED).axes[panel]
    lines = [line for line in axes.get_lines() if line.get_color() == "#0072B2"]  # EMRLD
    for line, (name, table) in zip(lines, ((cut, "cut.csv"), (usual, "unseen.csv")), strict=True):
        found = {}
        for seed in results.seeds_of(runs.SHIPPED, f"{name}-optimal-emrld"):
            with (seed / table).open() as file:
                for row in csv.DictReader(file):
                    if row["step"] == "1":
                        found.setdefault(np.float32(row["goal"]), []).append(float(row["return"]))
        shown = dict(zip(*line.get_data(), strict=True))
        assert shown == pytest.approx({drift: np.mean(each) for drift, each in found.items()})


def test_the_sensitivity_figure_shows_five_values_in_each_of_four_panels():
    figure = study_figures.sensitivity(runs.SHIPPED)
    titles = [axes.get_title() for axes in figure.axes]
    assert [title.partition(",")[0] for title in titles] == ["EMRLD"] * 2 + ["EMRLD-WS"] * 2
    shown = [
        [line for line in axes.get_lines() if line.get_label()[0] != "_"] for axes in figure.axes
    ]
    assert [len(lines) for lines in shown] == [5] * 4
    seeds = results.seeds_of(runs.SHIPPED, "sensitivity-emrld-ws-w_rl1.0-w_bc0.4")
    last = np.mean([runs.load_run(seed).curve[99].return_after for seed in seeds])
    lines = {line.get_label(): line.get_ydata() for line in figure.axes[3].get_lines()}
    (label,) = [label for label in lines if label.endswith("0.4")]
    assert len(lines[label]) == 100
    assert lines[label][-1] == pytest.approx(last)


def test_the_ablation_figure_shows_what_is_left_without_each_loss():
    figure = study_figures.ablation(runs.SHIPPED)
    for axes, quality in zip(figure.axes, ("optimal", "suboptimal"), strict=True):
        shown = [line for line in axes.get_lines() if line.get_label()[0] != "_"]
        lines = {line.get_label().partition(",")[0]: line.get_ydata() for line in shown}
        assert list(lines) == ["EMRLD", "no cloning", "no RL"]
        seeds = results.seeds_of(runs.SHIPPED, f"ablation-point2d-{quality}-emrld-w_bc0.0")
        last = np.mean([runs.load_run(seed).curve[199].return_after for seed in seeds])
        assert lines["no cloning"][-1] == pytest.approx(last)


def test_the_switches_stand_below_their_control():
    axes = study_figures.switches(runs.SHIPPED).axes[0]
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == list(studies.switch_runs(runs.SHIPPED))
    assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the first row is on top
    diamonds = [line for line in axes.get_lines() if line.get_marker() == "D"]
    control = results.seeds_of(runs.SHIPPED, "point2d-optimal-emrld-ws")
    expected = results.run_scores(control, 1).mean()
    assert diamonds[0].get_xdata()[0] == pytest.approx(expected)


def test_the_demonstrations_stand_by_world_and_quality():
    titles = [axes.get_title() for axes in paper_figures.demonstrations().axes]
    assert titles[0] == "Point2D, optimal"
    assert titles[-1] == "HalfCheetah, suboptimal"


@pytest.mark.parametrize(
    "draw",
    [
        drift_figures.drift,
        drift_figures.by_drift,
        study_figures.sensitivity,
        study_figures.ablation,
        study_figures.switches,
    ],
)
def test_a_folder_with_one_run_draws_what_it_can(tmp_path, draw):
    name = "point2d-optimal-emrld-ws-seed0"
    shutil.copytree(runs.SHIPPED / name, tmp_path / name)
    texts = [text.get_text() for axes in draw(tmp_path).axes for text in axes.texts]
    assert set(texts) == {"no stored runs"}


def test_an_update_beyond_the_picture_stands_on_its_edge():
    curve = runs.load_run(results.seeds_of(runs.SHIPPED, "point2d-optimal-gmps")[0]).curve
    wild = [row._replace(kl=np.inf) if number == 7 else row for number, row in enumerate(curve)]
    _, axes = plt.subplots()
    plotting.divergence({"gmps": [curve, wild]}, 0.02, axes)
    marked = [line.get_xdata() for line in axes.get_lines() if line.get_marker() == "^"]
    assert [list(places) for places in marked] == [[], [7]]
    lines = [line.get_ydata() for line in axes.get_lines() if line.get_label() == "GMPS"]
    assert lines[0] == pytest.approx([row.kl for row in curve])


def test_a_folder_without_runs_says_so(tmp_path):
    figure = paper_figures.results(tmp_path, "optimal")
    assert [axes.texts[0].get_text() for axes in figure.axes[:3]] == ["no stored runs"] * 3

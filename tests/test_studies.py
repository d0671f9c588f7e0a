"""The stored runs are those of the grids, and each study varies what it says and nothing else."""

import csv
import dataclasses
import os

import numpy as np
import pytest

from emrld_lite.experiments import runs, studies
from emrld_lite.experiments.grid import load_grid
from emrld_lite.experiments.results import run_scores, seeds_of, stored_seeds, training_scores
from emrld_lite.experiments.runs import SHIPPED, differences, load_config
from emrld_lite.trpo import TrustRegion
from emrld_lite.validation import InputError

GRIDS = sorted((SHIPPED.parent / "grids").glob("*.toml"))
TRAINED_ALIKE = ("emrld", "emrld-ws", "maml")  # with changing dynamics
SWITCHED = {
    "sigma fixed at 1": ["learn_sigma"],
    "steps of length exactly 0.1": ["step_rule"],
    "log-density of the joint action": ["log_density"],
    "cloning loss summed": ["bc_reduction"],
    "first-order meta-gradient": ["second_order"],
    "aliased conjugate gradient": ["trust_region"],
    "reward of 1e-5 elsewhere": ["reward_elsewhere"],
    "advantages not normalised": ["normalise"],
    "first 20 episodes to end, of 30": ["started_episodes"],
    "released start of the network": ["network_start"],
    "no momentum in the meta-update": ["meta_momentum"],
    "Fisher matrix damped by 0.1": ["trust_region"],
    "KL bound of 0.01, not 0.02": ["trust_region"],
}
SEEDS, STUDIED = 5, 3  # of the main comparison, of a study


@pytest.mark.parametrize("path", GRIDS, ids=lambda path: path.stem)
def test_every_run_of_a_grid_is_stored_with_its_settings(path):
    for name, config in load_grid(path).items():
        assert differences(config, load_config(SHIPPED / name)) == [], name
        assert len(runs.load_run(SHIPPED / name).curve) == config.iterations, name


def test_every_stored_run_is_in_a_grid():
    planned = {name for path in GRIDS for name in load_grid(path)}
    assert {folder.name for folder in SHIPPED.iterdir()} == planned


def test_the_stored_runs_are_small_enough_to_clone():
    sizes = [os.path.getsize(path) for path in SHIPPED.rglob("*") if path.is_file()]
    assert sum(sizes) < 60e6


def test_a_switch_changes_one_thing_and_no_seed():
    studied = studies.switch_runs(SHIPPED)
    control = {run.name[-1]: load_config(run) for run in studied.pop(studies.CONTROL)}
    assert set(studied) == set(SWITCHED)
    assert len(control) == SEEDS
    for label, seeds in studied.items():
        assert len(seeds) == STUDIED
        for run in seeds:
            config = load_config(run)
            assert differences(config, control[run.name[-1]]) == SWITCHED[label]


@pytest.mark.parametrize(
    ("label", "change"),
    [
        ("aliased conjugate gradient", {"aliased_cg": True}),
        ("Fisher matrix damped by 0.1", {"damping": 0.1}),
        ("KL bound of 0.01, not 0.02", {"max_kl": 0.01}),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_a_switch_of_the_trust_region_changes_what_it_says(label, change):
    expected = dataclasses.replace(TrustRegion().for_actions(2), **change)
    for run in studies.switch_runs(SHIPPED)[label]:
        assert load_config(run).trust_region.for_actions(2) == expected


@pytest.mark.parametrize("algorithm", ["emrld", "emrld-ws"])
@pytest.mark.parametrize("varied", ["w_rl", "w_bc"])
def test_a_panel_of_the_sensitivity_varies_one_weight(algorithm, varied):
    panel = studies.sensitivity_runs(SHIPPED, algorithm, varied)
    assert list(panel) == [0.2, 0.4, 0.6, 0.8, 1.0]
    for value, seeds in panel.items():
        table_1 = (varied, value) == ("w_rl", 0.2)  # whose runs are the main comparison's
        assert len(seeds) == (SEEDS if table_1 else STUDIED)
        for run in seeds:
            config = load_config(run)
            rule = config.adaptation("optimal")
            weights = {"w_rl": rule.w_rl, "w_bc": rule.w_bc}
            assert weights.pop(varied) == value
            assert set(weights.values()) == {1.0}
            assert (config.env, config.demos, config.algorithm) == ("point2d", "optimal", algorithm)


@pytest.mark.parametrize("quality", ["optimal", "suboptimal"])
def test_a_panel_of_the_ablation_leaves_out_one_loss(quality):
    panel = studies.ablation_runs(SHIPPED, quality)
    control = {run.name[-1]: load_config(run) for run in panel.pop("EMRLD")}
    assert len(control) == SEEDS
    assert list(panel) == ["w_bc = 0", "w_rl = 0"]
    for label, seeds in panel.items():
        weight = label.partition(" ")[0]
        assert len(seeds) == STUDIED
        for run in seeds:
            config = load_config(run)
            assert changed(config, control[run.name[-1]], studies.ABLATION_END) == [weight]
            assert getattr(config.adaptation(quality), weight) == 0.0


@pytest.mark.parametrize(
    "pair", (*studies.WITHOUT_RL, studies.WITHOUT_RL_AGAIN), ids=lambda pair: pair.changed
)
def test_a_pair_without_rl_in_the_adaptation_differs_in_that_alone(pair):
    for config, control in twins(pair):
        assert changed(config, control, pair.end(SHIPPED)) == ["w_rl"]
        assert config.w_rl == 0.0 != control.w_rl  # which may be None, Table 1's


@pytest.mark.parametrize("pair", studies.CLONING_ALONE, ids=lambda pair: pair.changed)
def test_a_pair_of_cloning_alone_differs_in_the_loss_of_the_meta_update(pair):
    for config, control in twins(pair):
        assert config.adaptation("optimal") == control.adaptation("optimal")  # Meta-BC: w_rl = 0
        differing = changed(config, control, pair.end(SHIPPED))
        assert set(differing) == {"algorithm", "w_rl", "meta_update"}
        assert config.meta_update == "cloning-trpo"
        assert (control.algorithm, control.meta_update) == ("emrld", None)  # None: RL by TRPO


@pytest.mark.parametrize("pair", studies.DOUBLE_USE, ids=lambda pair: pair.changed)
def test_a_pair_of_double_use_differs_in_the_meta_update_alone(pair):
    for config, control in twins(pair):
        differing = changed(config, control, pair.end(SHIPPED))
        if config.meta_update == "cloning-trpo":
            assert (pair.title, differing) == ("in place of D^val", ["meta_update"])
        else:
            assert pair.title == f"beside it, weight {config.meta_w_bc:g}"
            assert config.meta_update == "rl-and-cloning-trpo"
            assert set(differing) - {"meta_w_bc"} == {"meta_update"}


def twins(pair):
    """Return the configuration of each changed run with that of the control of the same seed."""
    changed_runs, control_runs = pair.runs(SHIPPED)
    control = {run.name[-1]: load_config(run) for run in control_runs}
    assert len(changed_runs) in (STUDIED, SEEDS)
    return [(load_config(run), control[run.name[-1]]) for run in changed_runs]


def changed(config, control, end):
    """Return in which settings a run differs from its control, which may be longer than ``end``."""
    assert config.iterations == end <= control.iterations
    return differences(dataclasses.replace(control, iterations=end), config)


def prolonged(reading, name):
    """Return what may differ because curves still climbed: without the heading, three run on."""
    on = not reading.heading and name in TRAINED_ALIKE
    return {"iterations"} if on else set()


@pytest.mark.parametrize("reading", studies.READINGS, ids=lambda reading: reading.runs)
def test_the_variants_and_maml_train_equally_long_in_each_reading(reading):
    for name in (reading.runs, reading.narrow):
        stored = stored_seeds(SHIPPED, name, "optimal")
        lengths = [load_config(run).iterations for one in TRAINED_ALIKE for run in stored[one]]
        assert len(set(lengths)) == 1


@pytest.mark.parametrize("reading", studies.READINGS, ids=lambda reading: reading.runs)
def test_a_reading_differs_in_the_drift_and_in_the_state_alone(reading):
    stored = stored_seeds(SHIPPED, reading.runs, "optimal")
    first = stored_seeds(SHIPPED, studies.READINGS[0].runs, "optimal")
    for name, seeds in stored.items():
        for run in seeds:
            config = load_config(run)
            assert (config.env, config.heading) == (reading.env, reading.heading)
            twin = load_config(first[name][int(run.name[-1])])
            allowed = {"env", "heading"} | ({"adapt_lr"} if name == "meta-bc" else set())
            allowed |= prolonged(reading, name)
            assert set(differences(config, twin)) <= allowed  # a baseline has what its search chose


@pytest.mark.parametrize("reading", studies.READINGS, ids=lambda reading: reading.narrow)
def test_narrow_drifts_change_the_training_tasks_alone(reading):
    narrow = stored_seeds(SHIPPED, reading.narrow, "optimal")
    spread = stored_seeds(SHIPPED, reading.runs, "optimal")
    assert list(narrow) == list(spread)  # all five algorithms
    for name, seeds in narrow.items():
        for run, twin in zip(seeds, spread[name], strict=True):
            assert differences(load_config(run), load_config(twin)) == ["demos"]
        drifts = runs.load_run(seeds[0]).load_demonstrations().tasks
        assert float(drifts.abs().max()) == pytest.approx(studies.NARROW_DRIFT)


def test_new_seeds_are_seeds_that_no_control_had():
    old, new = (
        {load_config(run).seed for side in pair.runs(SHIPPED) for run in side}
        for pair in (studies.WITHOUT_RL[3], studies.WITHOUT_RL_AGAIN)
    )
    assert (len(old), len(new)) == (SEEDS, SEEDS)
    assert not old & new


def test_a_study_of_nothing_is_empty(tmp_path):
    assert studies.switch_runs(tmp_path) == {}
    assert studies.ablation_runs(tmp_path, "optimal") == {}
    with pytest.raises(InputError, match="known: w_bc, w_rl"):
        studies.sensitivity_runs(tmp_path, "emrld", "w_il")


def test_a_run_that_is_too_short_is_not_compared():
    seeds = seeds_of(SHIPPED, "point2d-optimal-emrld")
    assert training_scores(seeds, 100).shape == (5,)
    with pytest.raises(InputError, match="expected 1000 iterations, got 200"):
        training_scores(seeds, 1000)


@pytest.mark.parametrize("score", [training_scores, lambda runs: run_scores(runs, 1)])
def test_no_runs_have_no_scores(score):
    with pytest.raises(InputError, match="at least one stored run"):
        score([])


def test_a_step_that_was_not_tested_is_refused():
    with pytest.raises(InputError, match="expected rows of step 9, got none"):
        run_scores(seeds_of(SHIPPED, "point2d-optimal-emrld"), 9)


def test_the_late_return_is_the_mean_of_its_ten_iterations():
    (seed, *_) = seeds_of(SHIPPED, "point2d-optimal-emrld")
    lines = (seed / "curve.csv").read_text().splitlines()
    column = lines[0].split(",").index("return_after")
    late = [float(line.split(",")[column]) for line in lines[91:101]]  # iterations 90 to 99
    assert training_scores([seed], 100)[0] == pytest.approx(sum(late) / 10)


def test_a_pair_is_tested_where_both_were_trained_as_long():
    pair = studies.WITHOUT_RL[2]
    changed_scores, control_scores = pair.tested(SHIPPED)
    for scores, name in ((changed_scores, pair.changed), (control_scores, pair.control)):
        for seed, score in enumerate(scores):
            with (SHIPPED / f"{name}-seed{seed}" / "unseen.csv").open() as file:
                rows = [row for row in csv.DictReader(file) if row["step"] == "1"]
            assert score == pytest.approx(np.mean([float(row["return"]) for row in rows]))
    longer = studies.WITHOUT_RL[1]
    assert load_config(longer.runs(SHIPPED)[1][0]).iterations > longer.end(SHIPPED)
    assert longer.tested(SHIPPED) is None

"""Runs: the same curve every time, resumed after any stop, and nothing lost when things fail."""

import dataclasses
import errno
import itertools
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest
import safetensors
import safetensors.torch
import torch

from emrld_lite import policy, storage, trpo
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import SHIPPED as SHIPPED_DEMONSTRATIONS
from emrld_lite.demonstrations import load_demonstrations
from emrld_lite.envs import make
from emrld_lite.evaluate import adaptation_curve
from emrld_lite.experiments import (
    checkpoints,
    elsewhere,
    evaluation,
    machine,
    results,
    runs,
)
from emrld_lite.learners import trust_region
from emrld_lite.rollout import episode_returns
from emrld_lite.train import meta_train
from emrld_lite.validation import InputError

from .conftest import without_time

SMALL = TrainConfig(
    iterations=4,
    episodes=3,
    trust_region=trpo.TrustRegion(cg_iterations=3, fisher_samples=20),
)
ONCE = dataclasses.replace(SMALL, iterations=1)

# test_baselines trains every algorithm with its shapes checked, which takes twice the time
pytestmark = pytest.mark.usefixtures("shapes_unchecked")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the folder of a run of SMALL that was never stopped; tests only read it."""
    torch.set_num_threads(1)
    folder = tmp_path_factory.mktemp("whole") / "run"
    checkpoints.train_run(SMALL, folder)
    return folder


@pytest.fixture(scope="module")
def one_iteration(tmp_path_factory):
    torch.set_num_threads(1)
    folder = tmp_path_factory.mktemp("once") / "run"
    checkpoints.train_run(ONCE, folder)
    return folder


@pytest.fixture
def begun(one_iteration, tmp_path):
    """Return a copy of a run with one iteration, of this test's own."""
    return shutil.copytree(one_iteration, tmp_path / "run")


def test_the_same_seed_gives_the_same_run_bit_for_bit(tmp_path, whole):
    one, two = runs.load_run(whole), checkpoints.train_run(SMALL, tmp_path / "again")
    assert without_time(one.curve) == without_time(two.curve)
    assert all(torch.equal(one.meta_params[k], two.meta_params[k]) for k in one.meta_params)


def test_another_seed_gives_another_run(tmp_path, begun):
    two = checkpoints.train_run(dataclasses.replace(ONCE, seed=1), tmp_path / "b")
    assert without_time(runs.load_run(begun).curve) != without_time(two.curve)


@pytest.mark.parametrize("algorithm", ["emrld", "emrld-ws", "maml", "meta-bc", "gmps"])
def test_stop_and_resume_gives_the_same_curve_as_no_stop(tmp_path, algorithm):
    whole = dataclasses.replace(SMALL, algorithm=algorithm)
    straight = checkpoints.train_run(whole, tmp_path / "straight")
    checkpoints.train_run(dataclasses.replace(whole, iterations=2), tmp_path / "stopped")
    resumed = checkpoints.train_run(whole, tmp_path / "stopped", resume=True)
    assert without_time(resumed.curve) == without_time(straight.curve)
    assert all(
        torch.equal(resumed.meta_params[k], straight.meta_params[k]) for k in straight.meta_params
    )
    stored = runs.load_run(tmp_path / "stopped")
    assert without_time(stored.curve) == without_time(straight.curve)
    assert stored.learner_state


def test_a_run_folder_says_how_it_was_made(whole):
    assert json.loads((whole / "config.json").read_text())["algorithm"] == "emrld-ws"
    facts = json.loads((whole / "provenance.json").read_text())
    assert {"versions", "commit", "machine", "processor", "threads", "command"} <= set(facts)
    assert facts["processor"] == machine.processor()
    header = (whole / "curve.csv").read_text().splitlines()[0]
    assert header == (
        "iteration,seconds,env_steps,return_before,return_after,success_after,kl,backtracks,note,"
        "unmoved"
    )
    assert runs.load_run(whole).config == SMALL


def test_training_stops_at_the_asked_return(tmp_path):
    run = checkpoints.train_run(dataclasses.replace(SMALL, stop_at_return=-1.0), tmp_path / "run")
    assert len(run.curve) == 1


def test_a_run_from_before_a_setting_keeps_what_it_did(begun):
    path = begun / "config.json"
    older = {
        name: value for name, value in json.loads(path.read_text()).items() if name != "log_density"
    }
    path.write_text(json.dumps(older))
    assert runs.load_config(begun) == dataclasses.replace(ONCE, log_density="joint")


def test_a_run_is_not_overwritten_and_not_resumed_with_other_settings(tmp_path, begun):
    with pytest.raises(InputError, match="already holds a run"):
        checkpoints.train_run(SMALL, begun)
    with pytest.raises(InputError, match="seed differ"):
        checkpoints.train_run(dataclasses.replace(SMALL, seed=5), begun, resume=True)
    with pytest.raises(InputError, match="nothing to resume"):
        checkpoints.train_run(SMALL, tmp_path / "other", resume=True)


@pytest.mark.parametrize(("slowdown", "threads"), [(0.5, 2), (2.0, 1)])
def test_two_threads_are_chosen_only_where_they_are_faster(monkeypatch, slowdown, threads):
    """With a clock that runs ``slowdown`` times as fast while torch has two threads."""
    seconds = 0.0

    def clock():
        nonlocal seconds
        seconds += slowdown if torch.get_num_threads() == 2 else 1.0
        return seconds

    monkeypatch.setattr(machine.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(machine.time, "perf_counter", clock)
    assert machine.choose_threads() == threads
    assert torch.get_num_threads() == 1, "as it was"


def test_one_core_gets_one_thread(monkeypatch):
    monkeypatch.setattr(machine.os, "cpu_count", lambda: 1)
    assert machine.choose_threads() == 1


def test_threads_are_remembered(tmp_path, begun):
    assert machine.stored_threads(begun) == torch.get_num_threads()
    assert machine.stored_threads(tmp_path / "none") is None


def test_ctrl_c_leaves_a_whole_run_that_resumes(tmp_path, whole):
    def interrupt(iterate):
        if iterate.record.iteration == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        checkpoints.train_run(SMALL, tmp_path / "run", on_iteration=interrupt)
    assert len(runs.load_run(tmp_path / "run").curve) == 2
    resumed = checkpoints.train_run(SMALL, tmp_path / "run", resume=True)
    assert without_time(resumed.curve) == without_time(runs.load_run(whole).curve)


TRAINING = """
import sys, torch
from emrld_lite.config import TrainConfig
from emrld_lite.experiments.checkpoints import train_run
from emrld_lite.trpo import TrustRegion

torch.set_num_threads(1)
region = TrustRegion(fisher_samples=20, cg_iterations=2)
config = TrainConfig(reward="dense", iterations=400, episodes=1, trust_region=region)
train_run(config, sys.argv[1], checkpoint_every=2)
"""


def test_kill_9_in_the_middle_then_resume(tmp_path):
    out = tmp_path / "run"
    process = subprocess.Popen([sys.executable, "-c", TRAINING, str(out)])
    deadline = time.monotonic() + 120
    while not (out / "policy.safetensors").exists():
        assert process.poll() is None, "training ended before it was killed"
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    killed = runs.load_run(out)
    assert len(killed.curve) % 2 == 0
    more = dataclasses.replace(killed.config, iterations=len(killed.curve) + 2)
    resumed = checkpoints.train_run(more, out, resume=True)
    straight = checkpoints.train_run(more, tmp_path / "straight")
    assert without_time(resumed.curve) == without_time(straight.curve)


def test_a_full_disk_keeps_the_last_checkpoint(tmp_path, monkeypatch):
    checkpoints.train_run(dataclasses.replace(SMALL, iterations=2), tmp_path / "run")
    kept = (tmp_path / "run/policy.safetensors").read_bytes()

    def full(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(storage.os, "fsync", full)
        with pytest.raises(OSError, match=r"cannot write .*No space left.*previous version"):
            checkpoints.train_run(SMALL, tmp_path / "run", resume=True)
    assert (tmp_path / "run/policy.safetensors").read_bytes() == kept
    assert not list((tmp_path / "run").glob(".*")), "temporary files are cleaned up"
    resumed = checkpoints.train_run(SMALL, tmp_path / "run", resume=True)
    assert len(resumed.curve) == 4


def test_an_unwritable_folder_is_named_before_any_training(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(InputError, match="cannot write"):
        checkpoints.train_run(SMALL, tmp_path / "file" / "run")


def damage_curve(folder):
    text = (folder / "curve.csv").read_text()
    (folder / "curve.csv").write_text(text.replace("0,", "zero,", 1))


def damage_policy(folder):
    data = (folder / "policy.safetensors").read_bytes()
    (folder / "policy.safetensors").write_bytes(data[: len(data) // 2])


def damage_config(folder):
    (folder / "config.json").write_text('{"algorithm": "emrl"}')


def shape_policy(folder):
    path = folder / "policy.safetensors"
    tensors = safetensors.torch.load_file(path) | policy.initialise(3, 2, seed=0)
    storage.write_tensors(path, tensors, {"iterations": "1"})


def poison_policy(folder):
    path = folder / "policy.safetensors"
    tensors = safetensors.torch.load_file(path)
    tensors["bias_0"][3] = math.nan
    safetensors.torch.save_file(tensors, path, {"iterations": "1"})


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (damage_curve, r"curve\.csv: line 2"),
        (damage_policy, r"policy\.safetensors: not a readable"),
        (damage_config, r"config\.json: unknown algorithm 'emrl'.*Did you mean 'emrld'"),
        (shape_policy, r"weight_0: expected shape \(2, 100\), got \(3, 100\)"),
        (poison_policy, r"bias_0: a value that is not finite at index \(3,\)"),
    ],
)
def test_damaged_runs_are_refused_by_file_and_field(begun, damage, words):
    damage(begun)
    with pytest.raises(InputError, match=words):
        runs.load_run(begun)


def test_a_non_finite_update_never_reaches_the_policy(tmp_path, monkeypatch):
    original = trust_region.surrogate_gradient

    def broken(*arguments):
        piece = original(*arguments)
        return piece._replace(gradient=piece.gradient * math.nan)

    monkeypatch.setattr(trust_region, "surrogate_gradient", broken)
    run = checkpoints.train_run(SMALL, tmp_path / "run")
    start = policy.initialise(2, 2, seed=0)
    assert all(torch.equal(run.meta_params[name], start[name]) for name in start)
    notes = [record.note for record in runs.load_run(tmp_path / "run").curve]
    assert notes == ["skipped: the gradient is not finite"] * 4


def test_nothing_rewarded_is_said_and_changes_nothing():
    config = dataclasses.replace(SMALL, algorithm="maml", episodes=1)
    iterates = list(meta_train(config, load_demonstrations("optimal", "point2d")))
    for one, other in itertools.pairwise(iterates):
        if "nothing rewarded" in other.record.note:
            assert all(
                torch.equal(one.meta_params[k], other.meta_params[k]) for k in one.meta_params
            )
    assert any("nothing rewarded" in iterate.record.note for iterate in iterates)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("iterations", 0, "iterations: expected a whole number of at least 1"),
        ("iterations", -3, "iterations"),
        ("episodes", 0, "episodes"),
        ("episodes", 2.5, "episodes"),
        ("seed", -1, "seed"),
        ("discount", 1.5, "discount"),
        ("discount", math.nan, "discount"),
        ("algorithm", "emrld_ws", "Did you mean 'emrld-ws'"),
        ("env", "point", "Did you mean 'point2d'"),
        ("network_start", "xavir", "Did you mean 'xavier'"),
        ("bc_reduction", "meen", "Did you mean 'mean'"),
        ("w_rl", -1.0, "w_rl"),
        ("adapt_lr", math.inf, "adapt_lr"),
    ],
)
def test_bad_settings_are_refused_at_the_door(field, value, words):
    with pytest.raises(InputError, match=words):
        dataclasses.replace(SMALL, **{field: value})


def test_demonstrations_of_another_environment_are_refused():
    foreign = dataclasses.replace(
        load_demonstrations("optimal", "point2d"), environment="two_wheeled"
    )
    with pytest.raises(InputError, match="expected environment 'point2d', got 'two_wheeled'"):
        next(meta_train(SMALL, foreign))


def test_adaptation_curve_keeps_tasks_apart():
    """A task's curve does not change when the other tasks' demonstrations do."""
    data = load_demonstrations("optimal", "point2d")
    stored = runs.load_run(runs.SHIPPED / "point2d-optimal-emrld-ws-seed0")
    meta_params, rule = stored.meta_params, stored.config.adaptation("optimal")

    def masked(rollout):
        """Return the states walked, (task, episode, 100, 2): a batch ends with its last episode."""
        walked = rollout.states * rollout.mask[..., None]
        return torch.nn.functional.pad(walked, (0, 0, 0, 100 - walked.shape[2]))

    def first_task(demonstrations):
        random = torch.Generator().manual_seed(0)
        curve = adaptation_curve(make("point2d"), meta_params, demonstrations, rule, 2, 4, random)
        return [masked(rollout)[0] for rollout in curve.rollouts], curve

    alone, curve = first_task(data)
    # the other eleven tasks get one another's paths
    order = [0, *range(11, 0, -1)]
    shuffled = dataclasses.replace(
        data, states=data.states[order], actions=data.actions[order], mask=data.mask[order]
    )
    together, _ = first_task(shuffled)
    assert all(
        torch.allclose(one, other, atol=1e-4) for one, other in zip(alone, together, strict=True)
    )
    returns = [float(episode_returns(rollout).mean()) for rollout in curve.rollouts]
    assert len(returns) == 3
    assert returns[1] > returns[0] + 20


def test_by_its_mean_action_a_policy_walks_as_a_plain_loop_says():
    stored = runs.load_run(runs.SHIPPED / "point2d-optimal-meta-bc-seed1")
    shown = evaluation.testing_demonstrations(stored, tasks=3)
    sampled = evaluation.evaluate_run(stored, shown, steps=1, episodes=5)
    rollout = evaluation.acting_by_mean(stored, shown, sampled).rollouts[1]
    assert rollout.states.shape[:2] == (3, 1)  # one episode: there is nothing to average
    for task in range(3):
        place = torch.zeros(2)
        adapted = {name: value[task : task + 1] for name, value in sampled.policies[1].items()}
        for time_step in range(int(rollout.mask[task].sum())):
            assert rollout.states[task, 0, time_step] == pytest.approx(place, abs=1e-3)
            (mean,) = policy.distribution(adapted, place[None]).mean
            move = 0.1 * mean.clamp(-1, 1)
            place = place + move * min(1.0, 0.1 / float(move.norm()))


def test_the_warm_start_of_a_stored_run_is_measured_as_a_plain_loop_says():
    """Two layers by hand, torch's own Gaussian, and one step of plain gradient descent per task."""
    stored = runs.load_run(runs.SHIPPED / "point2d-optimal-emrld-ws-seed0")
    shown = stored.load_demonstrations()
    before, after = evaluation.cloning_before_and_after_warm_start(stored)

    def loss(leaves, task):
        taken = shown.mask[task].bool()
        features = shown.states[task][taken]
        for layer in (0, 1):
            features = torch.relu(features @ leaves[f"weight_{layer}"] + leaves[f"bias_{layer}"])
        mean = features @ leaves["weight_2"] + leaves["bias_2"]
        normal = torch.distributions.Normal(mean, leaves["log_sigma"].exp())
        return -normal.log_prob(shown.actions[task][taken]).mean()

    for task in (0, 7):
        leaves = {
            name: value.detach().requires_grad_() for name, value in stored.meta_params.items()
        }
        first = loss(leaves, task)
        gradient = torch.autograd.grad(first, list(leaves.values()))
        moved = {
            name: value - stored.config.adapt_lr * slope
            for (name, value), slope in zip(leaves.items(), gradient, strict=True)
        }
        assert float(before[task]) == pytest.approx(first.item(), rel=1e-3)
        assert float(after[task]) == pytest.approx(loss(moved, task).item(), rel=1e-2)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("point2d-optimal-emrld-ws", 70, 85),
        ("point2d-optimal-emrld", 70, 85),
        ("point2d-suboptimal-emrld", 60, 85),
        ("point2d-optimal-maml", -1, 15),
        ("point2d-optimal-maml-xavier", -1, 10),
    ],
)
def test_stored_runs_show_what_the_readme_says(name, low, high):
    seeds = results.seeds_of(runs.SHIPPED, name)
    assert all(low <= value <= high for value in results.training_scores(seeds))


def test_maml_starves_on_point2d():
    for folder in results.seeds_of(runs.SHIPPED, "point2d-optimal-maml"):
        assert runs.load_run(folder).curve[59].return_after < 5


@pytest.mark.parametrize("name", ["optimal-emrld-ws", "optimal-emrld", "suboptimal-emrld"])
def test_one_step_on_unseen_goals_gives_nine_tenths(name):
    for folder in results.seeds_of(runs.SHIPPED, f"point2d-{name}"):
        unseen = results.returns_by_step(folder)
        assert unseen[1] >= 0.9 * runs.load_run(folder).curve[-1].return_after


def test_stored_runs_have_no_stray_files():
    allowed = {"config.json", "curve.csv", "policy.safetensors", "provenance.json"}
    allowed |= {evaluation.SAMPLED, evaluation.BY_MEAN, evaluation.CUT}
    for folder in runs.SHIPPED.iterdir():
        assert {path.name for path in folder.iterdir()} <= allowed


def test_the_first_iterations_of_a_stored_run_can_be_replayed_anywhere(tmp_path):
    """The draws are the same everywhere; only rounding differs, and grows with the iterations.

    A policy that stood still would earn nothing, diverge by nothing, and meet the second
    iteration's return with another.
    """
    folder = runs.SHIPPED / "point2d-optimal-emrld-ws-seed3"
    stored = runs.load_run(folder)
    facts = json.loads((folder / "provenance.json").read_text())
    assert re.fullmatch("[0-9a-f]{40}", facts["commit"])
    config = dataclasses.replace(stored.config, iterations=2)
    first, second = checkpoints.train_run(config, tmp_path / "again").curve
    for name in ("return_before", "return_after", "kl", "env_steps"):
        assert getattr(first, name) == pytest.approx(getattr(stored.curve[0], name), rel=1e-3)
    assert second.return_before == pytest.approx(stored.curve[1].return_before, rel=1e-2)
    assert second.return_before > 5 * first.return_before > 0.1


@pytest.fixture(scope="module")
def repeated(tmp_path_factory):
    """The portable run as stored, and its first three iterations made again."""
    again = tmp_path_factory.mktemp("portable") / "again"
    stored = runs.load_run(elsewhere.PORTABLE_RUN)
    return stored.curve[:3], elsewhere.repeat(elsewhere.PORTABLE_RUN, again, iterations=3)


def test_the_portable_run_begins_alike_everywhere(repeated):
    stored, again = repeated
    assert len(again) == 3
    for name in ("return_before", "return_after", "kl", "env_steps"):
        assert getattr(again[0], name) == pytest.approx(getattr(stored[0], name), rel=1e-3)


def test_the_portable_run_is_repeated_digit_for_digit_where_that_was_seen(repeated):
    facts = json.loads((elsewhere.PORTABLE_RUN / "provenance.json").read_text())
    assert (facts["variables"], facts["threads"]) == (machine.PORTABLE, 1)
    if not machine.repeats_digits(facts):
        pytest.skip(f"digits were not seen to be the same on {machine.processor()}")
    stored, again = repeated
    assert without_time(again) == without_time(stored)


@pytest.mark.parametrize(
    ("processor", "torch_version", "repeats"),
    [
        ("AMD EPYC, cpu family 25, model 17, stepping 1, DEFAULT", "2.13.0+cpu", True),
        ("AMD EPYC, cpu family 25, model 17, stepping 1, DEFAULT", "2.13.1+cpu", False),
        (
            "Intel(R) Xeon(R) Processor, cpu family 6, model 207, stepping 2, DEFAULT",
            "2.13.0+cpu",
            False,
        ),
        (
            "AMD EPYC 7763 64-Core Processor, cpu family 25, model 1, stepping 1, AVX2",
            "2.13.0+cpu",
            False,
        ),
        ("arm", "2.13.0+cpu", False),
    ],
)
def test_digits_are_promised_only_where_they_were_seen(
    monkeypatch, processor, torch_version, repeats
):
    made = json.loads((elsewhere.PORTABLE_RUN / "provenance.json").read_text())
    versions = {**made["versions"], "torch": torch_version}
    monkeypatch.setattr(machine, "processor", lambda: processor)
    monkeypatch.setattr(machine.metadata, "version", versions.__getitem__)
    assert machine.repeats_digits({**made, "versions": versions}) is (
        repeats or "2.13.1" in torch_version
    )
    assert machine.repeats_digits(made) is repeats
    assert not machine.repeats_digits({**made, "variables": {}})


# --- what belongs together ----------------------------------------------------------------------


def own_demonstrations(tmp_path):
    """Return the configuration of a run on a file of its own, and the file."""
    path = tmp_path / "mine.npz"
    shutil.copy(SHIPPED_DEMONSTRATIONS / "point2d-optimal.npz", path)
    return dataclasses.replace(SMALL, demos=str(path), iterations=1), path


def test_other_demonstrations_under_the_same_name_are_noticed(tmp_path):
    config, path = own_demonstrations(tmp_path)
    checkpoints.train_run(config, tmp_path / "run")
    shutil.copy(SHIPPED_DEMONSTRATIONS / "point2d-suboptimal.npz", path)
    more = dataclasses.replace(config, iterations=2)
    with pytest.raises(InputError, match=r"demos: expected .*mine\.npz' holds others now"):
        checkpoints.train_run(more, tmp_path / "run", resume=True)
    with pytest.raises(InputError, match="holds others now"):
        evaluation.testing_demonstrations(runs.load_run(tmp_path / "run"), 1)


def test_the_same_demonstrations_are_known_wherever_they_lie(tmp_path):
    config, path = own_demonstrations(tmp_path)
    checkpoints.train_run(config, tmp_path / "run")
    moved = path.rename(tmp_path / "moved.npz")
    path.symlink_to(moved)
    more = dataclasses.replace(config, iterations=2)
    assert len(checkpoints.train_run(more, tmp_path / "run", resume=True).curve) == 2


def test_a_run_is_not_cut_shorter_by_a_resume(tmp_path):
    checkpoints.train_run(dataclasses.replace(SMALL, iterations=3), tmp_path / "run")
    with pytest.raises(InputError, match="iterations: expected at least the 3"):
        checkpoints.train_run(
            dataclasses.replace(SMALL, iterations=2), tmp_path / "run", resume=True
        )
    assert runs.load_config(tmp_path / "run").iterations == 3


def test_a_resume_with_other_threads_is_written_down(begun, monkeypatch):
    here = machine.provenance()
    monkeypatch.setattr(machine, "provenance", lambda: {**here, "threads": 7})
    for iterations in (2, 3):
        more = dataclasses.replace(SMALL, iterations=iterations)
        checkpoints.train_run(more, begun, resume=True)
    facts = json.loads((begun / "provenance.json").read_text())
    assert facts["threads"] == here["threads"]
    assert facts["resumed"] == [{"from_iteration": 1, "threads": 7}], "once, not at each resume"


def test_a_machine_without_git_trains_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    checkpoints.train_run(ONCE, tmp_path / "run")
    assert json.loads((tmp_path / "run/provenance.json").read_text())["commit"] == "unknown"


def test_a_start_that_fails_leaves_nothing_in_the_way(tmp_path, monkeypatch):
    def full(path, content):
        raise OSError("disk full")

    with monkeypatch.context() as patch:
        patch.setattr(runs.storage, "write_json", full)
        with pytest.raises(OSError):
            checkpoints.train_run(ONCE, tmp_path / "run")
    assert len(checkpoints.train_run(ONCE, tmp_path / "run").curve) == 1


def test_stale_temporary_files_are_cleaned_up_by_a_resume(begun):
    (begun / ".curve.csv.a1b2c3").write_text("killed here")
    checkpoints.train_run(dataclasses.replace(SMALL, iterations=2), begun, resume=True)
    assert not list(begun.glob(".*"))


def test_numbers_that_could_not_be_read_back_are_not_written(tmp_path):
    run = checkpoints.train_run(dataclasses.replace(ONCE, algorithm="gmps"), tmp_path / "run")
    before = (tmp_path / "run/policy.safetensors").read_bytes()
    name = next(name for name in run.learner_state if "exp_avg_sq" in name)
    spoiled = {**run.learner_state, name: run.learner_state[name] + math.inf}
    with pytest.raises(InputError, match=rf"{name}: a value that is not finite"):
        checkpoints.save_checkpoint(tmp_path / "run", run._replace(learner_state=spoiled))
    assert (tmp_path / "run/policy.safetensors").read_bytes() == before


def test_adam_refuses_a_step_that_its_memory_cannot_hold(tmp_path):
    config = dataclasses.replace(SMALL, algorithm="meta-bc", adapt_lr=1e3)
    checkpoints.train_run(config, tmp_path / "run")
    assert any("not finite" in record.note for record in runs.load_run(tmp_path / "run").curve)


def test_a_policy_with_a_changed_number_is_noticed(begun):
    run, path = runs.load_run(begun), begun / "policy.safetensors"
    with safetensors.safe_open(path, "pt") as file:
        facts = file.metadata()
    run.meta_params["bias_0"][0] += 1.0
    safetensors.torch.save_file({**run.meta_params, **run.learner_state}, path, facts)
    with pytest.raises(InputError, match="a number was changed"):
        runs.load_run(begun)


def test_every_stored_run_loads():
    assert all(runs.load_run(folder).curve for folder in runs.SHIPPED.iterdir())


def test_kill_stops_a_training_whole(tmp_path):
    out = tmp_path / "run"
    flags = ["--iterations", "400", "--episodes", "1", "--fisher-samples", "20", "--threads", "1"]
    command = [sys.executable, "-m", "emrld_lite", "train", "--out", str(out), *flags]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = b""
    while not re.search(rb" [2-9]/400 ", said):
        more = os.read(process.stderr.fileno(), 1000)
        assert more, "training ended before it was killed"
        said += more
    process.terminate()
    said += process.communicate(timeout=60)[1]
    assert process.returncode == 143
    assert said.decode().splitlines()[-1] == (
        f"stopped; {out} is whole: go on with the same command and --resume"
    )
    shown = max(map(int, re.findall(rb" (\d+)/400 ", said)))
    assert len(runs.load_run(out).curve) >= shown, "not one iteration is lost"

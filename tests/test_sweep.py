"""Sweeps with real schedulers and workers on loopback, some of them killed in mid-run."""

import contextlib
import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest
import torch
from distributed import Client
from distributed.security import Security
from filelock import FileLock

from emrld_lite import storage
from emrld_lite.__main__ import main
from emrld_lite.config import TrainConfig
from emrld_lite.experiments import checkpoints, runs
from emrld_lite.experiments.cluster import local_cluster
from emrld_lite.experiments.grid import command_of, load_grid
from emrld_lite.experiments.sweep import (
    announcement,
    is_shorter,
    iterations_done,
    make_run,
    partial_folder,
    quiet,
    sweep,
)
from emrld_lite.trpo import TrustRegion
from emrld_lite.validation import InputError

GRID = """
[[runs]]
algorithm = ["emrld-ws", "gmps"]
seed = [0, 1]
iterations = 20
episodes = 2
fisher_samples = 20
cg_iterations = 2
"""
RUNS = """
[[runs]]
algorithm = ["emrld-ws", "gmps"]
reward = "dense"  # so that every iteration moves the policy: one lost, or done twice, shows
iterations = 6
episodes = 1
fisher_samples = 20
cg_iterations = 2
"""
OFTEN = 2  # iterations from one checkpoint to the next

# test_baselines trains every algorithm with its shapes checked, which takes twice the time
pytestmark = pytest.mark.usefixtures("shapes_unchecked")


def written(tmp_path, text=GRID):
    path = tmp_path / "grid.toml"
    path.write_text(text)
    return path


def without_time(curve):
    return [record._replace(seconds=0.0) for record in curve]


# --- the grid -----------------------------------------------------------------------------------


def test_a_block_is_the_product_of_its_lists(tmp_path):
    grid = load_grid(written(tmp_path))
    assert list(grid) == [
        "point2d-optimal-emrld-ws-seed0",
        "point2d-optimal-emrld-ws-seed1",
        "point2d-optimal-gmps-seed0",
        "point2d-optimal-gmps-seed1",
    ]
    expected = TrainConfig(
        algorithm="gmps",
        seed=1,
        iterations=20,
        episodes=2,
        trust_region=TrustRegion(fisher_samples=20, cg_iterations=2),
    )
    assert grid["point2d-optimal-gmps-seed1"] == expected


def test_a_block_names_its_runs_by_their_options(tmp_path):
    text = '[[runs]]\nname = "w{w_rl}-kl{max_kl}"\nw_rl = [0.2, 1.0]\nmax_kl = 0.5\n'
    grid = load_grid(written(tmp_path, text))
    assert list(grid) == ["w0.2-kl0.5", "w1.0-kl0.5"]
    assert grid["w1.0-kl0.5"].trust_region.max_kl == 0.5


def test_the_command_of_a_run_makes_the_same_run(tmp_path):
    config = TrainConfig(
        env="two_wheeled",
        seed=3,
        learn_sigma=False,
        w_bc=0.5,
        trust_region=TrustRegion(damping=0.2),
    )
    words = command_of(config, "out").split()
    flags = {word for word in words if word.startswith("--")}
    assert flags == {
        "--env", "--algorithm", "--demos", "--seed", "--iterations", "--no-learn-sigma", "--w-bc",
        "--damping", "--threads", "--out",
    }  # fmt: skip
    small = dataclasses.replace(config, iterations=1, episodes=1)
    words = command_of(small, str(tmp_path / "run")).split()
    assert words[:3] == ["python", "-m", "emrld_lite"]
    main(words[3:])
    assert runs.load_config(tmp_path / "run") == small


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("runs = 3", r"\[\[runs\]\] blocks"),
        ("[[runs]\n", "not a readable grid in TOML"),
        ("[[runs]]\nalgoritm = 'maml'", "block 1: unknown options: algoritm"),
        ("[[runs]]\nalgorithm = 'mamml'", "block 1: .*Did you mean 'maml'"),
        ("[[runs]]\n", "block 1: expected options of train, at least one"),
        ("[[runs]]\nseed = []", "block 1: expected 1 to 10000 runs .*got 0"),
        (f"[[runs]]\nseed = {[*range(101)]}\nepisodes = {[*range(1, 101)]}", "got 10100"),
        ("[[runs]]\nseed = 0\n[[runs]]\nseed = 0", "block 2: a second run named 'point2d-optimal"),
        (
            "[[runs]]\nnormalise = 'false'",
            "block 1: normalise: expected true or false, got 'false'",
        ),
        ("[[runs]]\nseed = 0\nname = '{wrl}'", "no option 'wrl'"),
        ("[[runs]]\nseed = 0\nname = '../{env}'", "expected a folder's name"),
    ],
)
def test_a_grid_that_cannot_be_run_is_refused_by_block(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        load_grid(written(tmp_path, text))


# --- one run ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def straight(tmp_path_factory):
    """Return the curve of every run of the grid, made without a sweep."""
    folder = tmp_path_factory.mktemp("straight")
    torch.set_num_threads(1)
    grid = load_grid(written(folder, RUNS))
    return {
        name: checkpoints.train_run(config, folder / name).curve for name, config in grid.items()
    }


def test_a_run_goes_on_where_it_was_left_and_appears_when_it_is_whole(tmp_path, straight):
    name = "point2d-optimal-gmps-seed0"
    config = load_grid(written(tmp_path, RUNS))[name]
    place = tmp_path / "out" / "run"
    checkpoints.train_run(dataclasses.replace(config, iterations=3), partial_folder(place))
    assert iterations_done(place) == 3
    make_run(config, str(place))
    assert [path.name for path in place.parent.iterdir()] == ["run"]
    assert without_time(runs.load_run(place).curve) == without_time(straight[name])
    assert (place / "unseen.csv").exists()


def test_a_finished_run_goes_on_when_the_grid_wants_more_iterations(tmp_path, straight):
    name = "point2d-optimal-gmps-seed0"
    config = load_grid(written(tmp_path, RUNS))[name]
    place = tmp_path / "out" / name
    make_run(dataclasses.replace(config, iterations=3), str(place))
    before = (place / "unseen.csv").read_text()
    assert is_shorter(place, config)
    assert iterations_done(place) == 3  # what the progress bar begins with
    make_run(config, str(place))
    assert not is_shorter(place, config)
    assert without_time(runs.load_run(place).curve) == without_time(straight[name])
    assert (place / "unseen.csv").read_text() != before  # tested again
    assert [path.name for path in place.parent.iterdir()] == [name]
    shorter = dataclasses.replace(config, iterations=2)  # a longer run is not cut
    with pytest.raises(InputError, match="iterations differ"):
        sweep({name: shorter}, place.parent)


# --- many runs ----------------------------------------------------------------------------------


@contextlib.contextmanager
def dask(*arguments, waits_for):
    """Start a Dask program on loopback and wait for a line; yields the process and that line."""
    command = [sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:]]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )
    try:
        for line in process.stderr:
            if found := re.search(waits_for, line):
                break
        else:
            raise AssertionError(f"{command} ended")
        drain = threading.Thread(target=process.stderr.read, daemon=True)
        drain.start()
        yield process, found
    finally:
        process.kill()
        process.wait()


def scheduler():
    return dask("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
                waits_for=r"Scheduler at:\s+(tcp://\S+)")  # fmt: skip


def worker(address):
    return dask("dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
                "--host", "127.0.0.1", waits_for="Starting established connection")  # fmt: skip


def when_some_run_has(out, grid, iterations, then):
    """In the background: call ``then`` once an unfinished run has so many iterations on disk."""

    def watch():
        while not any(
            iterations <= iterations_done(out / name) < config.iterations
            for name, config in grid.items()
        ):
            time.sleep(0.02)
        then()

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    return thread


def kill(*processes):
    for process in processes:
        os.kill(process.pid, signal.SIGKILL)


def assert_whole(out, straight):
    assert {path.name for path in out.iterdir()} == set(straight)
    for name, curve in straight.items():
        assert without_time(runs.load_run(out / name).curve) == without_time(curve)
        facts = json.loads((out / name / "provenance.json").read_text())
        assert facts["command"] == command_of(runs.load_config(out / name), f"data/runs/{name}")


def test_a_killed_worker_loses_nothing(tmp_path, straight):
    grid, out = load_grid(written(tmp_path, RUNS)), tmp_path / "out"
    with scheduler() as (_, found), worker(found[1]) as (doomed, _), worker(found[1]):
        killer = when_some_run_has(out, grid, OFTEN, lambda: kill(doomed))
        outcome = sweep(grid, out, scheduler=found[1], checkpoint_every=OFTEN)
        killer.join(timeout=1)
        assert doomed.poll() == -signal.SIGKILL
    assert (sorted(outcome.made), outcome.failed) == (sorted(grid), {})
    assert_whole(out, straight)


def test_a_lost_scheduler_is_said_and_the_same_sweep_goes_on(tmp_path, straight):
    """With its only worker, so that a run is left half made for certain."""
    grid, out = load_grid(written(tmp_path, RUNS)), tmp_path / "out"
    with scheduler() as (doomed, found), worker(found[1]) as (alone, _):
        when_some_run_has(out, grid, OFTEN, lambda: kill(doomed, alone))
        with pytest.raises(InputError, match="scheduler was lost"):
            sweep(grid, out, scheduler=found[1], checkpoint_every=OFTEN, patience=3.0)
    left = [iterations_done(out / name) for name in grid]
    assert any(OFTEN <= done < 6 for done in left)
    sweep(grid, out, workers=2)
    assert_whole(out, straight)


def test_a_finished_sweep_repeats_nothing(tmp_path):
    grid, out = load_grid(written(tmp_path)), tmp_path / "out"
    for name, config in grid.items():
        storage.write_json(out / name / "config.json", dataclasses.asdict(config))
    outcome = sweep(grid, out, scheduler="tcp://127.0.0.1:1")  # would not answer if it were asked
    assert (outcome.made, outcome.kept) == ([], list(grid))


@pytest.mark.parametrize("algorithm", ["emrld-ws", "gmps"])
def test_a_run_can_be_kept_without_its_learner_s_memory(tmp_path, straight, algorithm):
    name = f"point2d-optimal-{algorithm}-seed0"
    grid = {name: load_grid(written(tmp_path, RUNS))[name]}
    make_run(dataclasses.replace(grid[name], iterations=3), str(tmp_path / name))
    whole = runs.load_run(tmp_path / name)
    assert whole.learner_state
    sizes = [(tmp_path / name / "policy.safetensors").stat().st_size]
    checkpoints.forget_memory(tmp_path / name)
    sizes.append((tmp_path / name / "policy.safetensors").stat().st_size)
    thin = runs.load_run(tmp_path / name)
    assert sizes[1] < 0.6 * sizes[0]
    assert (thin.curve, thin.learner_state) == (whole.curve, {})
    assert all(
        torch.equal(thin.meta_params[one], whole.meta_params[one]) for one in thin.meta_params
    )
    outcome = sweep(grid, tmp_path, workers=1, forget=True)  # goes on, with a fresh memory
    assert outcome.made == [name]
    again = runs.load_run(tmp_path / name)
    assert (len(again.curve), again.learner_state) == (6, {})
    assert without_time(again.curve)[:3] == without_time(straight[name])[:3]
    assert (
        again.curve[3].return_after == straight[name][3].return_after
    )  # of the policy that was kept
    assert again.curve[3].kl != straight[name][3].kl  # the first update without the memory
    facts = json.loads((tmp_path / name / "provenance.json").read_text())
    assert facts["resumed"][-1] == {"from_iteration": 3, "memory": "fresh"}


def test_a_damaged_run_is_named_and_the_others_forget(tmp_path):
    grid = {
        name: dataclasses.replace(config, iterations=1)
        for name, config in load_grid(written(tmp_path, RUNS)).items()
    }
    for name, config in grid.items():
        checkpoints.train_run(config, tmp_path / "out" / name)
    first, second = grid
    (tmp_path / "out" / first / "curve.csv").write_text("")
    outcome = sweep(grid, tmp_path / "out", forget=True)  # all are there: nothing is trained
    assert (outcome.made, list(outcome.failed)) == ([], [first])
    assert runs.load_run(tmp_path / "out" / second).learner_state == {}


def test_a_run_is_not_thinned_while_another_sweep_writes_it(tmp_path):
    name, config = next(iter(load_grid(written(tmp_path, RUNS)).items()))
    grid = {name: dataclasses.replace(config, iterations=1)}
    checkpoints.train_run(grid[name], tmp_path / name)
    with FileLock(f"{partial_folder(tmp_path / name)}.lock"):  # as the other sweep holds it
        thinning = threading.Thread(target=sweep, args=(grid, tmp_path), kwargs={"forget": True})
        thinning.start()
        thinning.join(0.5)
        assert thinning.is_alive()
        assert runs.load_run(tmp_path / name).learner_state
    thinning.join(30)
    assert not runs.load_run(tmp_path / name).learner_state


def test_a_run_of_other_settings_is_not_taken_for_one_of_the_grid(tmp_path):
    grid, out = load_grid(written(tmp_path)), tmp_path / "out"
    name, config = next(iter(grid.items()))
    other = dataclasses.replace(config, w_rl=0.7, episodes=3)
    storage.write_json(out / name / "config.json", dataclasses.asdict(other))
    with pytest.raises(InputError, match=r"seed0: holds .* episodes, w_rl differ"):
        sweep(grid, out)


def test_trpo_s_settings_count_as_they_act():
    stated = TrainConfig(trust_region=TrustRegion(max_kl=0.02))
    assert runs.differences(TrainConfig(), stated) == []
    cheetah = dataclasses.replace(stated, env="half_cheetah")  # there the default is 0.06
    assert runs.differences(TrainConfig(env="half_cheetah"), cheetah) == ["trust_region"]
    cloning = TrainConfig(algorithm="gmps")
    assert runs.differences(cloning, dataclasses.replace(stated, algorithm="gmps")) == []


def test_the_shipped_grids_can_be_run():
    shipped = sorted((runs.SHIPPED.parent / "grids").glob("*.toml"))
    assert shipped
    assert all(load_grid(path) for path in shipped)


def test_a_scheduler_that_does_not_answer_is_named(tmp_path):
    with pytest.raises(InputError, match="cannot reach"):
        sweep(
            load_grid(written(tmp_path)),
            tmp_path / "out",
            scheduler="tcp://127.0.0.1:1",
            patience=0.5,
        )


def test_a_run_that_fails_is_named_and_the_others_are_made(tmp_path):
    broken = "[[runs]]\nname = 'broken'\ndemos = 'nowhere.npz'\n"
    text = broken + RUNS.replace("iterations = 6", "iterations = 1")
    grid = load_grid(written(tmp_path, text))
    outcome = sweep(grid, tmp_path / "out", workers=1)
    assert outcome.made == [name for name in grid if name != "broken"] != []
    assert list(outcome.failed) == ["broken"]
    assert "no such demonstration file" in outcome.failed["broken"]


def test_no_workers_are_refused(tmp_path):
    with pytest.raises(InputError, match="workers"):
        sweep(load_grid(written(tmp_path)), tmp_path / "out", workers=0)


def test_a_local_sweep_listens_to_those_with_its_certificate_only():
    """Every port of every process answers no HTTP, and the scheduler neither TCP nor a stranger's TLS."""
    with quiet(), local_cluster(1) as cluster, Client(cluster, security=cluster.security) as client:
        assert client.submit(max, 2, 3).result(timeout=30) == 3
        own = psutil.Process()
        ports = {
            place.laddr
            for process in (own, *own.children(recursive=True))
            for place in process.net_connections(kind="inet")
            if place.status == psutil.CONN_LISTEN
        }
        known = {cluster.scheduler.address, *(nanny.address for nanny in cluster.workers.values())}
        known |= {nanny.worker_address for nanny in cluster.workers.values()}
        assert {f"tls://{place.ip}:{place.port}" for place in ports} == known
        address = cluster.scheduler_address
        for door, security in (
            (address.replace("tls", "tcp"), None),
            (address, Security.temporary()),
        ):
            with pytest.raises(OSError):
                Client(door, security=security, timeout="5s")


def test_a_sweep_says_how_much_it_begins(tmp_path):
    said = announcement(load_grid(written(tmp_path)), 2)
    assert re.fullmatch(
        r"4 runs to make, at the stored runs' pace about \d+ s / 2 workers = \d+ s", said
    )

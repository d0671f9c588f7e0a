"""The command line as scripts use it: exit codes, one-line errors, the files it leaves."""

import csv
import shutil
import subprocess
import sys

import pytest
import torch

from emrld_lite.__main__ import main
from emrld_lite.algorithms import ALGORITHMS
from emrld_lite.demonstrations import load
from emrld_lite.envs import ENVIRONMENTS
from emrld_lite.experiments.results import returns_by_step
from emrld_lite.experiments.runs import SHIPPED

OPTIMAL = ["demos", "--env", "point2d", "--quality", "optimal"]
STORED = str(SHIPPED / "point2d-optimal-emrld-seed0")
FAST = ["--episodes", "2", "--threads", "1"]


def test_train_then_evaluate(tmp_path):
    """The first as a program of its own, as a script starts it."""
    options = ["--env", "point2d", "--algorithm", "emrld", "--demos", "suboptimal",
               "--iterations", "2", "--seed", "3", "--out", str(tmp_path / "run"), *FAST]  # fmt: skip
    command = [sys.executable, "-m", "emrld_lite", "train", *options]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    assert "training tasks" in made.stdout
    table = tmp_path / "table.csv"
    main(["evaluate", "--run", str(tmp_path / "run"), "--tasks", "4", "--steps", "2",
          "--seed", "1", "--episodes", "2", "--out", str(table)])  # fmt: skip
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == 4 * 3
    assert {row["step"] for row in rows} == {"0", "1", "2"}
    assert all(0.0 <= float(row["success"]) <= 1.0 for row in rows)


def test_demonstrations_of_many_tasks_come_from_the_workbook_s_expert(tmp_path):
    files = [tmp_path / name for name in ("clean.npz", "noisy.npz", "again.npz")]
    for path, noise in zip(files, ("0", "0.5", "0.5"), strict=True):
        main(["demos", "--env", "two_wheeled", "--quality", "optimal", "--tasks", "30",
              "--noise", noise, "--seed", "4", "--out", str(path)])  # fmt: skip
    clean, noisy = (load(path, "two_wheeled") for path in files[:2])
    assert len(clean.tasks) == 30
    assert torch.equal(clean.tasks, noisy.tasks)
    assert not torch.equal(clean.actions[:, :, :5], noisy.actions[:, :, :5])
    assert files[1].read_bytes() == files[2].read_bytes()


def test_an_evaluation_says_how_later_steps_went(tmp_path):
    run_folder = SHIPPED / "point2d-suboptimal-emrld-seed0"
    tables = {}
    for rate in ("0.1", "1"):
        out = tmp_path / rate / "unseen.csv"
        main(["evaluate", "--run", str(run_folder), "--tasks", "5", "--episodes", "5", "--steps",
              "2", "--later-rate", rate, "--out", str(out)])  # fmt: skip
        tables[rate] = returns_by_step(out.parent)
    assert tables["0.1"][1] == tables["1"][1] > 50
    assert tables["0.1"][2] > tables["1"][2]


def test_a_policy_can_be_tested_by_its_mean_action(tmp_path):
    options = ["--run", str(SHIPPED / "point2d-optimal-meta-bc-seed1"), "--tasks", "4"]
    tables = {}
    for way in ((), ("--by-mean",)):
        out = tmp_path / "".join(way) / "unseen.csv"
        main(["evaluate", *options, "--steps", "1", *way, "--out", str(out)])
        tables[way] = returns_by_step(out.parent)
    assert tables["--by-mean",][1] > tables[()][1] + 10  # its sigma is 1


def help_of(*command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([*command, "--help"])
    assert stop.value.code == 0
    return capsys.readouterr().out


def test_help_explains_every_command(capsys):
    text = help_of(capsys=capsys)
    assert all(command in text for command in ("demos", "train", "evaluate", "bench"))


def test_help_lists_the_choices_of_an_option(capsys):
    help_text = help_of("train", capsys=capsys).replace("│", "")  # without the box around it
    text = "".join(help_text.split())
    for choices in (ALGORITHMS, ENVIRONMENTS, ("biased", "xavier"), ("mean", "sum")):
        assert "{" + ",".join(choices) + "}" in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["train", "--env", "poimt2d", "--out", "X"], "Expected one of ('point2d', 'two_wheeled'"),
        (["train", "--algorithm", "mamml", "--out", "X"], "Expected one of ('emrld', 'emrld-ws'"),
        (["train", "--demos", "optimaal", "--out", "X"], "Did you mean 'optimal'"),
        (["train", "--demos", "none.npz", "--out", "X"], "no such demonstration file"),
        (["train", "--iterations", "0", "--out", "X"], "iterations"),
        (["train", "--threads", "0", "--out", "X"], "threads"),
        (["train", "--device", "gpu", "--out", "X"], "Expected one of ('cpu', 'cuda')"),
        (["train", "--resume", "--out", "X"], "nothing to resume"),
        (["evaluate", "--run", "X", "--out", "t.csv"], "no such run configuration"),
        (["evaluate", "--run", "X", "--out", "t.txt"], "ending in .csv"),
        (
            ["demos", "--env", "point2d", "--quality", "good", "--out", "d.npz"],
            "Expected one of ('opt",
        ),
        (["demos", "--env", "point2d", "--quality", "optimal", "--out", "d"], "ending in .npz"),
        ([*OPTIMAL, "--out", "d.npz", "--noise", "-1"], "noise"),
        ([*OPTIMAL, "--out", "d.npz", "--tasks", "3", "--expert-out", "e"], "train no expert"),
        ([*OPTIMAL, "--out", "d.npz", "--stop-at-success", "2"], "stop_at_success"),
        (
            [*OPTIMAL, "--out", "d.npz", "--tasks", "3", "--stop-at-success", "0.5"],
            "train no expert",
        ),
        ([*OPTIMAL, "--out", "d.npz", "--paths", "0"], "paths: expected a whole number"),
        ([*OPTIMAL, "--out", "d.npz", "--largest-drift", "0.3"], "unknown option of point2d"),
        ([*OPTIMAL, "--out", "d.npz", "--cut", "1"], "cut: expected 2 sizes"),
        ([*OPTIMAL, "--out", "d.npz", "--cut", "0.5", "1"], "cut: expected sizes of 1 or more"),
        (["train", "--algorithm", "gmps", "--meta-lr", "0", "--out", "X"], "meta_lr"),
        (["train", "--reward", "densse", "--out", "X"], "Expected one of ('sparse', 'dense')"),
        (["bench", "--iterations", "-1"], "iterations"),
        (["bench", "--tasks", "-5"], "tasks: expected a whole number of at least 1"),
        (["bench", "--tasks"], "tasks: expected at least one number"),
        (["train", "--threads", "100000", "--out", "X"], "threads (this machine has"),
        (
            ["train", "--seed", "18446744073709551616", "--out", "X"],
            "seed: expected a whole number",
        ),
        (["train", "--out", ""], "out: expected the name of a folder"),
        (["train", "--out", "/dev/null"], "out: cannot write /dev/null"),
        (["train", "--out", "X", "--episodes", "100000"], "memory"),
        (["train", "--out", "X", "--fisher-samples", "1000000000"], "Fisher samples: needs about"),
        (["train", "--out", "X", "--cg-iterations", "1000000"], "cg_iterations"),
        ([*OPTIMAL, "--out", "d.npz", "--tasks", "100000000"], "needs about"),
        ([*OPTIMAL, "--out", "/dev/null/d.npz"], "out: cannot write"),
        (["evaluate", "--run", STORED, "--out", "t.csv", "--tasks", "1000000000"], "needs about"),
        (["evaluate", "--run", STORED, "--out", "t.csv", "--steps", "1000000000"], "needs about"),
        (["evaluate", "--run", STORED, "--out", "t.csv", "--seed", "99999999999999999999"], "seed"),
        (["figures", "--out", "F", "--runs-folder", "none"], "none: expected a folder of runs"),
        (["sweep", "grid.toml"], "--out"),
        (["sweep", "grid.toml", "--out", "S"], "no such grid"),
    ],
)
def test_bad_input_exits_with_2_and_says_why(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    out, error = capsys.readouterr()
    assert words in error
    assert len(error.splitlines()) == 1 and not out, "one line"
    assert not list(tmp_path.iterdir()), "a refused command leaves nothing behind"


def test_figures_of_a_damaged_table_are_refused_and_nothing_is_drawn(tmp_path, capsys):
    name = "point2d-optimal-emrld-seed0"
    shutil.copytree(SHIPPED / name, tmp_path / "runs" / name)
    table = tmp_path / "runs" / name / "unseen.csv"
    table.write_bytes(table.read_bytes()[:-200])
    with pytest.raises(SystemExit):
        main(["figures", "--out", str(tmp_path / "out"), "--runs-folder", str(tmp_path / "runs")])
    assert "unseen.csv" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()

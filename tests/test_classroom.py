"""Every exercise: its check passes the notebook's solution, rejects the mutants and the blank."""

import functools
import importlib.util
import inspect
import itertools
import math
import re
from pathlib import Path

import jupytext
import numpy as np
import pytest
import torch

from emrld_lite.classroom import checks
from emrld_lite.classroom.clock import Clock
from emrld_lite.validation import InputError

ROOT = Path(__file__).resolve().parent.parent
MUTANTS = sorted((ROOT / "tests/mutants").glob("*.py"))


@functools.cache
def exercises(folder="notebooks", suffix=".py"):
    """Return check name -> source of the cell before ``check.<name>(...)``, over all notebooks."""
    found = {}
    for path in sorted((ROOT / folder).glob(f"[0-9]*{suffix}")):
        cells = [cell for cell in jupytext.read(path).cells if cell.cell_type == "code"]
        for before, cell in itertools.pairwise(cells):
            match = re.search(r"check\.(\w+)\((\w+)\)", cell.source)
            if match:
                found[match[1]] = (before.source, match[2])
    return found


def student_function(source, name):
    """Return the function a cell defines."""
    scope = {"torch": torch, "math": math, "np": np}
    exec(source, scope)
    return scope[name]


def module(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def mutants(path):
    """Return the public functions of a mutant file."""
    functions = inspect.getmembers(module(path), inspect.isfunction)
    return [function for name, function in functions if not name.startswith("_")]


ALL_MUTANTS = [
    pytest.param(path.stem, function, id=f"{path.stem}-{function.__name__}")
    for path in MUTANTS
    for function in mutants(path)
]


def test_every_exercise_has_a_check_and_three_mutants():
    names = set(exercises())
    assert names == {path.stem for path in MUTANTS}
    assert all(len(mutants(path)) >= 3 for path in MUTANTS)


@pytest.mark.parametrize("name", sorted(exercises()))
def test_the_solution_passes(name, capsys):
    assert getattr(checks, name)(student_function(*exercises()[name]))
    assert capsys.readouterr().out.startswith("Correct")


@pytest.mark.parametrize(("name", "function"), ALL_MUTANTS)
def test_a_wrong_answer_is_named(name, function, capsys):
    assert not getattr(checks, name)(function)
    shown = capsys.readouterr().out
    assert shown.startswith("Not yet: ")
    assert function.__doc__ in shown


@pytest.mark.parametrize("name", sorted(exercises()))
def test_the_blank_is_rejected(name, capsys):
    blank = exercises("notebooks/lab", ".ipynb")[name]
    assert "BEGIN SOLUTION" not in blank[0]
    assert not getattr(checks, name)(student_function(*blank))
    assert "still blank" in capsys.readouterr().out


def test_checks_answer_in_one_sentence_whatever_comes(capsys):
    for name in exercises():
        assert not getattr(checks, name)(lambda *anything: "banana")
        assert capsys.readouterr().out.count("\n") == 1


def test_the_clock_adds_up(capsys):
    clock = Clock({"one": 10, "two": 5})
    clock.at("two")
    assert "about 15 minutes" in (shown := capsys.readouterr().out)
    assert "10 of 15 min behind you" in shown
    with pytest.raises(InputError, match="section"):
        clock.at("three")

"""Every exercise: its check passes the notebook's solution, rejects the mutants and the blank."""

import functools
import importlib.util
import inspect
import itertools
import math
import os
import re
import threading
import time
from fractions import Fraction
from pathlib import Path

import jupytext
import numpy as np
import pytest
import torch

from emrld_lite.adapt import adapt, warm_start
from emrld_lite.classroom import checks
from emrld_lite.classroom.checks import answers, patience
from emrld_lite.classroom.clock import Clock
from emrld_lite.classroom.predict import Guesses
from emrld_lite.validation import InputError

from . import exercises as asked
from . import random_answers

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
    scope = {"torch": torch, "math": math, "np": np, "combinations": itertools.combinations}
    scope |= {"adapt": adapt, "warm_start": warm_start}
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


RIGHT = [
    pytest.param(name.partition("__")[0], function, id=name)
    for name, function in asked.RIGHT_ANSWERS
]
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


def test_every_exercise_has_right_answers_of_other_styles():
    assert {case.values[0] for case in RIGHT} == set(exercises())


@pytest.mark.parametrize(("name", "function"), RIGHT)
def test_a_right_answer_of_another_style_or_type_passes(name, function, capsys):
    assert getattr(checks, name)(function), capsys.readouterr().out


def test_nearly_all_random_wrong_answers_are_caught(capsys):
    """Where an exercise has many right answers, mutants alone test its check."""
    count = int(os.environ.get("EMRLD_RANDOM_ANSWERS", "8"))  # for each exercise
    assert set(asked.QUESTIONS) == set(exercises()) - asked.MANY_ANSWERS
    wrong, passed, refused = 0, [], []
    for name in sorted(asked.QUESTIONS):
        source, called = exercises()[name]
        solution = student_function(source, called)
        for text in random_answers.changed(source, called, count, seed=1):
            function = student_function(text, called)
            right = asked.same(asked.QUESTIONS[name], function, solution)
            accepted = getattr(checks, name)(function)
            wrong += not right
            if accepted and not right:
                passed.append(text)
            if right and not accepted:
                refused.append(text)
    with capsys.disabled():
        print(f"[{wrong - len(passed)} of {wrong} random wrong answers caught]", end=" ")
    assert len(passed) <= 0.02 * wrong, "\n\n".join(passed)
    assert not refused, "\n\n".join(refused)


def test_agreement_looks_at_numbers_and_not_at_types():
    numbers = torch.tensor([1.0, 2.5])
    for same in (numbers.double(), numbers.numpy(), [1, 2.5], (np.float32(1), Fraction(5, 2))):
        assert checks.agree(same, numbers)
    for other in ([1.0, 2.6], [1.0], None, "banana", [1.0, math.nan], 1j):
        assert not checks.agree(other, numbers)


def loops_for_ever(*anything):
    while True:
        try:
            anything = anything[:]
        except Exception:
            continue


def ends_the_program(*anything):
    raise SystemExit


def fails_in_torch(*anything):
    raise NotImplementedError("not implemented for 'Half'")


def test_an_answer_that_does_not_end_is_told(monkeypatch, capsys):
    monkeypatch.setattr(answers, "PATIENCE", 0.2)
    assert not checks.surrogate(loops_for_ever)
    assert "had not ended" in capsys.readouterr().out
    verdicts = []
    other = threading.Thread(target=lambda: verdicts.append(checks.surrogate(loops_for_ever)))
    other.start()
    other.join(60)
    assert verdicts == [False]
    assert "had not ended" in capsys.readouterr().out


def test_waiting_for_others_costs_no_time_but_waiting_for_ever_does(monkeypatch):
    with patience.limited(0.2):
        time.sleep(0.5)  # as long as another program has the processor
    monkeypatch.setattr(patience, "WAITING", 2.0)
    with pytest.raises(patience.TimeUp), patience.limited(0.2):
        time.sleep(30)


def test_a_time_limit_leaves_the_timer_of_others_running():
    before = patience.signal.setitimer(patience.signal.ITIMER_REAL, 1000)
    try:
        with patience.limited(5):
            time.sleep(0.01)
        assert 900 < patience.signal.getitimer(patience.signal.ITIMER_REAL)[0] < 1000
    finally:
        patience.signal.setitimer(patience.signal.ITIMER_REAL, *before)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (ends_the_program, "ends the whole program"),
        (fails_in_torch, "stopped with NotImplementedError"),
        (3.0, "without brackets"),
        (lambda *anything: 1j, "complex"),
        (lambda *anything: math.nan, "not finite"),
        (lambda: 1.0, "stopped with TypeError"),
    ],
)
def test_an_answer_that_is_no_number_is_told(answer, words, capsys):
    assert not checks.surrogate(answer)
    assert words in capsys.readouterr().out


def test_the_clock_adds_up(capsys):
    clock = Clock({"one": 10, "two": 5})
    clock.at("two")
    assert "planned for 15 minutes" in (shown := capsys.readouterr().out)
    assert "10 of 15 min behind you" in shown
    with pytest.raises(InputError, match="section"):
        clock.at("three")


def test_further_reading_is_not_counted_into_the_sitting(capsys):
    clock = Clock({"one": 10, "two": 5}, further={"three": 20})
    assert "further reading: 1 sections, planned for 20 minutes" in capsys.readouterr().out
    clock.at("three")
    assert capsys.readouterr().out == "three: 20 min of further reading\n"


def test_a_guess_is_kept_and_shown_beside_the_answer(capsys):
    guess = Guesses()
    guess.ask("share", "share of the actions that is altered, %")
    guess.boxes["share"].entry.value = " about a third "
    guess.ask("second", "who comes second?", ["MAML", "GMPS"])
    capsys.readouterr()
    guess.reveal("share", "61 %")
    assert capsys.readouterr().out == "You guessed: about a third\nIt is:       61 %\n"
    guess.reveal("second", "MAML")
    assert "(nothing yet)" in capsys.readouterr().out


def test_a_guess_survives_a_second_run_of_its_cell():
    guess = Guesses()
    guess.ask("second", "who comes second?", ["MAML", "GMPS"])
    guess.boxes["second"].entry.value = "GMPS"
    guess.ask("second", "who comes second?", ["MAML", "GMPS"])
    assert guess.of("second") == "GMPS"
    guess.ask("second", "who comes second?", ["MAML", "Meta-BC"])  # the guess is no choice any more
    assert guess.of("second") is None


def test_a_question_that_was_never_asked_has_no_answer():
    with pytest.raises(InputError, match="guess: expected one of"):
        Guesses().reveal("share", "61 %")

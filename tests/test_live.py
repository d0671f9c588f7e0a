"""A live training gives way to a stored run where it would take too long, and a class can be measured."""

import itertools
import os

import pytest

from emrld_lite.classroom import crowd, live
from emrld_lite.experiments import runs
from emrld_lite.train import Iterate
from emrld_lite.validation import InputError

STORED = sorted(runs.SHIPPED.glob("point2d-optimal-emrld-ws-seed0"))[0]


def training(count):
    """Return the iterates of a training that ends after so many iterations."""
    curve = runs.load_run(STORED).curve
    for record in curve[:count]:
        yield Iterate({}, record, None, None, {})


def ticking(seconds):
    """Return a clock that moves on by so many seconds at each look."""
    ticks = itertools.count()
    return lambda: seconds * next(ticks)


def test_a_quick_machine_trains_to_the_end(capsys):
    seen = list(live.while_it_is_quick(training(12), STORED, 40, 8.0, ticking(1.5)))
    assert [row.record.iteration for row in seen] == list(range(12))
    assert all(row.meta_params == {} for row in seen)
    assert capsys.readouterr().out == ""


def test_a_busy_machine_shows_the_stored_rest_and_says_so(capsys):
    seen = list(live.while_it_is_quick(training(12), STORED, 40, 8.0, ticking(30.0)))
    run = runs.load_run(STORED)
    assert [row.record.iteration for row in seen] == list(range(len(run.curve)))
    assert [row.meta_params == {} for row in seen[: live.FEW + 1]] == [True] * 3 + [False]
    assert seen[-1].meta_params.keys() == run.meta_params.keys()
    said = capsys.readouterr().out
    assert "an iteration takes 30 s, so about 18 minutes are left" in said
    assert STORED.name in said


def test_one_slow_iteration_does_not_end_the_training():
    looks = iter([0.0, 60.0, *(60.0 + step for step in range(1, 20))])
    seen = list(live.while_it_is_quick(training(12), STORED, 40, 8.0, lambda: next(looks)))
    assert len(seen) == 12


def test_an_endless_patience_is_refused():
    with pytest.raises(InputError, match="minutes"):
        next(live.while_it_is_quick(training(3), STORED, 40, float("nan")))


def test_two_students_are_measured_and_told():
    waits = crowd.measure(2, iterations=1)
    assert len(waits.imports) == len(waits.iteration) == 2
    assert min(*waits.imports, *waits.iteration) > 0
    if os.path.exists("/proc/self/smaps_rollup"):
        assert 50 < min(waits.at_rest) <= max(waits.at_rest) < 3000
    assert crowd.report(2, waits).startswith("2 students: imports")


def test_a_kernel_that_stops_is_told():
    with pytest.MonkeyPatch.context() as patch, pytest.raises(InputError, match="no such thing"):
        patch.setattr(crowd, "IMPORTS", "raise RuntimeError('no such thing')")
        crowd.measure(1)

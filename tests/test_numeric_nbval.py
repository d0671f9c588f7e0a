"""Notebook outputs are compared as numbers, and what is more than rounding is caught."""

import importlib.util
import re
from decimal import Decimal

import nbformat
import pytest

from .numeric_nbval import Tolerance, differences, tolerance_of

SAME = [  # committed, new, tags
    ("share 0.37 of all", "share 0.38 of all", []),
    ("share 0.37 of all", "share 0.36 of all", []),
    ("24 of 24 tasks", "24 of 24 tasks", []),
    ("[  9.9,  10.0]", "[ 10.0,   9.9]", []),  # the padding follows the number
    ("+0.0", "-0.1", []),
    ("length 3.5e-04", "length 3.6e-04", []),
    ("nan, inf, -inf", "nan, inf, -inf", []),
    ("1,234.5", "1,234.6", []),
    ("weight_0 (100, 2)", "weight_0 (100, 2)", []),
    ("return 70.0", "return 73.0", ["tolerance:0.05"]),
    ("gap 0.01", "gap 0.05", ["tolerance:abs=0.04"]),
    ("return 20.0", "return 39.9", ["statistical", "tolerance:0.5", "tolerance:abs=10"]),
    ("70 after 55 iterations", "70 after 61 iterations", ["tolerance:whole=10"]),
]
CAUGHT = [
    ("share 0.37 of all", "share 0.37 of none", []),
    ("share 0.37", "share 0.39", []),
    ("share 0.37", "share -0.37", []),
    ("at -0.01", "at 0.01", []),
    ("0.37 and 0.41", "0.37 and", []),
    ("0.37", "0.37 0.41", []),
    ("0.37 0.41", "0.370.41", []),
    ("23 of 24 tasks", "22 of 24 tasks", []),
    ("ends at 70.", "ends at 71.", []),
    ("1e-5", "2e-5", []),
    ("length 0.0e+00", "length 1.0e-03", []),
    ("10,000 families", "10,001 families", []),
    ("0.37", "nan", ["tolerance:abs=10"]),
    ("nan", "0.37", ["tolerance:abs=10"]),
    ("inf", "-inf", ["tolerance:abs=10"]),
    ("weight_0", "weight_1", ["tolerance:whole=5"]),
    ("Point2D", "Point3D", ["tolerance:whole=5"]),
    ("return 70.0", "return 74.0", ["tolerance:0.05"]),
    ("return 70.0", "return -70.0", ["tolerance:0.5", "tolerance:abs=10"]),
    ("return 20.0", "return 40.1", ["statistical", "tolerance:0.5", "tolerance:abs=10"]),
    ("12 goals", "13 goals", ["tolerance:0.5", "tolerance:abs=10"]),  # counts stay exact
    ("0.37\n0.41", "0.37 0.41", []),
]


@pytest.mark.parametrize(("reference", "test", "tags"), SAME)
def test_what_rounding_moves_passes(reference, test, tags):
    assert differences(reference, test, tolerance_of(tags)) == []


@pytest.mark.parametrize(("reference", "test", "tags"), CAUGHT)
def test_what_is_more_than_rounding_is_caught(reference, test, tags):
    assert differences(reference, test, tolerance_of(tags))


def test_a_difference_is_told_in_a_sentence():
    told = differences("return 70.0", "return 99.0", tolerance_of(["tolerance:abs=3"]))
    assert told == ["70.0 became 99.0, by more than 3"]
    assert differences("up 1.0", "down 1.0") == ["'up' became 'down'"]
    assert differences("1 2", "1") == ["2 numbers became 1"]


def test_tags_say_how_far():
    assert tolerance_of([]) == tolerance_of(["exercise-1"]) == Tolerance()
    assert tolerance_of(["figure", "tolerance:0.05"]) == Tolerance(relative=Decimal("0.05"))
    stated = tolerance_of(
        ["statistical", "tolerance:rel=0.5", "tolerance:abs=10", "tolerance:whole=3"]
    )
    assert stated == (Decimal("0.5"), Decimal(10), Decimal(3))


@pytest.mark.parametrize(
    "tags",
    [
        ["statistical"],
        ["tolerance"],
        ["tolerance:"],
        ["tolerance:much"],
        ["tolerance:rel=-1"],
        ["tolerance:rel=nan"],
        ["tolerance:abs=1;rel=2"],
        ["tolerance:0.1", "tolerance:rel=0.2"],
        ["tolerance:0.1", "tolerance:0.2"],
    ],
)
def test_a_tag_that_says_nothing_clear_is_refused(tags):
    with pytest.raises(ValueError, match="tolerance"):
        tolerance_of(tags)


CELLS = {  # what a cell prints, what its committed output says, its tags, and whether it passes
    "the same": ("print('return 0.37')", "return 0.37\n", [], True),
    "the last digit": ("print('return 0.37')", "return 0.38\n", [], True),
    "a word": ("print('return 0.37')", "reward 0.37\n", [], False),
    "a number": ("print('return 0.37')", "return 0.47\n", [], False),
    "a sign": ("print('return 0.37')", "return -0.37\n", [], False),
    "one missing": ("print('return 0.37')", "return 0.37 0.41\n", [], False),
    "one more": ("print('return 0.37 0.41')", "return 0.37\n", [], False),
    "nothing": ("pass", "return 0.37\n", [], False),
    "tolerated": ("print('return 70.0')", "return 73.0\n", ["tolerance:0.05"], True),
    "intolerable": ("print('return 70.0')", "return 75.0\n", ["tolerance:0.05"], False),
    "live": ("print('at 60.0')", "at 75.0\n", ["statistical", "tolerance:rel=0.2"], True),
    "no tolerance": ("print('at 60.0')", "at 60.0\n", ["statistical"], False),
    "a duration": ("print('0.5 in 3 s')", "0.5 in 9 s\n", [], True),
    "ignored": ("print('return 0.37')", "nothing\n", ["nbval-ignore-output"], True),
}
VALUES = {
    "value": ("0.5", {"text/plain": "0.6"}, True),
    "another value": ("0.5", {"text/plain": "0.7"}, False),
    "page": (
        "from IPython.display import HTML; HTML('0.5')",
        {"text/plain": "<IPython.core.display.HTML object>", "text/html": "0.6"},
        False,
    ),
}


def tiny_notebook():
    """Return a notebook of the cells above, executed once, as far as its outputs say."""
    cells = []
    for source, printed, tags, _ in CELLS.values():
        output = nbformat.v4.new_output("stream", name="stdout", text=printed)
        cells.append((source, output, tags))
    for source, data, _ in VALUES.values():
        output = nbformat.v4.new_output("execute_result", data=data, execution_count=1)
        cells.append((source, output, []))
    return nbformat.v4.new_notebook(
        cells=[
            nbformat.v4.new_code_cell(
                source, outputs=[output], execution_count=1, metadata={"tags": tags}
            )
            for source, output, tags in cells
        ]
    )


@pytest.mark.parametrize("processes", [1, 2])
def test_nbval_compares_numbers(pytester, request, processes):
    if processes > 1 and not importlib.util.find_spec("xdist"):
        pytest.skip("pytest-xdist is not installed")
    nbformat.write(tiny_notebook(), pytester.path / "tiny.ipynb")
    sanitise = request.config.rootpath / "tests" / "nbval_sanitize.cfg"
    pytester.makeconftest('pytest_plugins = ["tests.numeric_nbval"]')
    result = pytester.runpytest(
        "--nbval",
        f"--nbval-sanitize-with={sanitise}",
        "--nbval-current-env",
        "tiny.ipynb",
        *(["-n", str(processes), "--dist", "loadfile"] if processes > 1 else []),
    )
    expected = [passes for *_, passes in [*CELLS.values(), *VALUES.values()]]
    told = "\n".join(result.outlines)
    failed = {int(number) for number in re.findall(r"FAILED tiny.ipynb::Cell (\d+)", told)}
    assert failed == {number for number, passes in enumerate(expected) if not passes}, told
    result.assert_outcomes(passed=sum(expected), failed=len(failed))
    assert "75.0 became 70.0, by more than 3.75" in told


@pytest.mark.parametrize(
    ("folder", "asked", "capability"),
    [(".", [], "default"), ("lab", [], None), (".", ["--lot", "own"], None)],
)
def test_a_complete_notebook_is_run_as_on_another_machine(pytester, folder, asked, capability):
    cell = nbformat.v4.new_code_cell(
        'import os; assert os.environ.get("ATEN_CPU_CAPABILITY") == ' + repr(capability)
    )
    (pytester.path / folder).mkdir(exist_ok=True)
    path = pytester.path / folder / "tiny.ipynb"
    nbformat.write(nbformat.v4.new_notebook(cells=[cell]), path)
    pytester.makeconftest('pytest_plugins = ["tests.numeric_nbval"]')
    result = pytester.runpytest("--nbval", "--nbval-current-env", *asked, str(path))
    result.assert_outcomes(passed=1)

"""The package's shape: data flow one way, rooms keep apart, and imports stay light."""

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import emrld_lite
from emrld_lite import experiments

PACKAGE = Path(emrld_lite.__file__).parent
ORDER = re.findall(
    r"\w+", emrld_lite.__doc__.partition("::")[2].partition("\n\n    ")[2].partition("\n\n")[0]
)
ROOMS = ("demonstrators", "robot", "experiments", "tabular", "classroom")
FILES = sorted(PACKAGE.rglob("*.py"))


def imported(path):
    """Return the package's modules that a file imports, as dotted names below the package."""
    home = ("emrld_lite", *path.relative_to(PACKAGE).with_suffix("").parts)[:-1]
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        if isinstance(node, ast.ImportFrom):
            base = home[: len(home) - node.level + 1] if node.level else ()
            source = ".".join((*base, *filter(None, [node.module])))
            found |= {f"{source}.{alias.name}" for alias in node.names}
    return {name.removeprefix("emrld_lite.") for name in found if name.startswith("emrld_lite.")}


def first_parts(path):
    return {name.partition(".")[0] for name in imported(path)}


def test_the_reading_order_names_every_module():
    here = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or path.is_dir()}
    beside = {"__init__", "__main__", "__pycache__"}
    assert set(ORDER) == here - beside - set(ROOMS)
    assert len(ORDER) == len(set(ORDER))


@pytest.mark.parametrize("module", ORDER)
def test_a_module_imports_only_what_stands_before_it(module):
    folder = PACKAGE / module
    for path in sorted(folder.glob("*.py")) if folder.is_dir() else [PACKAGE / f"{module}.py"]:
        later = first_parts(path) & {*ORDER[ORDER.index(module) + 1 :], *ROOMS}
        assert not later, f"{path.name} imports {sorted(later)}"


@pytest.mark.parametrize(
    ("room", "closed"),
    [
        ("demonstrators", {"experiments", "tabular", "classroom"}),
        ("robot", {"demonstrators", "experiments", "tabular", "classroom"}),
        ("experiments", {"tabular", "classroom"}),
        ("tabular", {"experiments", "demonstrators", "classroom"}),
    ],
)
def test_a_room_does_not_look_into_those_behind_it(room, closed):
    for path in (PACKAGE / room).rglob("*.py"):
        assert not first_parts(path) & closed, path


def test_the_experiments_read_in_one_order():
    """Every module of the room is in it, and imports only what stands before it."""
    room = PACKAGE / "experiments"
    order = re.findall(r"\w+", experiments.__doc__.partition("in the order")[2])
    places = {path.relative_to(room).parts[0].removesuffix(".py") for path in room.rglob("*.py")}
    assert sorted(order) == sorted(places - {"__init__"})
    for path in room.rglob("*.py"):
        place = path.relative_to(room).parts[0].removesuffix(".py")
        later = order[order.index(place) + 1 :] if place in order else order
        wrong = {name.split(".")[1] for name in imported(path) if name.startswith("experiments.")}
        wrong &= set(later)
        assert not wrong, f"{path.name} imports {sorted(wrong)}"


def test_nothing_imports_notebooks_or_tests():
    for path in FILES:
        assert not re.search(r"^\s*(from|import) (notebooks|tests)\b", path.read_text(), re.M), path


LIGHT = ("", ".losses", ".train", ".experiments.runs", ".experiments.commands")
HEAVY = {"mujoco", "matplotlib", "distributed", "rospy"}


@pytest.fixture(scope="module")
def loaded():
    """Return what each module of LIGHT loads beyond those before it, in one fresh interpreter."""
    code = "import importlib, json, sys\nseen, found = set(), {}\n" + "".join(
        f"importlib.import_module('emrld_lite{name}')\n"
        f"found[{name!r}] = sorted({{*sys.modules}} - seen)\nseen = {{*sys.modules}}\n"
        for name in LIGHT
    )
    done = subprocess.run(
        [sys.executable, "-c", code + "print(json.dumps(found))"],
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", LIGHT)
def test_an_import_loads_no_more_than_it_needs(name, loaded):
    absent = HEAVY if name else {"torch", *HEAVY}
    assert not set(loaded[name]) & absent


def test_importing_the_package_registers_its_environments():
    code = "import emrld_lite, gymnasium; print(gymnasium.make('emrld_lite/Point2D-v0').reset()[0])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stdout.strip() == "[0. 0.]", done.stderr

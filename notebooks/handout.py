"""Build the class folder: an nbgrader course from the same sources as the notebooks.

    python notebooks/handout.py                          every notebook, into build/class
    python notebooks/handout.py 01 03 --out elsewhere    these, there
    python notebooks/handout.py --private-tests DIR      with tests that students do not see

The folder gets ``nbgrader_config.py``, for each notebook an assignment ``source/NN_name`` with the
solutions, and ``release/NN_name``, what students get. Built again, it keeps what was handed in and
the gradebook. Each exercise is a cell with a ``### BEGIN SOLUTION`` before one with
``check.<exercise>(<function>)``; behind the two stands a grade cell, worth as many points as the
exercise's difficulty. All other cells are given, and grading puts them back as they were.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import nbformat
from nbgrader.apps import NbGraderAPI
from traitlets.config import Config, PyFileConfigLoader

from build import HERE, SOLUTION, blank, read, sources, text, write

SETTINGS = "nbgrader_config.py"
CHECK = re.compile(r"\bcheck\.(\w+)\((\w+)\)")
DIFFICULTY = re.compile(r"Difficulty (\d+) of \d+")
HANDING_IN = """**This copy is graded.** Under each exercise stands a grade cell. It says how many points the
exercise is worth, and stops with a sentence as long as the answer is not right. Answer in the
exercise's own cell, under the function's own name, and put what else your answer needs into that cell
or into cells that you add. Play with all other cells as you like: they are put back before grading."""
GRADE = """# Grade: {points} {unit}. This cell stops with a sentence as long as the answer is not right.
from emrld_lite.classroom import checks

checks.require(checks.{name}, {function})"""
HIDDEN = "\n### BEGIN HIDDEN TESTS\n{tests}\n### END HIDDEN TESTS"


class Exercise(NamedTuple):
    """What a notebook says about one of its exercises."""

    name: str  # its check's
    function: str
    points: int
    solution: int  # position of its cell
    check: int


def exercises(notebook: nbformat.NotebookNode) -> list[Exercise]:
    """Return the notebook's exercises in order: each a solution whose next code cell checks it."""
    code = [number for number, cell in enumerate(notebook.cells) if cell.cell_type == "code"]
    found = []
    for here, following in pairwise(code):
        match = CHECK.search(notebook.cells[following].source)
        if match and SOLUTION.search(notebook.cells[here].source):
            name, function = match.groups()
            found.append(Exercise(name, function, points(notebook, here, name), here, following))
    twice = [name for name, count in Counter(one.name for one in found).items() if count > 1]
    if twice:
        sys.exit(f"expected one cell for each exercise, found more for {', '.join(twice)}")
    return found


def points(notebook: nbformat.NotebookNode, position: int, name: str) -> int:
    """Return the difficulty that the text between the exercise before and this one states last."""
    for cell in reversed(notebook.cells[:position]):
        if SOLUTION.search(cell.source):
            break
        if match := DIFFICULTY.search(cell.source):
            return int(match[1])
    sys.exit(f"{name}: expected 'Difficulty n of 3' in the text before the exercise, found none")


def marks(kind: str, identity: str, points: int | None = None) -> nbformat.NotebookNode:
    """Return nbgrader's metadata of an ``answer``, a ``grade`` or a ``given`` cell."""
    found = {
        "schema_version": 3,
        "grade_id": f"{kind}-{identity}",
        "grade": kind == "grade",
        "solution": kind == "answer",
        "locked": kind != "answer",
        "task": False,
    }
    return nbformat.from_dict(found if points is None else {**found, "points": points})


def grade_cell(exercise: Exercise, hidden: str | None) -> nbformat.NotebookNode:
    """Return the cell that gives an exercise's points; *Run all* goes on past it where it stops."""
    unit = "point" if exercise.points == 1 else "points"
    source = GRADE.format(unit=unit, **exercise._asdict())
    if hidden is not None:
        source += HIDDEN.format(tests=hidden.strip("\n"))
    cell = nbformat.v4.new_code_cell(source, id=f"grade-{exercise.check:03d}")
    cell.metadata["tags"] = ["raises-exception"]
    cell.metadata["nbgrader"] = marks("grade", exercise.name, exercise.points)
    return cell


def handout(
    notebook: nbformat.NotebookNode, hidden: Mapping[str, str] | None = None
) -> nbformat.NotebookNode:
    """Return nbgrader's source version of a notebook; ``hidden`` has tests by exercise."""
    graded = exercises(notebook)
    answers = {notebook.cells[one.solution].id: one.name for one in graded}
    grades = {
        notebook.cells[one.check].id: grade_cell(one, (hidden or {}).get(one.name))
        for one in graded
    }
    solved = {cell.id: cell for cell in notebook.cells}
    student = blank(notebook)  # folds what students should not see at once; solutions stay here
    cells = []
    for cell in student.cells:
        original = solved.get(cell.id, cell)
        if original.cell_type == "code" and SOLUTION.search(original.source):
            cell.source = original.source
            cell.metadata["nbgrader"] = marks("answer", answers.get(cell.id, cell.id))
        elif cell.cell_type == "code":
            cell.metadata["nbgrader"] = marks("given", cell.id)
            cell.metadata["deletable"] = False
        cells += [cell, *([grades[cell.id]] if cell.id in grades else [])]
    student.cells = [
        *cells[:1],
        nbformat.v4.new_markdown_cell(HANDING_IN, id="handing-in"),
        *cells[1:],
    ]
    return student


def private_tests(folder: Path | None, notebooks: list[nbformat.NotebookNode]) -> dict[str, str]:
    """Return the hidden tests in ``folder/<exercise>.py`` by exercise."""
    if folder is None:
        return {}
    known = {one.name for notebook in notebooks for one in exercises(notebook)}
    found = {path.stem: path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.py"))}
    if not found:
        sys.exit(f"expected <exercise>.py in {folder}, found none")
    if strange := sorted(set(found) - known):
        sys.exit(
            f"expected tests named after exercises ({', '.join(sorted(known))}), "
            f"got {', '.join(strange)}"
        )
    return found


def settings(out: Path) -> Config:
    """Return the settings of a course folder, which it gets now if it has none."""
    path = out / SETTINGS
    if not path.exists():
        write(path, (HERE / "grading_config.py").read_text(encoding="utf-8"))
    return PyFileConfigLoader(SETTINGS, path=str(out.resolve())).load_config()


def build_class(
    notebooks: Mapping[str, nbformat.NotebookNode], out: Path, hidden: Mapping[str, str]
) -> NbGraderAPI:
    """Write an assignment for each notebook, its release and its row in the gradebook."""
    api = NbGraderAPI(config=settings(out))
    for name, notebook in notebooks.items():
        folder = out / "source" / name
        if folder.exists():
            shutil.rmtree(folder)
        write(folder / f"{name}.ipynb", text(handout(notebook, hidden)))
        result = api.generate_assignment(name)
        if not result["success"]:
            sys.exit(f"{name} was not released\n{result.get('log') or result['error']}")
        count = exercises(notebook)
        print(f"{name}: {len(count)} exercises, {sum(one.points for one in count)} points")
    return api


def main() -> None:
    """Read the command line and build the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="numbers or names of notebooks; default: all")
    parser.add_argument("--out", type=Path, default=Path("build/class"), help="the class folder")
    parser.add_argument("--private-tests", type=Path, help="folder of <exercise>.py, hidden tests")
    options = parser.parse_args()
    notebooks = {source.stem: read(source) for source in sources(options.names)}
    hidden = private_tests(options.private_tests, list(notebooks.values()))
    build_class(notebooks, options.out, hidden)
    print(f"{options.out}: source has the solutions, release is for the students")


if __name__ == "__main__":
    main()

"""Try the grading: hand in a blank, a half-right and a full copy of each notebook, and compare marks.

    python notebooks/autograde.py                 every notebook, in build/autograde
    python notebooks/autograde.py 01 03           these
    python notebooks/autograde.py --private-tests DIR    with your hidden tests

The half-right copy has the solutions of the first half of its exercises and wrong answers to the
others, those that ``tests/mutants`` has for the public checks. The folder is made anew each time.
"""

from __future__ import annotations

import argparse
import ast
import copy
import shutil
import sys
import time
import warnings
from collections.abc import Mapping
from pathlib import Path

import nbformat
from nbgrader.api import Gradebook
from nbgrader.apps import NbGraderAPI
from sqlalchemy.exc import SAWarning

from build import HERE, read, sources, text, write
from handout import SETTINGS, build_class, exercises, private_tests

MUTANTS = HERE.parent / "tests" / "mutants"
STUDENTS = ("blank", "half", "full")
Answers = dict[str, str]  # source of an exercise's cell by exercise
Marks = dict[str, float]  # points by exercise


def solutions(notebook: nbformat.NotebookNode) -> Answers:
    """Return the right answers."""
    return {one.name: notebook.cells[one.solution].source for one in exercises(notebook)}


def wrong_answer(name: str, function: str) -> str:
    """Return an answer that an exercise's check must refuse, under the function's own name."""
    path = MUTANTS / f"{name}.py"
    if not path.exists():  # an exercise of your own
        return f"def {function}(*anything):\n    return None"
    mutants = path.read_text(encoding="utf-8")
    made = [node.name for node in ast.parse(mutants).body if isinstance(node, ast.FunctionDef)]
    first = next(name for name in made if not name.startswith("_"))
    return f"{mutants}\n\n{function} = {first}"


def trials(notebook: nbformat.NotebookNode) -> dict[str, tuple[Answers, Marks]]:
    """Return what each made-up student answers, and the marks that it must get."""
    graded = exercises(notebook)
    right, half = solutions(notebook), len(graded) // 2
    wrong = {one.name: wrong_answer(one.name, one.function) for one in graded[half:]}
    nothing = {one.name: 0.0 for one in graded}
    full = {one.name: float(one.points) for one in graded}
    earned = {one.name: float(one.points) for one in graded[:half]}
    copies = ({}, nothing), ({**right, **wrong}, {**nothing, **earned}), (right, full)
    return dict(zip(STUDENTS, copies, strict=True))


def submission(released: nbformat.NotebookNode, answers: Answers) -> nbformat.NotebookNode:
    """Return a released notebook with answers written into it."""
    handed_in = copy.deepcopy(released)
    for cell in handed_in.cells:
        name = cell.metadata.get("nbgrader", {}).get("grade_id", "").removeprefix("answer-")
        cell.source = answers.get(name, cell.source)
    return handed_in


def hand_in(out: Path, student: str, name: str, answers: Answers) -> None:
    """Write a student's answers into the copy that was released, where nbgrader collects it."""
    released = nbformat.read(out / "release" / name / f"{name}.ipynb", as_version=4)
    write(out / "submitted" / student / name / f"{name}.ipynb", text(submission(released, answers)))


def grade(api: NbGraderAPI, student: str, name: str) -> Marks:
    """Run ``nbgrader autograde`` on one submission and return the marks from the gradebook."""
    result = api.autograde(name, student)
    if not result["success"]:
        sys.exit(f"{name} of {student} was not graded\n{result.get('log') or result['error']}")
    with Gradebook(api.coursedir.db_url, api.coursedir.course_id) as gradebook:
        grades = gradebook.find_submission_notebook(name, name, student).grades
        return {one.name.removeprefix("grade-"): one.score for one in grades}


def check_marks(
    notebooks: Mapping[str, nbformat.NotebookNode], api: NbGraderAPI, out: Path
) -> list[str]:
    """Grade all made-up students, print a row for each, and return what is not as it must be."""
    wrong = []
    print(f"{'notebook':26}{'copy':8}{'marks':>10}{'expected':>10}{'seconds':>10}")
    for name, notebook in notebooks.items():
        for student, (answers, expected) in trials(notebook).items():
            hand_in(out, student, name, answers)
            start = time.monotonic()
            got = grade(api, student, name)
            seconds = time.monotonic() - start
            row = f"{name:26}{student:8}{sum(got.values()):10g}{sum(expected.values()):10g}"
            print(f"{row}{seconds:10.1f}", flush=True)
            wrong += [
                f"{name}, {student}: {exercise} got {got.get(exercise)} of {points:g} expected"
                for exercise, points in expected.items()
                if got.get(exercise) != points
            ]
    return wrong


def emptied(out: Path) -> Path:
    """Remove the class folder of an earlier try; refuse to remove anybody's course."""
    students = {path.name for path in out.glob("submitted/*")}
    if out.exists() and (not (out / SETTINGS).exists() or students - set(STUDENTS)):
        sys.exit(f"expected a folder that only this command made, or none, got {out}")
    shutil.rmtree(out, ignore_errors=True)
    return out


def main() -> None:
    """Read the command line, build a class, grade it; exit with 1 where a mark is off."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="numbers or names of notebooks; default: all")
    parser.add_argument("--out", type=Path, default=Path("build/autograde"), help="made anew")
    parser.add_argument("--private-tests", type=Path, help="folder of <exercise>.py, hidden tests")
    options = parser.parse_args()
    warnings.filterwarnings("ignore", category=SAWarning)  # nbgrader's own way with its database
    notebooks = {source.stem: read(source) for source in sources(options.names)}
    hidden = private_tests(options.private_tests, list(notebooks.values()))
    api = build_class(notebooks, emptied(options.out), hidden)
    if wrong := check_marks(notebooks, api, options.out):
        sys.exit("\n".join(wrong))
    print(f"all marks are as expected, {3 * len(notebooks)} copies graded in {options.out}")


if __name__ == "__main__":
    main()

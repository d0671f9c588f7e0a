"""The class folder: one answer and one grade cell for each exercise, and marks as they must be."""

import contextlib
import importlib
import re
import sys
import types
from pathlib import Path

import jupytext
import nbformat
import pytest
from nbgrader.api import Gradebook
from nbgrader.preprocessors import ClearSolutions

from emrld_lite.classroom import checks

from .test_classroom import exercises

NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"
STEMS = sorted(path.stem for path in NOTEBOOKS.glob("[0-9][0-9]_*.py"))
GRADED = next(stem for stem in STEMS if stem.startswith("03"))  # the quickest to import
pytestmark = pytest.mark.filterwarnings("ignore::sqlalchemy.exc.SAWarning")  # nbgrader's own
MODULES = ("build", "needed", "grading", "handout", "autograde")
WARNS = "\nimport warnings\nwarnings.warn('beware')\nprint('a word')\n"


@pytest.fixture(scope="module")
def tools():
    """Return the modules beside the notebooks, imported as a script would find them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(NOTEBOOKS))
        for name in MODULES:
            patch.delitem(sys.modules, name, raising=False)
        yield types.SimpleNamespace(**{name: importlib.import_module(name) for name in MODULES})
        for name in MODULES:
            sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def plain(tools):
    """Return every notebook as its source has it."""
    return {stem: tools.build.read(NOTEBOOKS / f"{stem}.py") for stem in STEMS}


@pytest.fixture(scope="module")
def handouts(tools, plain):
    """Return nbgrader's version of every notebook."""
    return {stem: tools.handout.handout(notebook) for stem, notebook in plain.items()}


def kind(cell):
    """Return what a cell is for nbgrader, and which: ("answer", name), or ("", "") for a plain one."""
    first, _, rest = cell.metadata.get("nbgrader", {}).get("grade_id", "").partition("-")
    return first, rest


def of_kind(notebook, wanted):
    """Return the cells of one kind by name."""
    return {kind(cell)[1]: cell for cell in notebook.cells if kind(cell)[0] == wanted}


@pytest.mark.parametrize("stem", STEMS)
def test_each_exercise_has_an_answer_cell_and_then_a_grade_cell(handouts, stem):
    order = [kind(cell) for cell in handouts[stem].cells if kind(cell)[0] in ("answer", "grade")]
    graded = [name for what, name in order if what == "grade"]
    assert graded
    pairs = [(what, name) for name in graded for what in ("answer", "grade")]
    assert [one for one in order if one[1] in graded] == pairs


def test_every_exercise_of_the_workbook_is_graded(handouts):
    graded = [name for notebook in handouts.values() for name in of_kind(notebook, "grade")]
    assert sorted(graded) == sorted(exercises())


def test_a_grade_id_stands_for_one_cell_of_all_notebooks_but_the_given_ones(handouts):
    for notebook in handouts.values():
        ids = [cell.metadata.nbgrader.grade_id for cell in notebook.cells if kind(cell)[0]]
        assert len(ids) == len(set(ids))


@pytest.mark.parametrize("stem", STEMS)
def test_the_points_are_the_stated_difficulties(handouts, stem):
    """Exercises on paper state one, too: a coded one's is the last before its solution."""
    before = (NOTEBOOKS / f"{stem}.py").read_text().split("### BEGIN SOLUTION")[:-1]
    stated = [re.findall(r"Difficulty (\d) of 3", text) for text in before]
    points = [cell.metadata.nbgrader.points for cell in of_kind(handouts[stem], "grade").values()]
    assert points == [int(numbers[-1]) for numbers in stated]


@pytest.mark.parametrize("stem", STEMS)
def test_every_other_code_cell_is_put_back(handouts, stem):
    for cell in handouts[stem].cells:
        if cell.cell_type == "code" and kind(cell)[0] != "answer":
            assert cell.metadata.nbgrader.locked


@pytest.mark.parametrize("stem", STEMS)
def test_no_solution_leaks_into_the_release(tools, plain, handouts, stem):
    """What nbgrader clears is what the student version blanks, and nothing of an answer is left."""
    clear = ClearSolutions(code_stub={"python": tools.build.BLANK})
    released, _ = clear.preprocess(nbformat.from_dict(handouts[stem]), {})
    student = {cell.id: cell.source for cell in tools.build.blank(plain[stem]).cells}
    given = {cell.id: cell.source for cell in released.cells if cell.id in student}
    assert given == student
    answers = [tools.build.SOLUTION.search(cell.source) for cell in plain[stem].cells]
    bodies = [match[0].split("\n", 1)[1].rpartition("\n")[0] for match in answers if match]
    everything = "\n".join(cell.source for cell in released.cells)
    assert bodies and not any(body.strip("\n #") in everything for body in bodies)
    assert not re.search("(BEGIN|END) (SOLUTION|HIDDEN)", everything)


@pytest.mark.parametrize("stem", STEMS)
def test_jupytext_keeps_the_metadata(handouts, stem):
    there = jupytext.writes(handouts[stem], fmt="py:percent")
    back = jupytext.reads(there, fmt="py:percent")
    marked = [(cell.source, cell.metadata.get("nbgrader")) for cell in handouts[stem].cells]
    assert [(cell.source, cell.metadata.get("nbgrader")) for cell in back.cells] == marked


def test_a_missing_difficulty_is_told(tools, plain):
    notebook = nbformat.from_dict(plain[GRADED])
    for cell in notebook.cells:
        cell.source = cell.source.replace("Difficulty", "Ease")
    with pytest.raises(SystemExit, match="Difficulty n of 3"):
        tools.handout.exercises(notebook)


@pytest.mark.parametrize(("name", "told"), [("", "found none"), ("no_exercise.py", "no_exercise")])
def test_private_tests_are_named_after_exercises(tools, plain, tmp_path, name, told):
    if name:
        (tmp_path / name).write_text("assert True\n")
    with pytest.raises(SystemExit, match=told):
        tools.handout.private_tests(tmp_path, list(plain.values()))


def test_a_course_with_students_is_not_removed(tools, tmp_path):
    (tmp_path / "submitted" / "ada").mkdir(parents=True)
    (tmp_path / tools.handout.SETTINGS).write_text("")
    with pytest.raises(SystemExit, match="only this command made"):
        tools.autograde.emptied(tmp_path)
    assert (tmp_path / "submitted" / "ada").exists()


def test_require_raises_what_the_check_says():
    with pytest.raises(AssertionError, match=r"Not yet: .*still blank"):
        checks.require(checks.surrogate, blank)


def test_require_lets_a_right_answer_pass(capsys):
    checks.require(
        lambda student: print(student()) or print("Correct: it.") or True, lambda: "mine"
    )
    assert capsys.readouterr().out == "mine\nCorrect: it.\n"


def blank(*anything):
    """Answer nothing."""
    raise NotImplementedError


class Graded:
    """A class folder with hidden tests of the first exercise, and the marks of its students."""

    def __init__(self, tools, notebook, folder):
        self.tools, self.notebook, self.out = tools, notebook, folder / "class"
        self.exercises = tools.handout.exercises(notebook)
        first = self.exercises[0]
        (folder / f"{first.name}.py").write_text(f"assert {first.function}.__doc__, 'the secret'\n")
        self.hidden = tools.handout.private_tests(folder, [notebook])
        self.api = tools.handout.build_class({GRADED: notebook}, self.out, self.hidden)

    def marks(self, student, answers):
        """Return the marks for a student's answers."""
        self.tools.autograde.hand_in(self.out, student, GRADED, answers)
        return self.tools.autograde.grade(self.api, student, GRADED)

    def spoil(self, student):
        """Lose the first given cell and the last grade cell of what was handed in; break and copy others."""
        path = self.out / "submitted" / student / GRADED / f"{GRADED}.ipynb"
        notebook = nbformat.read(path, as_version=4)
        places = {what: [] for what in ("given", "grade", "answer", "")}
        for place, cell in enumerate(notebook.cells):
            places[kind(cell)[0]].append(place)
            if kind(cell)[0] == "given":
                cell.source = "raise RuntimeError"
        notebook.cells.append(nbformat.from_dict(notebook.cells[places["given"][1]]))
        for place in (places["grade"][-1], places["given"][0]):
            del notebook.cells[place]
        nbformat.write(notebook, path)


@pytest.fixture(scope="module")
def graded(tools, plain, tmp_path_factory):
    """Return the class folder of one notebook."""
    return Graded(tools, plain[GRADED], tmp_path_factory.mktemp("private"))


@pytest.mark.parametrize("student", ["blank", "half", "full"])
def test_the_marks_are_as_expected(tools, graded, student):
    answers, expected = tools.autograde.trials(graded.notebook)[student]
    assert graded.marks(student, answers) == expected


def test_only_the_spoilt_exercise_costs_marks(tools, graded):
    """One function has another name, a right one warns, and cells that are not answers are spoilt."""
    answers = tools.autograde.solutions(graded.notebook)
    renamed, warning, *_, last = graded.exercises
    answers[renamed.name] = answers[renamed.name].replace(f"def {renamed.function}(", "def mine(")
    answers[warning.name] = answers[warning.name].replace(
        "### BEGIN SOLUTION", "### BEGIN SOLUTION" + WARNS.replace("\n", "\n    ")
    )
    tools.autograde.hand_in(graded.out, "spoilt", GRADED, answers)
    graded.spoil("spoilt")
    full = {one.name: float(one.points) for one in graded.exercises}
    assert last.name not in (renamed.name, warning.name)
    assert tools.autograde.grade(graded.api, "spoilt", GRADED) == {**full, renamed.name: 0.0}


def test_a_hidden_test_takes_points_and_stays_hidden_in_the_feedback(tools, graded):
    first = graded.exercises[0]
    answer = tools.autograde.solutions(graded.notebook)[first.name]
    got = graded.marks("fitted", {first.name: f"{answer}\n\n{first.function}.__doc__ = None"})
    assert got[first.name] == 0
    assert graded.api.generate_feedback(GRADED, "fitted")["success"]
    feedback = (graded.out / "feedback" / "fitted" / GRADED / f"{GRADED}.html").read_text()
    assert "the secret" in feedback  # what the test says as it stops
    assert f"assert {first.function}" not in feedback and "HIDDEN" not in feedback


def test_students_do_not_see_the_hidden_tests(graded):
    released = (graded.out / "release" / GRADED / f"{GRADED}.ipynb").read_text()
    assert "the secret" not in released and "HIDDEN" not in released
    assert "the secret" in (graded.out / "source" / GRADED / f"{GRADED}.ipynb").read_text()


def test_building_again_keeps_settings_and_marks(tools, graded):
    settings = graded.out / tools.handout.SETTINGS
    settings.write_text(settings.read_text() + "\nc.CourseDirectory.course_id = 'mine'\n")
    with contextlib.closing(Gradebook(graded.api.coursedir.db_url)) as gradebook:
        gradebook.update_or_create_student("ada")
        gradebook.update_or_create_submission(GRADED, "ada")
    api = tools.handout.build_class({GRADED: graded.notebook}, graded.out, graded.hidden)
    assert api.coursedir.course_id == "mine"
    with contextlib.closing(Gradebook(api.coursedir.db_url)) as gradebook:
        assert gradebook.find_submission(GRADED, "ada").max_score > 0


def course(*cells):
    """Return a notebook of cells (kind, source)."""
    notebook = nbformat.v4.new_notebook()
    for number, (what, source) in enumerate(cells):
        cell = nbformat.v4.new_code_cell(source)
        if what:
            cell.metadata["nbgrader"] = {
                "grade_id": f"{what}-{number}",
                "grade": what == "grade",
                "locked": what != "answer",
            }
        notebook.cells.append(cell)
    return notebook


@pytest.mark.parametrize(
    ("cells", "run"),
    [
        # a training that nothing uses is not run, imports are
        (["given: import torch", "given: torch.zeros(9)", "answer: f = torch.sum"], {0, 2, 3}),
        # a helper is run with what it needs in turn, also where only the function's body uses it
        (["given: a = 1", "given: b = a + 1", "answer: def f(): return b"], {0, 1, 2, 3}),
        # a name that is local to the answer is not the notebook's
        (["given: b = 1", "answer: def f(b): return b"], {1, 2}),
        # changed in place
        (["given: b = {}", "given: b['x'] = 1", "answer: def f(): return b"], {0, 1, 2, 3}),
        (["given: b = []", "given: b.append(1)", "answer: def f(): return b"], {0, 1, 2, 3}),
        # a module's function called for its effect changes nothing else
        (["given: import torch", "given: torch.manual_seed(0)", "answer: f = torch"], {0, 2, 3}),
        # bound by a function through `global`, by a loop, by an import
        (["given: def g():\n global b\n b = 1", "answer: def f(): return b"], {0, 1, 2}),
        (["given: for b in [1]: pass", "answer: def f(): return b"], {0, 1, 2}),
        # a cell of the student's own runs, with what it needs
        (["given: a = 1", ": b = a", "given: c = 2", "answer: f = 0"], {0, 1, 3, 4}),
        # names looked up at run time: everything
        (["given: a = 1", "answer: def f(): return eval('a')"], {0, 1, 2}),
        # what cannot be read asks for nothing
        (["given: a = 1", "answer: def f(: return a"], {1, 2}),
        # magics are no syntax error
        (["given: a = 1", "answer: %time\nf = a"], {0, 1, 2}),
    ],
)
def test_what_a_mark_can_depend_on_is_run(tools, cells, run):
    parts = [
        cell.partition(": ")[::2] if not cell.startswith(":") else ("", cell[2:]) for cell in cells
    ]
    assert tools.needed.needed(course(*parts, ("grade", "f"))) == run


def test_to_grade_a_notebook_its_imports_are_run_and_no_training(tools, handouts):
    for notebook in handouts.values():
        run = [notebook.cells[number] for number in sorted(tools.needed.needed(notebook))]
        own = [cell for cell in run if kind(cell)[0] != "given"]
        assert len(run) - len(own) <= 2
        assert len(own) == sum(kind(cell)[0] in ("answer", "grade") for cell in notebook.cells)

"""JupyterLab in a real browser: a notebook to its end, a slider, an exercise wrong and then right."""

import ast
import re
from itertools import pairwise

import nbformat
import pytest

from . import browser, jupyterlab
from .test_classroom import ROOT, exercises, mutants

NOTEBOOKS = sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb"))
CHECK = re.compile(r"check\.(\w+)\((\w+)\)")
SLIDERS = "[Sliders: "  # what notebooks/outputs.py writes in place of a widget
FAILING = ["print('before')", "raise ValueError('on purpose')", "print('after')"]
pytestmark = browser.needed


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder that JupyterLab serves."""
    return tmp_path_factory.mktemp("notebooks")


@pytest.fixture(scope="module")
def server(folder, tmp_path_factory):
    """Return the address of a JupyterLab with the settings it comes with."""
    with jupyterlab.server(folder, tmp_path_factory.mktemp("user")) as url:
        yield url


@pytest.fixture
def opened(chromium, server, folder):
    """Return a function that opens a notebook, without its outputs, in JupyterLab."""
    contexts = []

    def open_notebook(notebook, name):
        for cell in notebook.cells:
            if cell.cell_type == "code":
                cell.outputs, cell.execution_count = [], None
        nbformat.write(notebook, folder / name)
        lab = jupyterlab.Lab(chromium, server, folder / name)
        contexts.append(lab.context)
        return lab

    yield open_notebook
    for context in contexts:
        context.close()


def with_sliders():
    """Return the first notebook that shows sliders."""
    return next(path for path in NOTEBOOKS if SLIDERS in path.read_text(encoding="utf-8"))


def first_exercise(notebook):
    """Return the places of a notebook's first exercise and of its check, and the check's name."""
    code = [place for place, cell in enumerate(notebook.cells) if cell.cell_type == "code"]
    for exercise, place in pairwise(code):
        if match := CHECK.search(notebook.cells[place].source):
            return exercise, place, match[1]
    raise AssertionError("the notebook has no exercise")


def solution(name):
    """Return an exercise's cell with the solution that the notebook gives."""
    return exercises()[name][0]


def wrong_answer(name):
    """Return the first mutant of an exercise as a student would write it, and the hint it should get."""
    path = ROOT / f"tests/mutants/{name}.py"
    mutant = mutants(path)[0]
    source = path.read_text(encoding="utf-8")
    kept, needed = [], {mutant.__name__}
    for node in reversed(ast.parse(source).body):  # what a line needs stands above it
        names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
        defined = {one.id for one in getattr(node, "targets", [])} | {getattr(node, "name", "")}
        if isinstance(node, ast.Import | ast.ImportFrom) or defined & needed:
            kept.insert(0, ast.get_source_segment(source, node))
            needed |= names
    assigned = f"{exercises()[name][1]} = {mutant.__name__}"
    return "\n\n".join([*kept, assigned]), mutant.__doc__


def outside(lab, server):
    """Return the requests of a page for anything but the server on the loopback."""
    inside = (server, server.replace("http", "ws"), "data:", "blob:")
    return [url for url in lab.seen.requests if not url.startswith(inside)]


def test_a_notebook_runs_to_its_end_and_a_slider_moves_its_figure(opened, server):
    lab = opened(nbformat.read(with_sliders(), as_version=4), "whole.ipynb")
    lab.run_all()
    lab.save()
    lab.seen.picture("lab-1-run")
    code = [cell for cell in lab.saved().cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    outputs = [output for cell in code for output in cell.outputs]
    assert [output for output in outputs if output.output_type == "error"] == []

    handle = lab.page.locator(".widget-interact .noUi-handle").first
    figure = lab.page.locator(".widget-interact img").first
    handle.focus()
    figure.scroll_into_view_if_needed()
    lab.seen.picture("lab-2-slider")
    value, drawn = handle.get_attribute("aria-valuenow"), figure.get_attribute("src")
    lab.page.keyboard.press("ArrowRight")
    lab.expect(handle).not_to_have_attribute("aria-valuenow", value)
    lab.expect(figure).not_to_have_attribute("src", drawn)
    lab.expect(figure).to_have_attribute("src", re.compile("^data:image/png;base64,.{1000}"))
    lab.seen.picture("lab-3-slider-moved")
    assert outside(lab, server) == []


def test_a_student_is_told_what_is_wrong_and_then_that_it_is_right(opened):
    notebook = nbformat.read(ROOT / "notebooks/lab" / NOTEBOOKS[0].name, as_version=4)
    exercise, check, name = first_exercise(notebook)
    lab = opened(notebook, "student.ipynb")
    cells = lab.cells
    cells.nth(exercise).locator(".cm-content").click()
    lab.choose("Run All Above Selected Cell")
    text, hint = wrong_answer(name)
    told = cells.nth(check).locator(".jp-OutputArea-output").first

    for number, answer, words in ((4, text, hint), (5, solution(name), "Correct")):
        lab.run(cells.nth(exercise), answer)
        lab.run(cells.nth(check))
        lab.expect(told).to_contain_text(words)
        told.scroll_into_view_if_needed()
        lab.seen.picture(f"lab-{number}-{'right' if words == 'Correct' else 'wrong'}")
        if words != "Correct":
            lab.expect(told).to_contain_text("Not yet: ")
    assert lab.failures.count() == 0


def test_a_cell_that_fails_would_be_seen(opened):
    cells = [nbformat.v4.new_code_cell(source) for source in FAILING]
    metadata = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    lab = opened(nbformat.v4.new_notebook(cells=cells, metadata=metadata), "failing.ipynb")
    lab.run_all()
    assert lab.failures.count() == 1
    assert lab.prompt(lab.cells.nth(2)).text_content() == "[ ]:"

"""The notebook builder keeps tags and refuses outputs that no reader should see."""

import importlib
import re
import sys
from pathlib import Path

import jupytext
import nbformat
import pytest

NOTEBOOKS = Path(__file__).resolve().parent.parent / "notebooks"
SOURCE = """# %% [markdown]
# # A notebook

# %% tags=["tolerance:0.05", "exercise-half"]
### BEGIN SOLUTION
print(f"return {0.5:.2f}")
### END SOLUTION
"""


@pytest.fixture
def build(monkeypatch):
    """Return the builder, imported as a script would find it."""
    monkeypatch.syspath_prepend(str(NOTEBOOKS))
    monkeypatch.delitem(sys.modules, "build", raising=False)
    yield importlib.import_module("build")
    sys.modules.pop("build", None)


@pytest.fixture
def source(build, tmp_path, monkeypatch):
    """Return the source of a small notebook in a folder of its own, built."""
    monkeypatch.setattr(build, "HERE", tmp_path)
    monkeypatch.setattr(build, "LAB", tmp_path / "lab")
    path = tmp_path / "01_small.py"
    path.write_text(SOURCE)
    build.build(path)
    return path


def notebook_of(*outputs, tags=()):
    """Return a notebook of one executed cell with these outputs."""
    cell = nbformat.v4.new_code_cell("pass", outputs=list(outputs), execution_count=1)
    cell.metadata["tags"] = list(tags)
    return nbformat.v4.new_notebook(cells=[cell])


def stream(text, name="stdout"):
    """Return a stream output."""
    return nbformat.v4.new_output("stream", name=name, text=text)


def test_tags_travel_to_both_notebooks(build, source):
    for path in (source.with_suffix(".ipynb"), source.parent / "lab" / "01_small.ipynb"):
        (cell,) = [c for c in nbformat.read(path, as_version=4).cells if c.cell_type == "code"]
        assert cell.metadata.tags == ["tolerance:0.05", "exercise-half"]
    assert build.drift(source) == []


def test_a_changed_tag_is_drift(build, source):
    source.write_text(SOURCE.replace("0.05", "0.5"))
    assert any("does not have the cells" in sentence for sentence in build.drift(source))


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("print('returns went up:', 2 > 1)", "boolean"),
        ("print('/tmp/x/drawing.py')", "path"),
        ("import warnings; warnings.warn('beware')", "stderr"),
        ("import ipywidgets; ipywidgets.VBox()", None),
    ],
)
def test_a_build_writes_no_such_output(build, source, line, told):
    source.write_text(SOURCE + f"\n# %%\n{line}\n")
    if told is None:
        build.build(source)
        assert "Sliders" in source.with_suffix(".ipynb").read_text()
        return
    before = source.with_suffix(".ipynb").read_text()
    with pytest.raises(SystemExit, match=told):
        build.build(source)
    assert source.with_suffix(".ipynb").read_text() == before


@pytest.mark.parametrize(
    "text",
    [
        "returns went up: True",
        "True",
        "more than ten batches: False\nelse",
        "is it so? True.",
        "x.py:97: UserWarning: no gridspecs",
        "/home/somebody/emrld_lite/envs/drawing.py:97",
        "see /root/x",
        "C:\\Users\\somebody",
        "lib/python3.11/site-packages/torch",
        "<function f at 0x7f00beef>",
        "interactive(children=(IntSlider(value=60),))",
        "VBox(children=())",
    ],
)
def test_unwanted_outputs_are_found(build, text):
    assert build.unwanted(notebook_of(stream(f"first\n{text}\n")))
    shown = nbformat.v4.new_output("display_data", data={"text/plain": text})
    assert build.unwanted(notebook_of(shown))


@pytest.mark.parametrize(
    "text",
    [
        "returns went from -187.3 to -52.0",
        "Adaptation(warm_start=True).",
        "True values lie above the line",
        "python -m emrld_lite train --out data/runs/point2d",
        "<Figure size 594x352 with 1 Axes>",
    ],
)
def test_ordinary_outputs_are_not(build, text):
    assert build.unwanted(notebook_of(stream(f"{text}\n"))) == []


def test_stderr_is_unwanted_and_a_tag_allows_a_boolean(build):
    assert build.unwanted(notebook_of(stream("loading\n", name="stderr")))
    assert build.unwanted(notebook_of(stream("equal: True\n"), tags=["boolean"])) == []


def test_drift_tells_of_unwanted_outputs(build, source):
    target = source.with_suffix(".ipynb")
    notebook = nbformat.read(target, as_version=4)
    notebook.cells[1].outputs = [stream("went up: True\n")]
    nbformat.write(notebook, target)
    (told,) = build.drift(source)
    assert "cell 1 shows a boolean in place of a number: went up: True" in told


GUESS = """# %%
guess.ask("sum", "two and two")

# %% tags=["reveal"]
total = 2 + 2
assert (
    total == 4
)
guess.reveal("sum", f"{total}")

# %% [markdown] tags=["reveal"]
# It is **four**.

# %% [markdown]
# The next question.
"""


def test_the_student_version_folds_the_answer_to_a_guess(build, tmp_path):
    path = tmp_path / "01_guess.py"
    path.write_text(GUESS)
    asked, answer, prose, after = build.blank(build.read(path)).cells
    assert asked.source == 'guess.ask("sum", "two and two")'
    assert answer.source == 'total = 2 + 2\nguess.reveal("sum", f"{total}")'
    assert prose.source.startswith("<details><summary>After your guess")
    assert "\n\nIt is **four**.\n\n</details>" in prose.source
    assert after.source == "The next question."


def test_an_assertion_that_is_all_of_a_block_cannot_be_left_out(build):
    with pytest.raises(SyntaxError):
        build.without_assertions("if ready:\n    assert 1 == 1")


def guesses_of(path):
    """Return the cells of a source: what each asks, what it reveals, and whether it is folded."""
    cells = jupytext.read(path).cells
    return [
        (
            re.findall(r'guess\.ask\(\s*"(\w+)"', cell.source),
            re.findall(r'guess\.reveal\(\s*"(\w+)"', cell.source),
            "reveal" in cell.metadata.get("tags", []),
            cell,
        )
        for cell in cells
    ]


@pytest.mark.parametrize("path", sorted(NOTEBOOKS.glob("[0-9]*.py")), ids=lambda path: path.stem)
def test_every_guess_is_answered_once_and_later_and_folded(path):
    cells = guesses_of(path)
    asked = [(name, place) for place, cell in enumerate(cells) for name in cell[0]]
    answered = {name: place for place, cell in enumerate(cells) for name in cell[1]}
    assert sorted(name for name, _ in asked) == sorted(name for cell in cells for name in cell[1])
    for name, place in asked:
        assert place < answered[name] and cells[answered[name]][2], name
    for _, _, folded, cell in cells:
        assert not (folded and re.search(r"^#", cell.source, re.M) and cell.cell_type == "markdown")

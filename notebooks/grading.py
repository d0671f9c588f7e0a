"""How nbgrader grades what is handed in: given cells are put back, and what marks need is run.

A notebook trains for minutes, and no mark hangs on a training. So of the cells that were given, only
those run whose names an answer, a grade cell or a cell of the student's own uses, directly or through
another given cell. What is skipped cannot be seen by what is graded. In doubt a cell runs: where code
looks names up while it runs (``eval``, ``globals``), the whole notebook does.
"""

from __future__ import annotations

import ast
import symtable
from typing import Any, NamedTuple

from IPython.core.inputtransformer2 import TransformerManager
from jupyter_client import KernelClient
from nbformat import NotebookNode, from_dict
from nbformat.v4 import new_code_cell
from nbgrader.api import SourceCell
from nbgrader.preprocessors import Execute, OverwriteCells

from build import looking_again

LOOK_UP = {"eval", "exec", "globals", "locals", "vars", "__import__", "get_ipython"}


class Names(NamedTuple):
    """What a cell does with the notebook's names."""

    used: set[str]
    bound: set[str]
    changed: set[str]  # in place: an entry or an attribute set, a method called for its effect
    imported: set[str]


def names(source: str) -> Names:
    """Return a cell's names; none for a cell that Python cannot read, since none of it would run."""
    code = TransformerManager().transform_cell(source)
    try:
        tree = ast.parse(code)
        table = symtable.symtable(code, "cell", "exec")
    except (SyntaxError, ValueError):
        return Names(set(), set(), set(), set())
    symbols = table.get_symbols()
    imported = {symbol.get_name() for symbol in symbols if symbol.is_imported()}
    found = Names(
        used={symbol.get_name() for symbol in symbols if symbol.is_referenced()},
        bound={symbol.get_name() for symbol in symbols if symbol.is_assigned()} | imported,
        changed={name for node in ast.walk(tree) if (name := _changed(node))},
        imported=imported,
    )
    for inner in table.get_children():
        _add_inner(inner, found)
    return found


def _add_inner(table: symtable.SymbolTable, found: Names) -> None:
    """Add the notebook's names that a function, class or comprehension of the cell uses or binds."""
    for symbol in table.get_symbols():
        if symbol.is_global():
            found.used.add(symbol.get_name())
            if symbol.is_assigned():
                found.bound.add(symbol.get_name())
    for inner in table.get_children():
        _add_inner(inner, found)


def _changed(node: ast.AST) -> str | None:
    """Return the name whose object a piece of syntax changes in place, if it does."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        part: ast.AST = node.value.func  # axes.set(...): called for its effect
    elif isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
        part = node
    else:
        return None
    if isinstance(part, ast.Name):
        return None
    while isinstance(part, ast.Attribute | ast.Subscript):
        part = part.value
    return part.id if isinstance(part, ast.Name) else None


def needed(notebook: NotebookNode) -> set[int]:
    """Return the positions of the code cells that grading a notebook has to run."""
    code = [number for number, cell in enumerate(notebook.cells) if cell.cell_type == "code"]
    cells = {number: names(notebook.cells[number].source) for number in code}
    imported = set().union(*(cell.imported for cell in cells.values()))
    run = {number for number in code if not given(notebook.cells[number])}
    while True:
        wanted = set().union(*(cells[number].used for number in run))
        if wanted & LOOK_UP:
            return set(code)
        more = {
            number
            for number in code
            if number < max(run)
            and wanted & (cells[number].bound | (cells[number].changed - imported))
        }
        if more <= run:
            return run
        run |= more


def given(cell: NotebookNode) -> bool:
    """Return whether a cell came with the notebook and is neither an answer nor a grade."""
    marks = cell.metadata.get("nbgrader", {})
    return bool(marks.get("locked")) and not marks.get("grade")


class ExecuteNeeded(Execute):
    """nbgrader's preprocessor that runs a notebook, past the cells that no mark can depend on."""

    def preprocess(self, notebook: NotebookNode, *arguments: Any, **options: Any) -> Any:
        """Run the cells that are needed."""
        self._needed = needed(notebook)
        return super().preprocess(notebook, *arguments, **options)

    def preprocess_cell(self, cell: NotebookNode, resources: Any, index: int) -> Any:
        """Run one cell if it is needed."""
        if cell.cell_type == "code" and index not in self._needed:
            return cell, resources
        return super().preprocess_cell(cell, resources, index)

    async def async_start_new_kernel_client(self) -> KernelClient:
        """Return the kernel's client, its channels made patient as in build.py."""
        client = await super().async_start_new_kernel_client()
        for channel in (client.shell_channel, client.iopub_channel):
            channel.get_msg = looking_again(channel.get_msg)
        return client


class PutBack(OverwriteCells):
    """nbgrader's preprocessor that makes locked cells what they were, also those that are gone.

    nbgrader's own stops where a given cell is gone, copied or from an earlier handout, and then the
    whole notebook gets no marks.
    """

    def preprocess(self, notebook: NotebookNode, resources: Any) -> Any:
        """Put back all locked cells; a copy, or a cell of no exercise, is the student's own."""
        _disown(notebook)
        notebook, resources = super().preprocess(notebook, resources)
        _disown(notebook)
        return notebook, resources

    def add_missing_grade_cells(self, notebook: NotebookNode, resources: Any) -> Any:
        """Put the locked cells that are gone where they were, or near."""
        course = self.gradebook.find_notebook(self.notebook_id, self.assignment_id)
        points = {cell.name: cell.max_score for cell in course.grade_cells}
        for lost in sorted(course.source_cells, key=lambda cell: cell.name):
            here = {identity(cell): place for place, cell in enumerate(notebook.cells)}
            if lost.locked and lost.name not in here:
                place = _place(lost.name, here, len(notebook.cells))
                notebook.cells.insert(place, _as_it_was(lost, points.get(lost.name)))
        return notebook, resources

    def add_missing_task_cells(self, notebook: NotebookNode, resources: Any) -> Any:
        """Return the notebook: our notebooks have no cells of this kind."""
        return notebook, resources


def _disown(notebook: NotebookNode) -> None:
    """Take nbgrader's marks from the cells that it does not know by name."""
    for cell in notebook.cells:
        if not identity(cell):
            cell.metadata.pop("nbgrader", None)


def identity(cell: NotebookNode) -> str:
    """Return the name by which nbgrader knows a cell, or an empty one."""
    return cell.metadata.get("nbgrader", {}).get("grade_id", "")


def _place(name: str, here: dict[str, int], end: int) -> int:
    """Return where a lost cell goes: a grade behind its answer, others behind the given one before."""
    kind, _, rest = name.partition("-")
    if kind == "grade":
        return here.get(f"answer-{rest}", end - 1) + 1
    before = [place for other, place in here.items() if other.startswith(kind) and other < name]
    return max(before, default=-1) + 1


def _as_it_was(lost: SourceCell, points: float | None) -> NotebookNode:
    cell = new_code_cell(lost.source)
    cell.metadata["nbgrader"] = from_dict(
        {
            "schema_version": 3,
            "grade_id": lost.name,
            "grade": points is not None,
            "solution": False,
            "locked": True,
            "task": False,
            "cell_type": "code",
            "checksum": lost.checksum,
            **({} if points is None else {"points": points}),
        }
    )
    return cell

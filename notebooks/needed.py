"""Which cells of a handed-in notebook grading has to run: the answers, the grades, and what these need.

A notebook trains for minutes, and no mark hangs on a training. So of the cells that were given, only
those run whose names an answer, a grade cell or a cell of the student's own uses, directly or through
another given cell, and those that change such a name's object in place. Where code looks names up
while it runs (``eval``, ``globals``), the whole notebook runs. Not seen is a change that a given cell
makes by handing an object to a function.
"""

from __future__ import annotations

import ast
import symtable
from typing import NamedTuple

from IPython.core.inputtransformer2 import TransformerManager
from nbformat import NotebookNode

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

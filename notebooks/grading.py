"""Steps of nbgrader's that these notebooks need otherwise; grading_config.py puts them in."""

from __future__ import annotations

from typing import Any

from jupyter_client import KernelClient
from nbformat import NotebookNode, from_dict
from nbformat.v4 import new_code_cell
from nbgrader.api import SourceCell
from nbgrader.preprocessors import ClearHiddenTests, Execute, OverwriteCells

from build import looking_again
from needed import needed


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


class KeepHidden(ClearHiddenTests):
    """nbgrader's preprocessor that removes hidden tests, for the feedback, where they would be shown."""

    def preprocess_cell(self, cell: NotebookNode, resources: Any, index: int) -> Any:
        """Remove the tests and where they stopped; what they said as they stopped stays."""
        shown = cell.source
        cell, resources = super().preprocess_cell(cell, resources, index)
        if cell.source != shown:
            for output in cell.get("outputs", []):
                if output.output_type == "error":
                    output.traceback = [f"{output.ename}: {output.evalue}"]
        return cell, resources

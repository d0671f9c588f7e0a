"""Build the notebooks: NN_name.py -> executed NN_name.ipynb -> lab/NN_name.ipynb with blanks.

    python notebooks/build.py              build every notebook
    python notebooks/build.py 01 06        build these
    python notebooks/build.py --check      change nothing; fail where a notebook has drifted

The percent-format .py is the only source anyone edits. The same source makes the same bytes twice.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import math
import os
import queue
import re
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import jupytext
import nbformat
from jupyter_client import KernelClient
from nbclient import NotebookClient
from outputs import unwanted, without_widgets

HERE = Path(__file__).resolve().parent
LAB = HERE / "lab"
KERNEL = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
SOLUTION = re.compile(
    r"^(?P<indent>[ \t]*)### BEGIN SOLUTION\n.*?^[ \t]*### END SOLUTION[ \t]*$\n?",
    re.MULTILINE | re.DOTALL,
)
FOLDED = "After your guess: what comes out, and why"
BLANK = "raise NotImplementedError  # your code here"
CELL_TIMEOUT = 600  # seconds
NO_ALT = "No description has been provided for this image"  # what nbconvert writes


def sources(names: list[str]) -> list[Path]:
    """Return the notebook sources whose names start with one of ``names``, or all of them."""
    found = sorted(HERE.glob("[0-9][0-9]_*.py"))
    chosen = [path for path in found if not names or path.stem.startswith(tuple(names))]
    if not chosen:
        known = ", ".join(path.stem for path in found)
        sys.exit(f"no notebook starts with {' or '.join(names)}; there are: {known}")
    return chosen


def read(source: Path) -> nbformat.NotebookNode:
    """Return the notebook of a percent-format source, with fixed cell ids and little metadata."""
    notebook = jupytext.read(source, fmt="py:percent")
    notebook.metadata = nbformat.from_dict({"kernelspec": KERNEL})
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number:03d}"
        tags = cell.metadata.get("tags")
        cell.metadata = nbformat.from_dict({"tags": tags} if tags else {})
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    return notebook


class PatientClient(NotebookClient):
    """A client that looks for messages every second: a wake-up from pyzmq to asyncio can get lost.

    Without it, a build now and then waits to CELL_TIMEOUT for a reply that has come.
    """

    async def async_start_new_kernel_client(self) -> KernelClient:
        """Return the kernel's client, its channels made patient."""
        client = await super().async_start_new_kernel_client()
        for channel in (client.shell_channel, client.iopub_channel):
            channel.get_msg = looking_again(channel.get_msg)
        return client


def looking_again(get_message: Callable[..., Awaitable[dict]]) -> Callable[..., Awaitable[dict]]:
    """Return the same function, asking once a second until its timeout is over."""

    async def patiently(timeout: float | None = None) -> dict:
        deadline = math.inf if timeout is None else time.monotonic() + timeout
        while (left := deadline - time.monotonic()) > 1.0:
            with contextlib.suppress(queue.Empty):
                return await get_message(timeout=1.0)
        return await get_message(timeout=max(0.0, left))

    return patiently


def execute(notebook: nbformat.NotebookNode, past_errors: bool = False) -> nbformat.NotebookNode:
    """Run every cell from the top in a fresh kernel; a sentence stands in for each widget afterwards.

    With ``past_errors`` a cell that fails shows its error and the next one is run all the same.
    """
    os.environ.setdefault("PYDEVD_DISABLE_FILE_VALIDATION", "1")
    client = PatientClient(
        notebook,
        timeout=CELL_TIMEOUT,
        kernel_name="python3",
        record_timing=False,
        allow_errors=past_errors,
        coalesce_streams=True,  # how the kernel cut its output is chance
        resources={"metadata": {"path": str(HERE)}},
    )
    client.execute()
    notebook.metadata.pop("widgets", None)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [without_widgets(output) for output in cell.outputs]
    describe_figures(notebook)
    return notebook


def describe_figures(notebook: nbformat.NotebookNode) -> None:
    """Give every figure the caption that follows it as its alternative text."""
    for position, cell in enumerate(notebook.cells):
        caption = next(
            (
                match[1].replace("\n", " ")
                for later in notebook.cells[position + 1 :]
                if (match := re.match(r"\*(Figure .*?)\*(?:\n\n|$)", later.source, re.DOTALL))
            ),
            None,
        )
        for output in cell.get("outputs", []):
            if "image/png" in output.get("data", {}) and caption:
                output.metadata["image/png"] = {"alt": caption}


def blank(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Return the student version: no outputs, a blank where each solution stood, and no answer in sight.

    A cell with the tag ``reveal`` stands after a guess and gives the answer: its prose is folded, and
    its assertions, which state what will come out, are left to the complete notebook.
    """
    student = nbformat.from_dict(notebook.copy())
    student.cells = [nbformat.from_dict(dict(cell)) for cell in notebook.cells]
    for cell in student.cells:
        reveals = "reveal" in cell.metadata.get("tags", [])
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
            cell.source = SOLUTION.sub(rf"\g<indent>{BLANK}\n", cell.source).rstrip("\n")
            if reveals:
                cell.source = without_assertions(cell.source)
        elif reveals:
            cell.source = f"<details><summary>{FOLDED}</summary>\n\n{cell.source}\n\n</details>"
    return student


def without_assertions(source: str) -> str:
    """Return code without its assert statements; SyntaxError where one was a block's only line."""
    lines = source.splitlines()
    claims = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Assert)]
    for claim in sorted(claims, key=lambda node: node.lineno, reverse=True):
        del lines[claim.lineno - 1 : claim.end_lineno]
    kept = "\n".join(lines).rstrip("\n")
    ast.parse(kept)
    return kept


def text(notebook: nbformat.NotebookNode) -> str:
    """Return a notebook as the bytes that go into its file."""
    return nbformat.writes(notebook) + "\n"


def write(path: Path, content: str) -> None:
    """Write a text file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8") as file:
        file.write(content)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def build(source: Path) -> None:
    """Write the executed notebook and the student version of one source, if its outputs are clean."""
    notebook = execute(read(source))
    if wrong := unwanted(notebook):
        sys.exit("\n".join([f"{source.stem} was not written", *wrong]))
    write(source.with_suffix(".ipynb"), text(notebook))
    write(LAB / f"{source.stem}.ipynb", text(blank(read(source))))
    print(f"{source.stem}: built")


def identities(notebook: nbformat.NotebookNode) -> list[tuple]:
    """Return what a built notebook takes over from its source, cell by cell, tags included."""
    return [(cell.cell_type, cell.source, cell.metadata.get("tags")) for cell in notebook.cells]


def drift(source: Path) -> list[str]:
    """Return what is wrong between a source, its notebook and its student version."""
    fresh = read(source)
    target, student = source.with_suffix(".ipynb"), LAB / f"{source.stem}.ipynb"
    if not target.exists():
        return [f"{target.name} is missing"]
    kept = nbformat.read(target, as_version=4)
    wrong = []
    if identities(kept) != identities(fresh):
        wrong.append(f"{target.name} does not have the cells of {source.name}")
    code = [cell for cell in kept.cells if cell.cell_type == "code" and cell.source.strip()]
    never = sum(cell.execution_count is None for cell in code)
    if never:
        wrong.append(f"{target.name}: {never} code cells were never executed")
    if not any(cell.outputs for cell in code):
        wrong.append(f"{target.name} has no outputs")
    if any(output.output_type == "error" for cell in code for output in cell.outputs):
        wrong.append(f"{target.name} holds an error")
    wrong += [f"{target.name}: {sentence}" for sentence in unwanted(kept)]
    if not student.exists() or student.read_text(encoding="utf-8") != text(blank(fresh)):
        wrong.append(f"lab/{student.name} is not the blanked {source.name}")
    elif "SOLUTION" in student.read_text(encoding="utf-8"):
        wrong.append(f"lab/{student.name} still shows a solution marker")
    return wrong


def strays() -> list[str]:
    """Return the notebooks that no source makes."""
    stems = {path.stem for path in sources([])}
    found = [*HERE.glob("*.ipynb"), *LAB.glob("*.ipynb")]
    return [f"{path.relative_to(HERE)} has no source" for path in found if path.stem not in stems]


def check(chosen: list[Path]) -> None:
    """Exit with 1 and a list when anything has drifted."""
    wrong = [line for source in chosen for line in drift(source)] + strays()
    if wrong:
        sys.exit("\n".join([*wrong, "run: make notebooks"]))
    print(f"{len(chosen)} notebooks agree with their sources")


def main() -> None:
    """Read the command line and build or check."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="numbers or names of notebooks; default: all")
    parser.add_argument("--check", action="store_true", help="only look for drift")
    options = parser.parse_args()
    if options.check:
        check(sources(options.names))
    else:
        for source in sources(options.names):
            build(source)


if __name__ == "__main__":
    main()

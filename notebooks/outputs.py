"""What no committed output may hold: warnings, one machine's paths and addresses, bare reprs, verdicts.

A reader who does not run a notebook sees only its outputs. They show numbers, not booleans about them; a
cell whose lesson is a boolean has the tag ``boolean``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import nbformat

ROOT = Path(__file__).resolve().parent.parent
SLIDERS = "[Sliders: they appear where this notebook runs. The still picture below shows what they teach.]"
UNWANTED = {
    "a warning": re.compile(r"\w*Warning: "),
    "a machine's path": re.compile(
        rf"(?<![\w.])/(?:tmp|home|root|work|Users|opt|usr)/|\b[A-Z]:\\|site-packages|{re.escape(str(ROOT))}\b"
    ),
    "an object's address": re.compile(r"\b0x[0-9a-fA-F]+"),
    "the bare text of a widget": re.compile(
        r"\w+\(children=|\b(?:interactive|[VH]Box|\w+Slider)\("
    ),
}
BOOLEAN = re.compile(r"(?:: *|= )(?:True|False)\b|\b(?:True|False)[.!]?\s*$", re.MULTILINE)


def without_widgets(output: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Return an output with a sentence in place of a widget, which lives only in the kernel that made it."""
    shown = output.get("data", {})
    is_widget = shown.pop("application/vnd.jupyter.widget-view+json", None)
    if is_widget and not shown["text/plain"].startswith("["):  # a guess box says itself what it is
        shown["text/plain"] = SLIDERS
    return output


def texts(output: nbformat.NotebookNode) -> Iterator[str]:
    """Yield what of an output is text."""
    if "text" in output:
        yield output.text
    for kind, content in output.get("data", {}).items():
        if kind.startswith("text/"):
            yield content


def unwanted(notebook: nbformat.NotebookNode) -> list[str]:
    """Return, a sentence each, what the outputs of a notebook hold and should not."""
    found = []
    for position, cell in enumerate(notebook.cells):
        looked_for = dict(UNWANTED)
        if "boolean" not in cell.metadata.get("tags", []):
            looked_for["a boolean in place of a number"] = BOOLEAN
        for output in cell.get("outputs", []):
            if output.get("name") == "stderr":
                found.append(f"cell {position} wrote to stderr: {output.text.strip()}")
            for text in texts(output):
                for what, pattern in looked_for.items():
                    line = next((line for line in text.splitlines() if pattern.search(line)), None)
                    if line is not None:
                        found.append(f"cell {position} shows {what}: {line.strip()}")
    return found

"""A check as a grade: it stops the cell when the answer is wrong, which graders count as no points."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable

from .answers import Student


def require(check: Callable[[Student], bool], student: Student) -> None:
    """Run a check; raise AssertionError with its sentence when the answer is wrong."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        right = check(student)
    *others, verdict = said.getvalue().rstrip("\n").split("\n")
    for line in others:  # what the student's function printed
        print(line)
    if not right:
        raise AssertionError(verdict)
    print(verdict)

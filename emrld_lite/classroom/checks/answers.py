"""How a check answers: one sentence, printed, and True or False; it never raises.

The sentence names the mistake. An answer that stops, ends the program or does not end is told so.
"""

from __future__ import annotations

import functools
import traceback
from collections.abc import Callable
from typing import Any

from .patience import TimeUp, limited

Student = Callable[..., Any]

PATIENCE = 10.0  # seconds for a whole check, which takes a right answer well under one

# What torch and Python say, and what it means in these exercises.
_ENGINE = {
    "leaf Variable that requires grad": "you change an argument in place (with -= or a function "
    "whose name ends in _); compute a new tensor from it.",
    "view and its base or another view": "you change an argument in place; compute a new tensor.",
    "modified by an inplace operation": "something that the gradient needs was changed in place; "
    "compute a new tensor.",
    "does not require grad": "you ask for a gradient of something that is cut from its argument: "
    "is there a `.detach()`, `.data`, `.item()` or `torch.no_grad()` before it?",
    "not have been used in the graph": "you ask for a gradient of something that does not depend "
    "on what you differentiate by: is there a `.detach()` or `.data` between them?",
    "that requires grad. Use": "you turn a tensor into numpy, which carries no gradient: stay in "
    "torch.",
    "can't multiply sequence": "torch.autograd.grad returns a tuple; take its first entry.",
    "but got tuple": "torch.autograd.grad returns a tuple; take its first entry.",
    "same dtype": "single and double precision are mixed: make your own tensors in the type of "
    "those you are given, as torch.zeros_like does.",
    "Double": "single and double precision are mixed: make your own tensors in the type of those "
    "you are given, as torch.zeros_like does.",
}


class Wrong(Exception):
    """A wrong answer, with the sentence that says so."""


def answered(check: Callable[[Student], None]) -> Callable[[Student], bool]:
    """Turn a check that raises Wrong into one that prints its verdict and returns it."""

    @functools.wraps(check)
    def verdict(student: Student) -> bool:
        mistake = _mistake(check, student)
        if mistake is not None:
            print(f"Not yet: {mistake}")
            return False
        print(f"Correct: {check.__name__.replace('_', ' ')}.")
        return True

    return verdict


def _mistake(check: Callable[[Student], None], student: Student) -> str | None:
    if not callable(student):
        return "hand over the function itself, its name without brackets."
    try:
        with limited(PATIENCE):
            check(student)
    except Wrong as wrong:
        return str(wrong)
    except TimeUp:
        return (
            f"your function had not ended after {PATIENCE:g} seconds: does every loop come to an "
            "end?"
        )
    except SystemExit:
        return "your function ends the whole program: let it return its answer instead."
    except Exception as error:
        return _told(error, student)
    return None


def _told(error: Exception, student: Student) -> str:
    """Return what an exception means; the line is the student's own, never the check's."""
    if isinstance(error, NotImplementedError) and not error.args:  # torch's has a message
        return "the function is still blank. Replace `raise NotImplementedError`."
    said = str(error)
    for words, meaning in _ENGINE.items():
        if words in said and isinstance(error, RuntimeError | TypeError):
            return meaning + _line(error, student)
    first = said.splitlines()[0][:200] if said else "no message"
    return f"your function stopped with {type(error).__name__}: {first}{_line(error, student)}"


def _line(error: Exception, student: Student) -> str:
    code = getattr(student, "__code__", None)
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if code is not None and frame.filename == code.co_filename]
    return f" (line: {own[-1].line})" if own and own[-1].line else ""

"""Guesses: a box to write one in before a result, and the answer beside it afterwards."""

from __future__ import annotations

from collections.abc import Sequence

import ipywidgets
from IPython.display import display

from ..validation import InputError


class GuessBox(ipywidgets.HBox):
    """A line to write a guess in, or a choice to make; where no kernel runs, a sentence stands for it."""

    def __init__(self, question: str, options: Sequence[str]) -> None:
        if options:
            self.entry = ipywidgets.ToggleButtons(options=options, value=None)
        else:
            self.entry = ipywidgets.Text(placeholder="your guess")
        self.entry.tooltip = question
        super().__init__(
            [ipywidgets.Label(f"{question}:"), self.entry],
            layout=ipywidgets.Layout(flex_flow="row wrap"),
        )

    def __repr__(self) -> str:
        return "[Where this notebook runs, a box for your guess stands here.]"


class Guesses:
    """What the reader guessed, by the name of the question; it is kept as soon as it is written."""

    def __init__(self) -> None:
        self.boxes: dict[str, GuessBox] = {}

    def ask(self, name: str, question: str, options: Sequence[str] = ()) -> None:
        """Show a box for the guess, of one line or of ``options``; a kept guess comes back in it."""
        box = GuessBox(question, options)
        if (before := self.of(name)) is not None and (not options or before in options):
            box.entry.value = before
        self.boxes[name] = box
        display(box)

    def of(self, name: str) -> str | None:
        """Return the guess as it was written, None where there is none."""
        written = self.boxes[name].entry.value if name in self.boxes else None
        return (written or "").strip() or None

    def reveal(self, name: str, answer: str) -> None:
        """Print the guess beside the answer; raises InputError for a question that was never asked."""
        if name not in self.boxes:
            raise InputError(f"guess: expected one of {sorted(self.boxes)}, got {name!r}")
        guess = self.of(name)
        print(f"You guessed: {guess if guess is not None else '(nothing yet)'}")
        print(f"It is:       {answer}")

"""A list of trainings to compare, what may be asked of it, and the sentences that few runs carry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from ..experiments.intervals import Interval

NOT_READ = "-"  # a setting that a training does not read differs from nothing
FIELDS = ("data", "w_rl", "w_bc", "warm start", "update", "optimiser", "sigma", "iterations")
_ROWS = {
    "P": ("optimal", 0.2, 1, "no", "RL", "TRPO", "learned", 150),
    "Q": ("optimal", 0.2, 0, "no", "RL", "TRPO", "learned", 150),
    "R": ("optimal", 0, 1, "no", "RL", "TRPO", "learned", 150),
    "S": ("optimal", 0.2, 1, "yes", "RL", "TRPO", "learned", 150),
    "T": (NOT_READ, 1, 0, "no", "RL", "TRPO", "learned", 150),
    "U": ("optimal", 0, 1, "no", "cloning", "Adam", "learned", 500),
    "V": ("optimal", 0, 1, "no", "cloning", "TRPO", "learned", 150),
    "W": ("sub-optimal", 1, 1, "no", "RL", "TRPO", "learned", 150),
    "X": ("sub-optimal", 1, 1, "yes", "RL", "TRPO", "fixed", 150),
}
TRAININGS: dict[str, dict[str, Any]] = {
    name: dict(zip(FIELDS, row, strict=True)) for name, row in _ROWS.items()
}


class Question(NamedTuple):
    """What an ablation asks: which setting may differ, and what else must hold."""

    text: str
    field: str
    data: str


QUESTIONS = {
    1: Question("What does cloning in the adaptation add, with optimal data?", "w_bc", "optimal"),
    2: Question(
        "What does cloning in the adaptation add, with sub-optimal data?", "w_bc", "sub-optimal"
    ),
    3: Question("Does it matter that the meta-update is RL, and not cloning?", "update", "optimal"),
    4: Question(
        "What does the warm start add, with sub-optimal data?", "warm start", "sub-optimal"
    ),
    5: Question("What does the warm start add, with optimal data?", "warm start", "optimal"),
}


def differing(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[str]:
    """Return the settings in which two trainings differ; one that is not read differs from nothing."""
    return [
        field
        for field in FIELDS
        if one[field] != other[field] and NOT_READ not in (one[field], other[field])
    ]


def answers(question: Question) -> list[set[str]]:
    """Return every pair of trainings that answers a question: they differ in its setting alone."""
    found = []
    for name, one in TRAININGS.items():
        for other_name, other in TRAININGS.items():
            shown = {one["data"], other["data"]} - {NOT_READ}
            ordered = name < other_name and shown == {question.data}
            if ordered and differing(one, other) == [question.field]:
                found.append({name, other_name})
    return found


def table() -> str:
    """Return the trainings as a table of plain text."""
    lines = ["".join(f"{word:>12}" for word in ("", *FIELDS))]
    for name, settings in TRAININGS.items():
        lines.append("".join(f"{value!s:>12}" for value in (name, *settings.values())))
    return "\n".join(lines)


SMALL_LOSS, LOSS = "a small loss", "a loss"
NO_LOSS, OPEN = "no loss that matters", "cannot say"


def which_sentence(
    rule: Callable[..., Interval], switched: np.ndarray, control: np.ndarray, worth: float
) -> str:
    """Return which sentence the runs carry about a loss, where one below ``worth`` does not matter."""
    gap = rule(switched, control)
    if gap.high < 0:
        return SMALL_LOSS if gap.low > -worth else LOSS
    return NO_LOSS if gap.low > -worth else OPEN


CASES = {1: (-2.6, 3.0), 2: (-11.0, -2.0), 3: (-9.0, 4.0), 4: (-3.4, -0.8)}


def case_rule(number: int) -> Callable[..., Interval]:
    """Return a rule that gives the interval of a case, with its sign turned where the sides are turned.

    The switched side is the one with the lower scores.
    """
    low, high = CASES[number]

    def rule(one: np.ndarray, other: np.ndarray) -> Interval:
        ends = (low, high) if np.mean(one) < np.mean(other) else (-high, -low)
        return Interval(sum(ends) / 2, *ends)

    return rule


def four_cases(worth: float = 5.0) -> Figure:
    """Return four intervals of a difference by their numbers, beside the losses that matter."""
    figure, axes = plt.subplots(figsize=(7.4, 2.4))
    axes.axvspan(-14, -worth, color="#D55E00", alpha=0.15, linewidth=0)
    axes.text(-13.8, 0.25, "losses that matter", color="#8A3A00", fontsize=9)
    axes.axvline(0, color="#777777", linewidth=1)
    for height, (low, high) in CASES.items():
        axes.plot([low, high], [height, height], color="black", linewidth=2, marker="|")
        axes.plot((low + high) / 2, height, "D", color="black", markersize=6)
    axes.set_yticks(list(CASES), [f"case {number}" for number in CASES])
    axes.set(
        xlim=(-14, 7), ylim=(4.5, -0.1), xlabel="return of the switched runs, less the control's"
    )
    axes.grid(axis="y", visible=False)
    return figure

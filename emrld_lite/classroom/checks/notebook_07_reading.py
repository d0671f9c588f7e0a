"""Checks of notebook 07: what a mean over tasks hides, and four curves to read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..made_up_curves import BROKE_DOWN, CLIMBING, FLAT_CURVE, IN_BOUNDS, trainings
from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number


class Tables(NamedTuple):
    """Tables (seed, task) of one size: with tasks that differ for every seed, and others."""

    split: np.ndarray
    """Half of the tasks are solved, by every seed the same ones."""
    few: np.ndarray
    """A quarter of the tasks, at least one, is missed by every seed."""
    alike: np.ndarray
    """Nothing but noise, as large as the spread of ``split``."""
    lost: np.ndarray
    """One seed has failed, in all tasks."""
    seeds: np.ndarray
    """Some seeds are good and some are bad, in all tasks."""


def _tables(random: np.random.Generator, seeds: int, tasks: int) -> Tables:
    noise = [random.normal(size=(seeds, tasks)) for _ in range(5)]
    up = np.arange(tasks) < tasks // 2
    missed = np.arange(tasks) < max(1, tasks // 4)
    seed = np.arange(seeds)[:, None]
    made = (
        10.0 * np.where(up, 1, -1) + 1.5 * noise[0],
        20.0 * np.where(missed, -1, 0) + 1.5 * noise[1],
        10.0 * noise[2],
        40.0 * np.where(seed == seeds - 1, -1, 0) + 1.5 * noise[3],
        14.0 * np.where(seed % 2 == 1, 1, -1) + 1.5 * noise[4],
    )
    order = random.permutation(tasks)
    return Tables(*(table[:, order] - table.mean() for table in made))


@answered
def hidden_by_mean(student: Student) -> None:
    """Check a number for f(table (seed, task)): large where every seed fails on the same tasks."""
    random = np.random.default_rng(81)
    for seeds, tasks in ((12, 8), (15, 5), (9, 2), (14, 20), (10, 6)):
        level = random.uniform(-60, 60)
        tables = _tables(random, seeds, tasks)
        found = {
            name: as_number(ask(student, table + level).answer, "a single number")
            for name, table in zip(Tables._fields, tables, strict=True)
        }
        moved = [
            as_number(ask(student, tables.alike + far).answer, "a single number")
            for far in (500.0, -500.0)
        ]
        _judge_hidden(found, max(moved))
        shuffled = random.permutation(tables.split.T).T[random.permutation(seeds)] + level
        again = as_number(ask(student, shuffled).answer, "a single number")
        if not np.isclose(again, found["split"], rtol=1e-4, atol=1e-6):
            raise Wrong("the order of tasks and seeds means nothing: your number must not change.")


def _judge_hidden(found: Mapping[str, float], moved: float) -> None:
    """Compare the numbers of the tables with each other; ``moved`` is that of noise far from zero."""
    hidden = min(found["split"], found["few"])
    if max(found.values()) - min(found.values()) < 1e-9:
        raise Wrong(
            "your number is the same for every table: is it a mean over all, which hides everything?"
        )
    if found["split"] < min(found["alike"], found["lost"], found["seeds"]) <= 0:
        raise Wrong(
            "your number is small where the tasks differ and large where they are alike: turn it round."
        )
    if max(found["lost"], found["seeds"]) >= hidden:
        raise Wrong(
            "a table with good and bad *seeds* gets as large a number as one with solved and missed "
            "*tasks*. What is common to all seeds of a task?"
        )
    if found["alike"] >= hidden:
        raise Wrong(
            "mere noise gets as large a number as tasks that every seed misses. Noise differs from "
            "seed to seed, so a mean over seeds removes most of it: take that first."
        )
    if moved >= hidden:
        raise Wrong(
            "the same noise at another level of return gets a larger number: only differences "
            "between tasks should count, not how high all of them are."
        )


@answered
def read_curves(student: Student) -> None:
    """Check a reading: f() -> {panel: (flat or climbing, in bounds or broke down)} of four panels."""
    reading = student()
    panels = trainings()
    if not isinstance(reading, Mapping) or set(reading) != set(panels):
        raise Wrong(f"return a dict with the keys {', '.join(panels)}.")
    for name, training in panels.items():
        said, truth = _pair(reading[name], name), training.truth
        if said[0] != truth[0]:
            raise Wrong(_misread(name, truth[0]))
        if said[1] != truth[1]:
            raise Wrong(_bounds(name, truth[1]))


def _pair(value: Any, name: str) -> tuple[str, str]:
    """Return an answer's two words; raise Wrong where they are others."""
    words = ((FLAT_CURVE, CLIMBING), (IN_BOUNDS, BROKE_DOWN))
    parts = list(value) if isinstance(value, tuple | list) else []
    if len(parts) != 2:
        raise Wrong(f"{name}: expected a pair of words, one for each row of the figure.")
    for part, allowed in zip(parts, words, strict=True):
        if part not in allowed:
            raise Wrong(f'{name}: expected "{allowed[0]}" or "{allowed[1]}", got {part!r}.')
    return parts[0], parts[1]


def _misread(name: str, truth: str) -> str:
    """Return what was overlooked in the upper panel."""
    if truth == FLAT_CURVE:
        return (
            f"{name}, above: it does not climb by the rule. Read the numbers on the axis, and divide the "
            "rise from the fourth fifth to the last by the level at the end."
        )
    return (
        f"{name}, above: it does climb. Judge it on its own level, not on the height of the panel: how "
        "far apart are the means of the last two fifths, as a share of the last?"
    )


def _bounds(name: str, truth: str) -> str:
    """Return what was overlooked in the lower panel."""
    if truth == BROKE_DOWN:
        return f"{name}, below: some updates moved the policies by far more than one nat. Look at the axis."
    return f"{name}, below: no update moved the policies by more than one nat."

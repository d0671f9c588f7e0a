"""Checks of notebook 08: clean comparisons, what runs say of a loss, and an experiment of one's own."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...config import TrainConfig
from ...experiments.intervals import Interval
from ...validation import InputError
from ..own_experiment import HIGHER, LONGEST, LOWER, NOT_SWITCHES, SAME, control_config
from ..plans import (
    LOSS,
    NO_LOSS,
    OPEN,
    QUESTIONS,
    SMALL_LOSS,
    TRAININGS,
    Question,
    answers,
    differing,
)
from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number


@answered
def clean_pairs(student: Student) -> None:
    """Check a plan: f() -> {question: a pair of trainings that differ in one setting, or None}."""
    plan = student()
    if not isinstance(plan, Mapping) or set(plan) != set(QUESTIONS):
        raise Wrong(
            f"return a dict with the questions {', '.join(map(str, QUESTIONS))} as its keys."
        )
    for number, question in QUESTIONS.items():
        _judge_pair(number, question, plan[number])


def _judge_pair(number: int, question: Question, value: Any) -> None:
    """Compare one answer; name what else differs between its two trainings."""
    clean = answers(question)
    if value is None:
        if clean:
            raise Wrong(
                f"question {number}: there is a pair that differs in this one setting alone."
            )
        return
    pair = list(value) if isinstance(value, tuple | list | set | str) else []
    if len(pair) != 2 or not all(name in TRAININGS for name in pair):
        raise Wrong(
            f"question {number}: expected the names of two trainings, as a pair of letters, or None."
        )
    if set(pair) in clean:
        return
    one, other = (TRAININGS[name] for name in pair)
    fields, sides = differing(one, other), " and ".join(pair)
    if not fields:
        raise Wrong(f"question {number}: {sides} do not differ at all.")
    if question.field not in fields:
        raise Wrong(f"question {number}: {sides} do not differ in what is asked for.")
    if len(fields) > 1:
        others = " and ".join(field for field in fields if field != question.field)
        raise Wrong(
            f"question {number}: {sides} differ in {others} as well, so nobody can say which of them "
            "did it."
        )
    raise Wrong(f"question {number}: {sides} do not answer it for {question.data} data.")


@answered
def which_sentence(student: Student) -> None:
    """Check f(rule, switched, control, worth) -> the sentence that the interval carries."""
    random = np.random.default_rng(82)
    seen = set()
    for low, high, worth in _ends(random):
        switched, control = random.normal(70, 5, 5), random.normal(70, 5, 4)
        asked: list[tuple[np.ndarray, np.ndarray]] = []

        def rule(one: Any, other: Any, low=low, high=high, asked=asked) -> Interval:
            asked.append((np.asarray(one, dtype=float), np.asarray(other, dtype=float)))
            turned = len(asked[-1][0]) < len(asked[-1][1])
            ends = (-high, -low) if turned else (low, high)
            return Interval(sum(ends) / 2, *ends)

        said = ask(student, rule, switched, control, worth).answer
        _judge_asked(asked, switched, control)
        _judge_sentence(said, low, high, worth)
        seen.add(said)
    if len(seen) < 4:
        raise Wrong("each of the four sentences is right in some case.")


def _ends(random: np.random.Generator) -> list[tuple[float, float, float]]:
    """Return ends of intervals, and what is a loss that matters: every case, at random places."""
    found = []
    for _ in range(4):
        worth = float(random.uniform(2, 8))
        small, large = worth * random.uniform(0.3, 0.9), worth * random.uniform(1.1, 3)
        gain = float(random.uniform(0.5, 20))
        cases = (
            (-small, -0.2 * small),
            (-large, -0.9 * worth),
            (-large, -0.1),
            (-2 * large, -large),
        )
        cases += (
            (-small, gain),
            (-small, 0.3),
            (-large, gain),
            (-large, 0.4),
            (0.5, 0.5 + gain),
            (large, large + gain),
        )
        found += [(float(low), float(high), worth) for low, high in cases]
    return found


def _judge_asked(
    asked: list[tuple[np.ndarray, np.ndarray]], switched: np.ndarray, control: np.ndarray
) -> None:
    """Raise Wrong unless the rule was asked about these scores."""
    if not asked:
        raise Wrong("you never ask the rule: the interval of the difference decides.")
    for one, other in asked:
        if not any(
            np.array_equal(one, left) and np.array_equal(other, right)
            for left, right in ((switched, control), (control, switched))
        ):
            raise Wrong("hand the rule the scores of both sides, all of them, as they are.")


def _judge_sentence(said: Any, low: float, high: float, worth: float) -> None:
    """Compare a sentence; name the mistake that leads to it."""
    words = (SMALL_LOSS, LOSS, NO_LOSS, OPEN)
    if said not in words:
        raise Wrong(f"return one of {', '.join(map(repr, words))}, got {said!r}.")
    lost, excluded = high < 0, low > -worth
    right = {(True, True): SMALL_LOSS, (True, False): LOSS, (False, True): NO_LOSS}
    expected = right.get((lost, excluded), OPEN)
    if said == expected:
        return
    told = f"for [{low:.1f}, {high:.1f}] where a loss of {worth:.1f} matters you say {said!r}: "
    if lost and said in (NO_LOSS, OPEN):
        raise Wrong(f"{told}a loss is shown, since the whole interval lies below zero.")
    if not lost and said in (SMALL_LOSS, LOSS):
        raise Wrong(f"{told}no loss is shown, since the interval reaches zero or lies above it.")
    if excluded:
        raise Wrong(f"{told}look at the lower end, beyond which any larger loss is excluded.")
    raise Wrong(f"{told}so large a loss is not excluded, since the lower end lies beyond it.")


@answered
def own_experiment(student: Student) -> None:
    """Check a design: f() -> {"switch", "expected", "seeds", "iterations"} that can be judged."""
    design = student()
    keys = {"switch", "expected", "seeds", "iterations"}
    if not isinstance(design, Mapping) or set(design) != keys:
        raise Wrong(f"return a dict with the keys {', '.join(sorted(keys))}.")
    iterations = as_number(design["iterations"], "the number of iterations")
    if iterations != int(iterations) or not 10 <= iterations <= 60:
        raise Wrong(
            "plan 10 to 60 iterations: in fewer nothing is learned, and more take too long here."
        )
    _judge_seeds(design["seeds"], int(iterations))
    _judge_switch(design["switch"], int(iterations))
    if design["expected"] not in (HIGHER, LOWER, SAME):
        raise Wrong(f'expected is one of "{HIGHER}", "{LOWER}" and "{SAME}".')


def _judge_seeds(seeds: Any, iterations: int) -> None:
    """Raise Wrong for seeds whose runs cannot be judged, or take too long."""
    if not isinstance(seeds, tuple | list | range | np.ndarray):
        raise Wrong("seeds is a tuple of whole numbers, one per training of each side.")
    numbers = [as_number(seed, "a seed as a whole number") for seed in seeds]
    if any(number != int(number) or number < 0 for number in numbers):
        raise Wrong("seeds are whole numbers, from 0 on.")
    if len(set(numbers)) < len(numbers):
        raise Wrong("the same seed twice is the same training twice: choose different ones.")
    if len(numbers) < 3:
        raise Wrong(
            f"with {len(numbers)} seeds of each side no order of the ranks is rare enough: three are "
            "the fewest that can be judged."
        )
    if 2 * len(numbers) * iterations > LONGEST:
        raise Wrong(
            f"two sides with {len(numbers)} seeds and {iterations} iterations are "
            f"{2 * len(numbers) * iterations} iterations in all: plan {LONGEST} at most, about two "
            "minutes."
        )


def _judge_switch(switch: Any, iterations: int) -> None:
    """Raise Wrong unless one setting differs from the control, and can be used."""
    control = control_config(iterations)
    if not isinstance(switch, Mapping) or not switch:
        raise Wrong('switch is a dict with one setting, such as {"discount": 0.9}.')
    if len(switch) > 1:
        raise Wrong("two settings change at once: nobody could say which of them did it.")
    ((name, value),) = switch.items()
    if name not in {field.name for field in dataclasses.fields(TrainConfig)}:
        raise Wrong(
            f"there is no setting {name!r}: `python -m emrld_lite train --help` lists them."
        )
    if name in NOT_SWITCHES:
        raise Wrong(f"{name}: {NOT_SWITCHES[name]}.")
    try:
        switched = dataclasses.replace(control, **switch)
    except InputError as error:
        raise Wrong(f"this setting cannot be used: {error}.") from error
    if switched == control or _as_before(control, name, value):
        raise Wrong(f"{name} is {value!r} in the control as well: nothing would change.")


def _as_before(control: TrainConfig, name: str, value: Any) -> bool:
    """Return whether a weight that is left to Table 1 gets the value that Table 1 has."""
    rule = control.adaptation("optimal")
    return name in ("w_rl", "w_bc") and value == getattr(rule, name)

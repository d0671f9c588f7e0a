"""Notebook 08: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import numpy as np

from emrld_lite.experiments.intervals import Interval

from .draw import Draw, Question, Questions


def _interval(draw: Draw) -> Question:
    reach = draw.between(0.5, 5)
    switched, control = draw.random.normal(70, 3, size=5), draw.random.normal(73, 3, size=4)

    def rule(one: np.ndarray, other: np.ndarray) -> Interval:
        gap = float(np.mean(one) - np.mean(other))
        return Interval(gap, gap - reach, gap + reach)

    return rule, switched, control, draw.between(1, 8)


MANY_ANSWERS = ("own_experiment",)  # a design
QUESTIONS: Questions = {"clean_pairs": lambda draw: (), "which_sentence": _interval}


def clean_pairs__letters():
    return {1: "PQ", 2: ["T", "W"], 3: ("V", "R"), 4: None, 5: {"S", "P"}}


def which_sentence__nested(rule, switched, control, worth):
    _, low, high = rule(switched, control)
    if low > -worth:
        return "no loss that matters" if high >= 0 else "a small loss"
    return "cannot say" if high >= 0 else "a loss"


def which_sentence__turned(rule, switched, control, worth):
    gain = rule(control, switched)
    words = {
        (True, True): "a small loss",
        (True, False): "a loss",
        (False, True): "no loss that matters",
        (False, False): "cannot say",
    }
    return words[gain.low > 0, gain.high < worth]


def own_experiment__episodes():
    return {
        "switch": {"episodes": 5},
        "expected": "lower",
        "seeds": range(4, 7),
        "iterations": np.int64(40),
    }


def own_experiment__weight():
    return {
        "iterations": 20,
        "seeds": [0, 1, 2, 3, 9],
        "expected": "higher",
        "switch": {"w_bc": 2.0},
    }


def own_experiment__sigma():
    return {
        "switch": {"learn_sigma": False},
        "expected": "no different",
        "seeds": (0, 1, 2),
        "iterations": 30,
    }

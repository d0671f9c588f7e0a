"""Notebook 07: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import numpy as np
import torch

from .draw import Draw, Question, Questions


def _scores(draw: Draw) -> np.ndarray:
    return draw.random.exponential(9, [(7,), (3,), (16,), (4, 5), (2, 9)][draw.whole(0, 5)])


def _rise(draw: Draw) -> Question:
    level = (0.0, 20.0)[draw.whole(0, 2)]
    return level + draw.random.normal(size=draw.whole(10, 60)), draw.between(1.0, 6.0)


MANY_ANSWERS = ("false_ahead_rate",)
QUESTIONS: Questions = {
    "interquartile_mean": lambda draw: (_scores(draw),),
    "late_rise": _rise,
}


def interquartile_mean__sorted(scores):
    ordered = sorted(float(score) for score in np.ravel(scores))
    cut = len(ordered) // 4
    return sum(ordered[cut : len(ordered) - cut]) / (len(ordered) - 2 * cut)


def interquartile_mean__single(scores):
    return np.float32(interquartile_mean__sorted(scores))


def interquartile_mean__array(scores):
    return np.array([interquartile_mean__sorted(scores)])


def interquartile_mean__tensor(scores):
    return torch.tensor(interquartile_mean__sorted(scores))


def late_rise__split(returns, floor):
    window = len(returns) // 5
    last, before = np.mean(returns[-window:]), np.mean(returns[-2 * window : -window])
    return np.float32((last - before) / np.maximum(last, floor))


def late_rise__tensor(returns, floor):
    window = len(returns) // 5
    pair = torch.as_tensor(returns[-2 * window :]).view(2, window).mean(1)
    return (pair[1:] - pair[:1]) / pair[1:].clamp_min(floor)


def false_ahead_rate__comprehension(rule, runs, pairs, random):
    draws = random.exponential(size=(pairs, 2, runs))
    return np.mean([rule(*pair).low > 0 for pair in draws])


def false_ahead_rate__lists(rule, runs, pairs, random):
    ahead = [
        rule([random.random() for _ in range(runs)], [random.random() for _ in range(runs)])
        for _ in range(pairs)
    ]
    return torch.tensor([float(interval.low > 0) for interval in ahead]).mean()

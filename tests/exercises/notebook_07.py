"""Notebook 07: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import torch

from .draw import Draw, Question, Questions


def _two_sides(draw: Draw) -> Question:
    runs, others, error = ((3, 3, 0.05), (4, 3, 0.12), (5, 4, 0.06), (2, 6, 0.08), (3, 5, 0.3))[
        draw.whole(0, 5)
    ]
    return draw.random.normal(size=runs), draw.random.exponential(size=others), error


# Two simulations, and a detector, which may be any function that tells the tables apart.
MANY_ANSWERS = ("false_ahead_rate", "seeds_needed", "hidden_by_mean")
QUESTIONS: Questions = {
    "rank_interval": _two_sides,
    "read_curves": lambda draw: (),
}


def rank_interval__by_wins(one, other, error):
    """Count wins of the first side, whose distribution is that of the losses."""
    ways = {(0, 0, 0): 1}
    for total in range(1, len(one) + len(other) + 1):
        for mine in range(max(0, total - len(other)), min(total, len(one)) + 1):
            theirs = total - mine
            for wins in range(len(one) * len(other) + 1):
                count = ways.get((mine - 1, theirs, wins - theirs), 0)
                ways[mine, theirs, wins] = count + ways.get((mine, theirs - 1, wins), 0)
    counts = [ways[len(one), len(other), wins] for wins in range(len(one) * len(other) + 1)]
    shares = np.cumsum(counts) / math.comb(len(one) + len(other), len(one))
    k = int((shares <= error + 1e-12).sum())
    differences = sorted(float(a - b) for a in one for b in other)
    return [torch.tensor(float(np.median(differences))), differences[k - 1], differences[-k]]


def rank_interval__all_orders(one, other, error):
    if len(one) + len(other) > 7:
        return rank_interval__by_wins(one, other, error)
    n, lost = len(one), []
    for order in permutations(range(n + len(other))):
        lost.append(sum(a < b for a in order[:n] for b in order[n:]))
    lost = np.sort(lost)
    k = 1
    while (lost <= k).mean() <= error:
        k += 1
    gaps = np.sort((one[:, None] - other[None]).ravel())
    return np.array([np.median(gaps), gaps[k - 1], gaps[len(gaps) - k]])


def seeds_needed__exponential(rule, gap, spread, chance, random):
    for number in range(3, 21):
        one, other = spread * random.exponential(size=(2, 500, number))
        ahead = sum(rule(list(a + gap), list(b)).low > 0 for a, b in zip(one, other, strict=True))
        if ahead >= chance * 500:
            return np.int64(number)
    return None


def seeds_needed__all_of_them(rule, gap, spread, chance, random):
    shares = []
    for number in range(3, 21):
        draws = random.normal(5, spread, size=(300, 2, number))
        shares.append(np.mean([rule(one + gap, other).low > 0 for one, other in draws]))
    enough = [number for number, share in enumerate(shares, start=3) if share >= chance]
    return torch.tensor(enough[0]) if enough else None


def hidden_by_mean__range(table):
    means = np.asarray(table).mean(axis=0)
    return torch.tensor(means.max() - means.min())


def hidden_by_mean__variance(table):
    return float(np.median(table, axis=0).var())


def hidden_by_mean__apart_from_seeds(table):
    rest = table - table.mean(1, keepdims=True)
    return np.float32(np.abs(rest.mean(0)).mean())


def read_curves__lists():
    return {name: [word, "broke down"] for name, word in (("C", "flat"), ("D", "climbing"))} | {
        name: [word, "in bounds"] for name, word in (("A", "flat"), ("B", "climbing"))
    }


def false_ahead_rate__comprehension(rule, runs, pairs, random):
    draws = random.exponential(size=(pairs, 2, runs))
    return np.mean([rule(*pair).low > 0 for pair in draws])


def false_ahead_rate__lists(rule, runs, pairs, random):
    ahead = [
        rule([random.random() for _ in range(runs)], [random.random() for _ in range(runs)])
        for _ in range(pairs)
    ]
    return torch.tensor([float(interval.low > 0) for interval in ahead]).mean()

"""Check of notebook 07: the interval of a difference by ranks."""

from __future__ import annotations

import numpy as np
import torch

from ...experiments.intervals import rank_of_ends
from ...validation import InputError
from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number, as_parts, close

# runs of each side, error: no share of the deals lies close to an error but for the first
DEALS = ((3, 3, 0.05), (5, 5, 0.05), (3, 4, 0.12), (4, 4, 0.2), (2, 5, 0.1), (5, 4, 0.05))


@answered
def rank_interval(student: Student) -> None:
    """Check f(one, other, error) -> (estimate, low, high) of the difference, by counting deals."""
    random = np.random.default_rng(76)
    for runs, others, error in DEALS:
        one = random.normal(random.uniform(-3, 3), 2.0, runs)
        other = random.exponential(3.0, others)
        answer = ask(student, one, other, error).answer
        parts = as_parts(answer, 3, "three numbers: estimate, low and high")
        names = ("the estimate", "the lower end", "the upper end")
        got = torch.tensor(
            [
                as_number(part, f"{name} as a number")
                for part, name in zip(parts, names, strict=True)
            ],
            dtype=torch.float64,
        )
        _judge_interval(got, one, other, error)


def _judge_interval(got: torch.Tensor, one: np.ndarray, other: np.ndarray, error: float) -> None:
    """Compare estimate, low and high; name the mistake that they equal."""
    gaps = np.sort(np.subtract.outer(one, other), axis=None)
    k = rank_of_ends(len(one), len(other), 1 - 2 * error)
    middle, mean = float(np.median(gaps)), float(one.mean() - other.mean())

    def at(rank: int, estimate: float = middle) -> torch.Tensor:
        rank = min(max(rank, 1), len(gaps))
        return torch.tensor([estimate, gaps[rank - 1], gaps[-rank]], dtype=torch.float64)

    right = at(k)
    if close(got, right):
        return
    if close(got[1:], right[1:]):
        raise Wrong(
            "the interval is right; the estimate is the median of all differences between a run of "
            "one side and a run of the other."
        )
    if close(-got[[0, 2, 1]], right):
        raise Wrong("the sign is turned: it is by how much `one` is better, so one less other.")
    if close(got[[0, 2, 1]], right):
        raise Wrong("low and high have changed places.")
    if close(got[1:], at(k + 1)[1:]):
        raise Wrong(
            "your interval is one difference too short at either end: it ends at the k-th from "
            "outside, and the k-th itself belongs to it."
        )
    if k > 1 and close(got[1:], at(k - 1)[1:]):
        raise Wrong(
            "your interval is one difference too long at either end: how large may k be so that "
            "*fewer than* k lost pairs are rare enough?"
        )
    halved = _rank_at(error / 2, len(one), len(other))
    if halved != k and close(got[1:], at(halved)[1:]):
        raise Wrong(
            '`error` is for each of the two verdicts, "ahead" and "behind": do not halve it.'
        )
    if k > 1 and close(got[1:], at(1)[1:]):
        raise Wrong(
            "that is the range of all differences: with this error the first side may lose some pairs. "
            "How many, you find by counting deals."
        )
    shares = np.quantile(gaps, [error, 1 - error])
    if close(got[1:], torch.as_tensor(shares)):
        raise Wrong(
            "that is a share of the differences; they are not independent of each other. Count deals "
            "of the ranks."
        )
    if close(got[:1], torch.tensor([mean], dtype=torch.float64)):
        raise Wrong("the estimate is the median of all differences, and the interval is off, too.")
    raise Wrong(
        f"for {len(one)} runs against {len(other)} and an error of {error:g} the interval is off: it "
        "reaches from the k-th smallest of all differences to the k-th largest."
    )


def _rank_at(error: float, one: int, other: int) -> int:
    """Return k for another error, 1 where not even that is rare enough."""
    try:
        return rank_of_ends(one, other, 1 - 2 * error)
    except InputError:
        return 1

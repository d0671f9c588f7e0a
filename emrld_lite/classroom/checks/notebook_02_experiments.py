"""Checks of notebook 02: a driver for the wheeled robot, and how far gradients agree."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number, as_parts, as_tensor, close, draws

V_LIMIT, OMEGA_LIMIT, TIME_STEP, BOX = 0.22, 2.84, 0.5, 0.2  # of the robot, appendix B
PATIENCE_STEPS = 30  # a driver that turns on the spot first needs 17 to 23 from two units away
SLACK = 1e-5  # single precision
ORIGIN = (0.0, 0.0, 0.0)


class Trip(NamedTuple):
    """Where a robot starts, and where it shall go."""

    start: tuple[float, float, float]
    goal: tuple[float, float]


def _trips() -> Iterator[Trip]:
    """Yield goals two units away in all directions; the later ones from elsewhere, headings unwrapped."""
    random = torch.Generator().manual_seed(22)
    for number in range(16):
        draw = torch.rand(4, generator=random, dtype=torch.float64).tolist()
        turn = 2 * math.pi * (number + draw[0]) / 16
        x, y, heading = ORIGIN
        if number % 2:
            x, y = 3 * draw[1] - 1.5, 3 * draw[2] - 1.5
            heading = (1 if number % 4 == 1 else -1) * (25 + 20 * draw[3])
        yield Trip((x, y, heading), (x + 2 * math.cos(turn), y + 2 * math.sin(turn)))


def _off(state: tuple[float, float, float], goal: tuple[float, float]) -> float:
    """Return how far the goal lies to the left of the robot's nose, the short way round, in radians."""
    x, y, heading = state
    return math.remainder(math.atan2(goal[1] - y, goal[0] - x) - heading, 2 * math.pi)


def _asked(
    student: Student, state: tuple[float, float, float], goal: tuple[float, float]
) -> tuple[float, float]:
    """Return the two velocities of an answer; raise Wrong where the robot cannot do them."""
    answer = ask(student, torch.tensor(state), torch.tensor(goal)).answer
    parts = as_parts(answer, 2, "two numbers: v and omega")
    v, omega = as_number(parts[0], "v as a number"), as_number(parts[1], "omega as a number")
    if not -SLACK <= v <= V_LIMIT + SLACK:
        raise Wrong(f"v must stay between 0 and 0.22; you ask for {v:.3g}.")
    if abs(omega) > OMEGA_LIMIT + SLACK:
        raise Wrong(f"omega must stay between -2.84 and 2.84; you ask for {omega:.3g}.")
    return v, omega


def _drive(student: Student, trip: Trip) -> tuple[int, float]:
    """Return the steps that the robot needs, one more than it has if it is lost, and how far it drove."""
    (x, y, heading), goal, driven = trip.start, trip.goal, 0.0
    for step in range(PATIENCE_STEPS):
        v, omega = _asked(student, (x, y, heading), goal)
        ahead = v * TIME_STEP
        x, y = x + ahead * math.cos(heading), y + ahead * math.sin(heading)
        heading, driven = heading + omega * TIME_STEP, driven + ahead
        if max(abs(x - goal[0]), abs(y - goal[1])) <= BOX:
            return step + 1, driven
    return PATIENCE_STEPS + 1, driven


@answered
def steer(student: Student) -> None:
    """Check the driver: f(state (3,), goal (2,)) -> (v, omega) reaches every goal within 30 steps."""
    lost = []
    for trip in _trips():
        steps, driven = _drive(student, trip)
        if steps > PATIENCE_STEPS:
            lost.append((trip, driven))
    if lost:
        raise Wrong(_lost(student, lost))


def _lost(student: Student, lost: list[tuple[Trip, float]]) -> str:
    """Return why robots did not arrive, from how far they drove and which way they turned first."""
    if all(driven == 0 for _, driven in lost):
        return "your robot never drives: v stays 0. Drive as soon as the nose points at the goal."
    if all(trip.start != ORIGIN for trip, _ in lost):
        return (
            "from the origin with heading 0 your robot arrives, from elsewhere it is lost: subtract "
            "the robot's own place and heading, and take the difference of two angles the short way "
            "round."
        )
    turns = [_asked(student, *trip)[1] * _off(*trip) for trip in _aside()]
    if not any(turns):
        return "your robot does not turn: omega stays 0 although the goal lies to the side."
    if max(turns) < 0:
        return "your robot turns away from its goal: a positive omega turns the nose to the left."
    if min(turns) < 0:
        return "from the origin your robot turns the wrong way: is it atan2(up, along), y first?"
    if max(driven for _, driven in lost) < 1.8:
        return (
            f"turned the right way, but too slow: after {PATIENCE_STEPS} steps a goal two units away "
            "is not reached. Drive at full speed once the nose is nearly right."
        )
    return "your robot misses its goal: it drives on while the nose points elsewhere."


def _aside() -> list[Trip]:
    """Return the trips from the origin whose goal lies clearly to one side."""
    aside = [trip for trip in _trips() if 0.3 < abs(_off(*trip)) < 2.6]
    return [trip for trip in aside if trip.start == ORIGIN]


@answered
def agreement(student: Student) -> None:
    """Check the agreement: f(gradients (batch, parameter)) -> mean cosine of two different batches."""
    cases = ((2, 9, torch.float64), (3, 4, torch.float32), (5, 30, torch.float64), (7, 2, None))
    for seed, (batches, size, dtype) in enumerate(cases, start=23):
        normal = draws(seed)
        lengths = (1.5 * normal(batches, 1)).exp()
        gradients = lengths * (normal(batches, size) + 0.7 * normal(size))
        gradients = gradients.to(dtype or torch.float32)
        got = as_tensor(ask(student, gradients).answer, (), "one number for all batches")
        _judge_agreement(got, gradients.double())


def _judge_agreement(got: torch.Tensor, gradients: torch.Tensor) -> None:
    """Compare the mean cosine; name the mistake that it equals."""
    count = len(gradients)
    units = gradients / gradients.norm(dim=1, keepdim=True)
    cosines, products = units @ units.T, gradients @ gradients.T
    apart = ~torch.eye(count, dtype=torch.bool)
    pairs = count * (count - 1)
    expected = cosines[apart].mean()
    if close(got, expected):
        return
    mean = gradients.mean(0)
    mistakes = {
        "a batch agrees perfectly with itself: leave those pairs out.": cosines.mean(),
        "products of gradients grow with their lengths: divide by both lengths.": (
            products[apart].mean()
        ),
        "keep the sign: two batches that point in opposite ways disagree.": (
            cosines[apart].abs().mean()
        ),
        "all pairs, not only a batch and the next one.": cosines.diagonal(1).mean(),
        "all pairs, not only those with the first batch.": cosines[0, 1:].mean(),
        "the mean over the pairs, not their sum.": cosines[apart].sum(),
        "the mean over the pairs, not their sum; each pair once.": cosines[apart].sum() / 2,
        "count the pairs: n batches have n (n - 1) / 2 of them.": cosines[apart].sum() / pairs / 2,
        "the mean of all batches contains each of them, so it agrees with them by itself.": (
            torch.cosine_similarity(gradients, mean[None], dim=1).mean()
        ),
        "that is the length of the mean direction: it contains each batch's pair with itself.": (
            units.mean(0).norm()
        ),
    }
    for sentence, mistaken in mistakes.items():
        if not close(expected, mistaken) and close(got, mistaken):
            raise Wrong(sentence)
    raise Wrong(f"for {count} batches expected {float(expected):.4f}, got {float(got):.4f}.")

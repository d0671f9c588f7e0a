"""Checks of notebook 02: the point, its reward, and the wait for it, in the environments' precision."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number, as_parts, as_tensor, judge

SINGLE = torch.float32
# Distances to the goal after the step, all clear of the two radii, 0.02 and 0.2.
AWAY = (0.0, 0.01, 0.015, 0.03, 0.06, 0.11, 0.15, 0.185, 0.23, 0.27, 0.4, 0.7, 0.95, 1.5, 4.0)
LOITERING = ((0, 1.0), (99, 1.0), (10, 0.95), (95, 0.5), (60, 1.0), (0, 0.9), (37, 0.99))
LENGTHS = (0.03, 0.09, 0.1000001, 0.16, 0.5, 0.0, 1.3)  # of a move


class Step(NamedTuple):
    """One question: what the point is given, and where it must be then."""

    position: torch.Tensor
    move: torch.Tensor
    goal: torch.Tensor
    time: int
    moved: torch.Tensor


def _steps() -> list[Step]:
    """Return steps in all directions that end at all distances from the goal."""
    random = torch.Generator().manual_seed(20)
    found = []
    for number, (away, length) in enumerate((a, b) for b in LENGTHS for a in AWAY):
        turn, side = (6.2832 * torch.rand(2, generator=random, dtype=torch.float64)).tolist()
        ahead = torch.tensor([math.cos(turn), math.sin(turn)], dtype=torch.float64)
        aside = torch.tensor([math.cos(side), math.sin(side)], dtype=torch.float64)
        position = torch.randn(2, generator=random, dtype=torch.float64)
        moved = position + min(length, 0.1) * ahead
        time = (0, 7, 42, 98, 99)[number % 5] if away < 0.02 else number % 100
        given = (part.to(SINGLE) for part in (position, length * ahead, moved + away * aside))
        found.append(Step(*given, time, moved))
        if number % 7 == 3:
            found[-1] = found[-1]._replace(time=99)
    return found


@answered
def point_step(student: Student) -> None:
    """Check Point2D: f(position, move, goal, time) -> (position, reward, done), one step."""
    for step in _steps():
        answer = ask(student, step.position, step.move, step.goal, step.time).answer
        got = as_parts(answer, 3, "three things: position, reward and done")
        _judge_place(as_tensor(got[0], (2,), "the new position"), step)
        reward = as_number(got[1], "the reward as a number")
        done = as_number(got[2], "True or False for done")
        _judge_reward(reward, bool(done), step)


def _judge_place(value: torch.Tensor, step: Step) -> None:
    """Compare the new position; name the mistake that it equals."""
    position, move = step.position.double(), step.move.double()
    short = step.moved - position
    length = float(move.norm())
    slip = torch.stack([position[0] + short[0], position[0] + short[1]])
    clipped = position + move.clamp(-0.1, 0.1)
    mistakes = {
        "y' = x + dy is the paper's slip of the pen; it is y + dy.": slip,
        "you clip dx and dy one by one; it is the length of the move that is limited.": clipped,
        "the new position is the old one plus the move, not minus it.": position - short,
        "that is the move alone: add it to the position.": short,
        "a move longer than 0.1 is shortened to 0.1, in the same direction.": position + move,
    }
    if 0 < length < 0.1:
        mistakes["a short move is made as it is; you stretch it to 0.1."] = (
            position + 0.1 / length * move
        )
    hint = "a short move is made as it is: the position plus (dx, dy)."
    if length > 0.1:
        hint = "a move longer than 0.1 is shortened to 0.1, in the same direction."
    judge(value, step.moved, mistakes, hint)


def _judge_reward(reward: float, done: bool, step: Step) -> None:
    """Compare the reward, then whether the episode ends; name the mistake."""
    goal = step.goal.double()
    away = float((goal - step.moved).norm())
    before = float((goal - step.position.double()).norm())
    left = 100 - step.time - 1
    expected = left if away < 0.02 else 1 - away if away < 0.2 else 0.0
    if abs(reward - expected) > 1e-4:
        raise Wrong(_reward_mistake(reward, away, before, left))
    if away < 0.02 and not done:
        raise Wrong("at the goal the episode ends: done is True.")
    if away > 0.02 and done:
        raise Wrong(
            "done is True too early: only within 0.02 of the goal does the step end the episode."
        )


def _reward_mistake(reward: float, away: float, before: float, left: int) -> str:
    """Return the sentence for a wrong reward."""
    old = left if before < 0.02 else 1 - before if before < 0.2 else 0.0
    if away < 0.02 and abs(reward - (1 - away)) < 1e-4:
        return "within 0.02 the point has arrived: the inner disc wins over the ring."
    if away < 0.02 and abs(abs(reward - left) - 1) < 1e-4:
        return "the remaining steps after the step of time t are 100 - t - 1."
    if abs(reward - old) < 1e-4:
        return "the distance is measured after the step, from the new position."
    if away < 0.02:
        return "within 0.02 the remaining steps, 100 - t - 1, are paid out."
    if away < 0.2:
        return "within 0.2 of the goal the reward is one minus the distance, as the crow flies."
    return "far from the goal, beyond 0.2, the reward is 0 and the episode goes on."


@answered
def loitering_gain(student: Student) -> None:
    """Check loitering: f(time, discount) -> reward of steps time to 99 at d = 0.02, less finishing now."""

    def waited(steps: int, discount: float, first: int = 0) -> float:
        return sum(0.98 * discount ** (first + k) for k in range(steps))

    for time, discount in LOITERING:
        left = 100 - time
        expected = waited(left, discount) - (left - 1)
        got = as_number(ask(student, time, discount).answer, "a number")
        if abs(got - expected) < 1e-6:
            continue
        if abs(got + expected) < 1e-6:
            raise Wrong("the sign is turned: loitering less finishing.")
        if abs(got - (waited(left, discount) - left)) < 1e-6:
            raise Wrong("finishing in step t pays 100 - t - 1.")
        if abs(got - (waited(left - 1, discount) - (left - 1))) < 1e-6:
            raise Wrong("there are 100 - t steps to loiter in: step 99 is one of them.")
        if abs(got - (waited(left, 1.0) - (left - 1))) < 1e-6:
            raise Wrong("the discount is missing.")
        if abs(got - (waited(left, discount, time) - (left - 1))) < 1e-6:
            raise Wrong("discount from step t on, not from the episode's start.")
        if abs(got - (waited(left, discount, 1) - (left - 1))) < 1e-6:
            raise Wrong("the first step's reward is not discounted.")
        raise Wrong(
            f"for t = {time} and a discount of {discount} expected {expected:.4f}, got {got:.4f}."
        )


@answered
def episodes_needed(student: Student) -> None:
    """Check waiting for a reward: f(rate, confidence) -> the smallest whole number of episodes."""
    for rate, confidence in (
        (0.02, 0.8),
        (0.1, 0.93),
        (0.5, 0.99),
        (0.001, 0.95),
        (0.5, 0.75),  # exactly two
        (0.3, 0.6),
        (0.9, 0.2),
    ):
        got = as_number(ask(student, rate, confidence).answer, "a whole number of episodes")
        _judge_waiting(got, rate, confidence)


def _judge_waiting(got: float, rate: float, confidence: float) -> None:
    """Compare the number of episodes; name the mistake that it equals."""
    missed = math.log(1 - rate)
    exact = math.log(1 - confidence) / missed
    expected = math.ceil(exact)
    if got == expected:
        return
    wrong = {
        math.ceil(confidence / rate): (
            "chances of several episodes do not add up: use (1 - rate)^episodes."
        ),
        math.ceil(1 / rate): (
            "1 / rate is the mean waiting time; it does not know the confidence."
        ),
        math.ceil(math.log(confidence) / missed): (
            "that is when no reward has probability `confidence`; take 1 - confidence."
        ),
        math.ceil(1 / exact): "the fraction is upside down: log(1 - confidence) / log(1 - rate).",
        math.floor(exact): "round up: with fewer episodes the confidence is not reached.",
        expected + 1: "one too many: the smallest number that reaches the confidence.",
        round(exact): "round up, not to the nearest.",
    }
    if got in wrong:
        raise Wrong(wrong[int(got)])
    if math.ceil(got) == expected:
        raise Wrong("episodes come whole: round up.")
    raise Wrong(
        f"for a rate of {rate} and a confidence of {confidence} expected {expected}, got {got:g}."
    )

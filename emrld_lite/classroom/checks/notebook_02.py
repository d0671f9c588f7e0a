"""Checks of notebook 02: sparse environments."""

from __future__ import annotations

import math

import torch

from .answers import Student, Wrong, answered, as_number, as_tensor, close, draws


@answered
def point_step(student: Student) -> None:
    """Check Point2D: f(position, move, goal, time) -> (position, reward, done), one step."""

    def ask(position: tuple, move: tuple, goal: tuple, time: int) -> tuple:
        given = [torch.tensor(values, dtype=torch.float64) for values in (position, move, goal)]
        kept = given[0].clone()
        got = student(*given, time)
        if not torch.equal(given[0], kept):
            raise Wrong("you changed the position you were given; return a new one.")
        if not isinstance(got, tuple) or len(got) != 3:
            raise Wrong(f"expected position, reward and done, got {type(got).__name__}.")
        return as_tensor(got[0], (2,), "the new position"), float(got[1]), bool(got[2])

    far = (5.0, 5.0)
    moved, reward, done = ask((0.3, -0.2), (0.05, 0.02), far, 0)
    if close(moved, torch.tensor([0.35, 0.32], dtype=torch.float64)) or close(
        moved, torch.tensor([0.35, 0.3 + 0.02], dtype=torch.float64)
    ):
        raise Wrong("y' = x + dy is the paper's slip of the pen; it is y + dy.")
    if not close(moved, torch.tensor([0.35, -0.18], dtype=torch.float64)):
        raise Wrong("a short move is made as it is: the position plus (dx, dy).")
    if reward != 0 or done:
        raise Wrong("far from the goal the reward is 0 and the episode goes on.")
    moved, *_ = ask((0.0, 0.0), (0.3, 0.4), far, 0)
    if close(moved, torch.tensor([0.1, 0.1], dtype=torch.float64)):
        raise Wrong("you clip dx and dy one by one; it is the length of the move that is limited.")
    if not close(moved, torch.tensor([0.06, 0.08], dtype=torch.float64)):
        raise Wrong("a move longer than 0.1 is shortened to 0.1, in the same direction.")
    moved, reward, done = ask((0.0, 0.0), (0.05, 0.0), (0.15, 0.0), 7)
    if abs(reward - 0.85) < 1e-9:
        raise Wrong("the distance is measured after the step, from the new position.")
    if abs(reward - 0.9) > 1e-9 or done:
        raise Wrong("within 0.2 of the goal the reward is one minus the distance.")
    moved, reward, done = ask((0.0, 0.0), (0.05, 0.0), (0.06, 0.0), 7)
    if abs(reward - 0.99) < 1e-9:
        raise Wrong("within 0.02 the second line of the formula wins: 100 - t - 1.")
    if abs(reward - 93) < 1e-9 or abs(reward - 91) < 1e-9:
        raise Wrong("the remaining steps after the step of time t are 100 - t - 1.")
    if abs(reward - 92) > 1e-9:
        raise Wrong("within 0.02 the remaining steps, 100 - t - 1, are paid out.")
    if not done:
        raise Wrong("at the goal the episode ends: done is True.")


@answered
def loitering_gain(student: Student) -> None:
    """Check loitering: f(time, discount) -> reward of steps time to 99 at d = 0.02, less finishing now."""

    def waited(steps: int, discount: float, first: int = 0) -> float:
        return sum(0.98 * discount ** (first + k) for k in range(steps))

    for time, discount in ((0, 1.0), (99, 1.0), (10, 0.95), (95, 0.5)):
        left = 100 - time
        expected = waited(left, discount) - (left - 1)
        got = as_number(student(time, discount), "a number")
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
def wheeled_step(student: Student) -> None:
    """Check the wheeled robot: f(state (..., 3), v, omega, dt) -> the next state."""
    normal = draws(21)
    state, v, omega, dt = normal(6, 3), normal(6).abs(), normal(6), 0.5
    got = as_tensor(
        student(state.clone(), v, omega, dt), (6, 3), "one state (x, y, heading) a robot"
    )
    x, y, heading = state.unbind(-1)

    def driven(angle: torch.Tensor, turn: torch.Tensor) -> torch.Tensor:
        ahead = v * dt
        parts = [x + ahead * torch.cos(angle), y + ahead * torch.sin(angle), heading + turn]
        return torch.stack(parts, dim=-1)

    if close(got, driven(heading, omega * dt)):
        return
    if close(got, driven(heading + omega * dt, omega * dt)):
        raise Wrong("drive with the old heading; the turn counts from the next step on.")
    if close(got, driven(heading, omega)):
        raise Wrong("the turn lasts dT too: omega dT.")
    if close(got, driven(math.pi / 2 - heading, omega * dt)):
        raise Wrong("sine and cosine are swapped: heading 0 looks along x.")
    if close(got[:, 2], heading + omega * dt):
        raise Wrong("the heading is right, the place is not: v dT along (cos, sin) of the heading.")
    raise Wrong("the numbers differ. Three lines: x + v cos dT, y + v sin dT, heading + omega dT.")


@answered
def episodes_needed(student: Student) -> None:
    """Check waiting for a reward: f(rate, confidence) -> the smallest whole number of episodes."""
    for rate, confidence in ((0.1, 0.9), (0.02, 0.5), (0.5, 0.99), (0.001, 0.95)):
        expected = math.ceil(math.log(1 - confidence) / math.log(1 - rate))
        got = student(rate, confidence)
        if isinstance(got, bool) or not isinstance(got, int | float):
            raise Wrong(f"expected a plain number of episodes, got {type(got).__name__}.")
        if got == expected:
            continue
        if got == math.ceil(confidence / rate):
            raise Wrong("chances of several episodes do not add up: use (1 - rate)^episodes.")
        if got == math.ceil(1 / rate):
            raise Wrong("1 / rate is the mean waiting time; it does not know the confidence.")
        if got == math.ceil(math.log(confidence) / math.log(1 - rate)):
            raise Wrong("that is when no reward has probability `confidence`; take 1 - confidence.")
        if math.ceil(got) == expected:
            raise Wrong("episodes come whole: round up.")
        raise Wrong(
            f"for a rate of {rate} and a confidence of {confidence} expected {expected}, got {got:g}."
        )

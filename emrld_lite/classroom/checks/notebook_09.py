"""Checks of notebook 09: a robot's place from its sensors, its wheels' speeds, and what a delay allows."""

from __future__ import annotations

import math

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_number, as_tensor, close, draws, judge

V_LIMIT, OMEGA_LIMIT = 0.15, 1.5  # of the policy, appendix B
V_MAX, OMEGA_MAX = 0.22, 2.84  # of the robot's firmware
WHEEL_RADIUS, HALF_TRACK = 0.033, 0.080  # metres
FULL_TURN = 2.0 * math.pi
SHARE = 0.02  # within which a largest gain is right: a bisection may stop there


@answered
def odometry(student: Student) -> None:
    """Check the odometry: f(angles (reading, 2), headings (reading,), radius) -> poses (reading, 3)."""
    for seed, (readings, dtype, radius) in enumerate(
        ((7, torch.float64, 0.033), (12, torch.float32, 0.05), (30, torch.float64, 0.021)), start=90
    ):
        normal = draws(seed)
        rolled = (0.6 + 0.3 * normal(readings, 2)).cumsum(0) + normal(1, 2)
        heading = (0.5 * normal(readings) + 0.35).cumsum(0) + 2.5  # crosses the half turn
        measured = torch.remainder(heading + math.pi, FULL_TURN) - math.pi
        asked = ask(student, rolled.to(dtype), measured.to(dtype), radius)
        got = as_tensor(asked.answer, (readings, 3), "x, y and heading at every reading")
        _judge_odometry(got, rolled.to(dtype).double(), measured.to(dtype).double(), radius)


def _judge_odometry(
    got: torch.Tensor, rolled: torch.Tensor, measured: torch.Tensor, radius: float
) -> None:
    """Compare the poses; name the mistake that they equal."""
    jumps = measured.diff()
    short = jumps - FULL_TURN * torch.round(jumps / FULL_TURN)
    far = radius * rolled.diff(dim=0).mean(-1)

    def poses(
        turned: torch.Tensor = short,
        driven: torch.Tensor = far,
        at: float = 0.5,
        start: float = 0.0,
    ) -> torch.Tensor:
        heading = torch.cat([torch.tensor([start]).double(), turned]).cumsum(0)
        along = heading[:-1] + at * turned
        steps = torch.stack([driven * along.cos(), driven * along.sin()], dim=-1)
        places = torch.cat([torch.zeros(1, 2).double(), steps]).cumsum(0)
        return torch.cat([places, heading[:, None]], dim=-1)

    expected, first = poses(), float(measured[0])
    mistakes = {
        "the heading jumps where the gyroscope's goes from a half turn to minus one: take each "
        "difference the short way round.": poses(turned=jumps),
        "the robot turns while it rolls: its way points along the heading in the middle of the two "
        "readings, not along the first.": poses(at=0.0),
        "the robot turns while it rolls: its way points along the heading in the middle of the two "
        "readings, not along the second.": poses(at=1.0),
        "the middle of the robot rolls as far as the mean of its wheels, not as their sum.": poses(
            driven=2 * far
        ),
        "that is the way of the left wheel alone.": poses(driven=radius * rolled.diff(dim=0)[:, 0]),
        "that is the way of the right wheel alone.": poses(
            driven=radius * rolled.diff(dim=0)[:, 1]
        ),
        "the radius is missing: an angle in radians times the radius is a length.": poses(
            driven=far / radius
        ),
        "a wheel rolls its radius times the angle in radians, without 2 pi.": poses(
            driven=FULL_TURN * far
        ),
        "the robot looks along x at its first reading: its heading there is 0.": poses(start=first),
        "sine and cosine are swapped.": expected[:, [1, 0, 2]],
        "y points to the wrong side.": expected * torch.tensor([1.0, -1.0, 1.0]).double(),
    }
    judge(
        got,
        expected,
        mistakes,
        "the poses differ. The first is 0, 0, 0; add up the ways between the readings.",
    )


@answered
def wheel_command(student: Student) -> None:
    """Check the command: f(action (2,), bias) -> speeds of the left and the right wheel, rad/s."""
    normal = draws(93)
    for number in range(24):
        action, bias = 1.4 * normal(2), float(1.2 * normal(1))
        if number % 2:
            action = action.float()
        got = as_tensor(
            ask(student, action, bias).answer, (2,), "two numbers: the left and the right wheel"
        )
        _judge_wheels(got, action.double(), bias)
    for broken in (math.nan, math.inf, -math.inf):
        for place in (0, 1):
            action = torch.tensor([0.3, 0.2])
            action[place] = broken
            _judge_stop(student, action)


def _judge_stop(student: Student, action: torch.Tensor) -> None:
    """Raise Wrong unless an action that is not finite stops the wheels."""
    answer = ask(student, action, 0.1).answer
    try:
        stands = close(as_tensor(answer, (2,), "two numbers"), torch.zeros(2).double())
    except Wrong:
        stands = False
    if not stands:
        raise Wrong(
            f"for the action {action.tolist()} both wheels must stop, bias and all: a command that "
            "is not finite is no command."
        )


def _judge_wheels(got: torch.Tensor, action: torch.Tensor, bias: float) -> None:
    """Compare the speeds of the wheels; name the mistake that they equal."""
    inside = action.clamp(-1.0, 1.0)

    def wheels(
        act: torch.Tensor = inside,
        turn: float = bias,
        firmware: bool = True,
        across: float = HALF_TRACK,
        radius: float = WHEEL_RADIUS,
        forward: bool = True,
    ) -> torch.Tensor:
        v = (act[0] + 1.0) * 0.5 * V_LIMIT if forward else act[0] * V_LIMIT
        omega = act[1] * OMEGA_LIMIT + turn
        if firmware:
            v, omega = v.clamp(-V_MAX, V_MAX), omega.clamp(-OMEGA_MAX, OMEGA_MAX)
        return torch.stack([v - across * omega, v + across * omega]) / radius

    expected = wheels()
    early = torch.stack([inside[0], inside[1] + bias / OMEGA_LIMIT]).clamp(-1.0, 1.0)
    mistakes = {
        "clip the action to -1 to 1 first.": wheels(act=action),
        "the bias is not part of the action: it comes on top of it, and only the firmware's limits "
        "hold for the sum.": wheels(act=early, turn=0.0),
        "the bias is missing: it is added to the angular velocity.": wheels(turn=0.0),
        "the bias must be added, not subtracted.": wheels(turn=-bias),
        "clamp what is sent, bias included, to the firmware's 0.22 m/s and 2.84 rad/s.": wheels(
            firmware=False
        ),
        "left and right are swapped: to turn left the right wheel is the faster.": expected.flip(0),
        "each wheel is half the track, 0.08 m, from the middle.": wheels(across=2 * HALF_TRACK),
        "that is the speed of the rim: divide by the wheel's radius for rad/s.": wheels(radius=1.0),
        "the action -1 means v = 0, and 1 means 0.15 m/s; this robot does not reverse.": wheels(
            forward=False
        ),
    }
    judge(
        got,
        expected,
        mistakes,
        f"for the action {[round(value, 3) for value in action.tolist()]} and the bias {bias:.3f} "
        f"expected {[round(value, 3) for value in expected.tolist()]}, got "
        f"{[round(value, 3) for value in got.tolist()]}.",
    )


def exact_largest_gain(delay_steps: int, time_step: float) -> float:
    """Return the gain at which an error neither dies out nor grows: 2 sin(pi / (2 (2 d + 1))) / dT.

    The roots of z^(d + 1) - z^d + g dT, of which the first pair meets the unit circle there.
    """
    return 2.0 * math.sin(0.5 * math.pi / (2 * delay_steps + 1)) / time_step


@answered
def largest_gain(student: Student) -> None:
    """Check the largest gain: f(delay_steps, time_step) -> rad/s per rad at which errors cease to die out."""
    for delay_steps, time_step in ((3, 0.3), (1, 0.2), (0, 0.7), (6, 0.1), (2, 0.5)):
        got = as_number(ask(student, delay_steps, time_step).answer, "a gain")
        expected = exact_largest_gain(delay_steps, time_step)
        if abs(got - expected) <= SHARE * expected:
            continue
        mistakes = {
            "that is g dT; divide by the time step.": expected * time_step,
            "that is g dT times dT: divide by the time step, do not multiply by it.": (
                expected * time_step**2
            ),
            "half of that is the gain that settles fastest; the question is for the largest that "
            "settles at all.": 0.5 * expected,
            "the delay is missing.": 2.0 / time_step if delay_steps else math.nan,
            "that is the gain for a delay of one step less.": exact_largest_gain(
                max(delay_steps - 1, 0), time_step
            ),
            "that is the gain for a delay of one step more.": exact_largest_gain(
                delay_steps + 1, time_step
            ),
            "that is the limit of small steps, pi / (2 delay): with steps of half a second it is off.": (
                0.5 * math.pi / (delay_steps * time_step) if delay_steps else math.nan
            ),
        }
        for sentence, mistaken in mistakes.items():
            if abs(got - mistaken) <= 0.5 * SHARE * abs(mistaken):
                raise Wrong(sentence)
        raise Wrong(
            f"for a delay of {delay_steps} steps of {time_step} s a gain of {got:.3f} "
            + ("lets the error grow." if got > expected else "is not the largest that settles.")
        )

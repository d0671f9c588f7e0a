"""Checks of notebook 03: demonstrations. All in single precision, as the stored data are."""

from __future__ import annotations

from collections import Counter

import torch

from ...demonstrations import Demonstrations
from .. import designs
from ..designs import ARRIVES, RUNS_PAST, STAYS
from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_parts, as_tensor, close, draws, judge

SINGLE = torch.float32


@answered
def with_task(student: Student) -> None:
    """Check goal conditioning: f(states (task, episode, state), tasks (task, n)) -> states with tasks."""
    for seed, (count, episodes, size, numbers) in enumerate(
        ((4, 3, 5, 2), (3, 6, 2, 1), (3, 3, 2, 3), (5, 1, 3, 2)), start=31
    ):
        normal = draws(seed, SINGLE)
        states, tasks = normal(count, episodes, size), normal(count, numbers)
        got = ask(student, states, tasks).answer
        if isinstance(got, torch.Tensor) and got.shape == (count, episodes, numbers):
            raise Wrong("that is the task alone; put it behind the state.")
        whole = (count, episodes, size + numbers)
        value = as_tensor(got, whole, "states with the task's numbers behind them")
        _judge_with_task(value, states.double(), tasks.double())


def _judge_with_task(value: torch.Tensor, states: torch.Tensor, tasks: torch.Tensor) -> None:
    """Compare the longer states; name the mistake that they equal."""
    count, episodes, size = states.shape
    spread = tasks[:, None].expand(count, episodes, tasks.shape[1])
    same = tasks[:1, None].expand_as(spread)
    if close(value[..., :size], states) and count > 1 and close(value[..., size:], same):
        raise Wrong("every task gets the same context; task i must see its own numbers.")
    mistakes = {
        "the paper appends: first the state, then the task.": (torch.cat([spread, states], dim=-1))
    }
    if count == episodes:
        mistakes["each episode sees another task: all episodes of task i see tasks[i]."] = (
            torch.cat([states, tasks[None].expand_as(spread)], dim=-1)
        )
    hint = "the numbers differ. Every episode of task i carries tasks[i] behind its state."
    judge(value, torch.cat([states, spread], dim=-1), mistakes, hint)


@answered
def steps_before_reward(student: Student) -> None:
    """Check the cut: f(distance (task, time), margin) -> first steps that all stay away, (task,)."""
    for seed, (count, horizon, margin) in enumerate(
        ((8, 6, 0.25), (20, 11, 0.5), (9, 3, 0.125), (3, 1, 0.25), (5, 5, 1.0)), start=32
    ):
        random = torch.Generator().manual_seed(seed)
        # Multiples of an eighth, so that some are exactly at the margin.
        distance = torch.randint(1, 13, (count, horizon), generator=random).to(SINGLE) / 8
        distance[0] = margin + 0.5  # never comes close
        distance[1, 0] = 0.0  # begins at the goal
        distance[2] = margin + 0.125
        distance[2, -1] = margin  # comes close in its last step
        got = ask(student, distance, margin).answer
        value = as_tensor(got, (count,), "one number of steps per task")
        _judge_cut(value, distance.double(), margin)


def _judge_cut(value: torch.Tensor, distance: torch.Tensor, margin: float) -> None:
    """Compare the numbers of steps; name the mistake that they equal."""

    def first(away: torch.Tensor) -> torch.Tensor:
        return away.long().cumprod(-1).sum(-1).double()

    far = distance > margin
    steps = first(far)
    mistakes = {
        "count only up to the first step that comes close; what follows is cut too.": (
            far.sum(-1).double()
        ),
        "at exactly the margin it has come too close: stay strictly beyond.": (
            first(distance >= margin)
        ),
        "the margin is missing.": first(distance > 0),
        "the step that comes close is itself cut: one too many.": steps + 1,
        "that is one step too few: the last step that stays away is kept.": steps - 1,
        "a trajectory that never comes close keeps all its steps.": far.double()
        .argmin(-1)
        .double(),
        "you count the steps that are close; count those before them.": first(~far),
        "you count from the end; count from the start on.": first(far.flip(-1)),
    }
    hint = "the numbers differ. How many steps from the start on stay beyond the margin?"
    judge(value, steps, mistakes, hint)


@answered
def nearest_distance(student: Student) -> None:
    """Check the distance to the data: f(states (n, d), data (m, d)) -> nearest distance, (n,)."""
    for seed, (count, points, size) in enumerate(
        ((6, 4, 3), (5, 9, 2), (3, 1, 4), (4, 4, 2)), start=33
    ):
        normal = draws(seed, SINGLE)
        states, data = 2 * normal(count, size), normal(points, size)
        got = ask(student, states, data).answer
        if isinstance(got, torch.Tensor) and got.shape == (count, points) != (count,):
            raise Wrong(
                "these are the distances to every data point; keep the smallest of each row."
            )
        value = as_tensor(got, (count,), "one distance per state")
        _judge_nearest(value, states.double(), data.double())


def _judge_nearest(value: torch.Tensor, states: torch.Tensor, data: torch.Tensor) -> None:
    """Compare the distances; name the mistake that they equal."""
    gaps = states[:, None] - data  # (n, m, d)
    every = gaps.square().sum(-1)
    mistakes = {
        "that is the squared distance; take the root.": every.min(1).values,
        "that is the mean distance to the data; the nearest point counts.": every.sqrt().mean(1),
        "that is the farthest point of the data.": every.max(1).values.sqrt(),
        "that is the distance to the centre of the data.": (states - data.mean(0)).norm(dim=-1),
        "add the squares of the differences, not their absolute values.": (
            gaps.abs().sum(-1).min(1).values
        ),
        "all differences count, not only the largest one.": gaps.abs().amax(-1).min(1).values,
        "that is the mean over dimensions; a distance adds the squares up.": (
            gaps.square().mean(-1).min(1).values.sqrt()
        ),
    }
    if len(states) == len(data):
        mistakes[
            "that is each data point's nearest state; take each state's nearest data point."
        ] = every.min(0).values.sqrt()
    hint = "the numbers differ. For each state: the smallest Euclidean distance to a data point."
    judge(value, every.min(1).values.sqrt(), mistakes, hint)


@answered
def misleading(student: Student) -> None:
    """Check the design: f(goal, walk) -> walks that all reach the goal, and how their copy fails."""
    random = torch.Generator().manual_seed(34)
    ends = []
    for angle in (
        0.4 + 0.3 * torch.rand(1, generator=random),
        1.7 + torch.rand(1, generator=random),
    ):
        goal = 2 * torch.cat([angle.cos(), angle.sin()])
        parts = as_parts(
            ask(student, goal, designs.walk).answer,
            2,
            "a list of walks and a prediction, two parts",
        )
        data, worst = _demonstrations(goal, parts[0])
        for width in (0.05, 0.1):
            ends.append(designs.outcome(goal, designs.averaging_copy(data, width), worst))
    _judge_prediction(parts[1], Counter(ends))


def _demonstrations(goal: torch.Tensor, walks: object) -> tuple[Demonstrations, float]:
    """Return the student's walks as data, with the smallest of their returns; all must reach the goal."""
    what = "a list of walks, each of shape (time, 2)"
    if isinstance(walks, torch.Tensor) and walks.dim() == 2:
        raise Wrong("put the walk into a list, [walk(...)], also where there is only one.")
    if not isinstance(walks, list | tuple | torch.Tensor) or not 1 <= len(walks) <= 4:
        raise Wrong(f"expected {what}, one to four of them.")
    taken, returns = [], []
    for number, actions in enumerate(walks, start=1):
        size = len(actions) if hasattr(actions, "__len__") else 0
        if size == 0:
            raise Wrong(f"expected {what}; walk {number} has no steps.")
        taken.append(as_tensor(actions, (size, 2), f"walk {number}, two numbers per step").float())
        played = designs.play(goal, taken[-1])
        if not played.reached:
            missed = float((played.states[-1] - goal).norm())
            raise Wrong(
                f"walk {number} does not reach its goal: it ends {missed:.2f} away after "
                f"{len(played.rewards)} steps, of which there are at most 100."
            )
        returns.append(played.total)
    if min(returns) < 10:
        raise Wrong("a walk arrives so late that it is paid hardly anything; make it shorter.")
    return designs.as_demonstrations(goal, taken), min(returns)


def _judge_prediction(prediction: object, ends: Counter[str]) -> None:
    """Compare the prediction with how the copies end."""
    if not isinstance(prediction, str) or prediction not in (STAYS, RUNS_PAST):
        raise Wrong(f'the prediction is one of "{STAYS}" and "{RUNS_PAST}".')
    total = ends.total()
    if ends[ARRIVES]:
        raise Wrong(
            f"the copy arrives in {ends[ARRIVES]} of {total} trials: it still finds the way. At which "
            "places does the average of the actions differ from where the demonstrator ends up?"
        )
    if len(ends) > 1:
        raise Wrong(
            f"the copy fails, but now in one way and now in the other ({STAYS} in {ends[STAYS]} of "
            f"{total} trials); make the design clearer."
        )
    if not ends[prediction]:
        raise Wrong(f"the copy fails, but not as you predicted: it {next(iter(ends))}.")

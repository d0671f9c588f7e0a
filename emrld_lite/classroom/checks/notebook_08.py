"""Checks of notebook 08: ablations and switches."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Any

import torch

from .answers import Student, Wrong, answered
from .calls import ask
from .values import as_graph, as_number, as_tensor, close, draws, judge, pulled_back

Settings = dict[str, Any]
PLANS: tuple[tuple[Settings, dict[str, Settings]], ...] = (
    (
        {"seed": 0, "w_bc": 1.0, "learn_sigma": True},
        {"no cloning": {"w_bc": 0.0}, "fixed sigma": {"learn_sigma": False}},
    ),
    (
        {"algorithm": "emrld", "alpha": 0.01},
        {
            "exact steps": {"step_rule": "exact"},  # a setting that the control leaves open
            "longer": {"alpha": 0.1, "iterations": 500},
            "another seed": {"seed": 3},
        },
    ),
    ({"a": 1}, {}),
)


@answered
def one_at_a_time(student: Student) -> None:
    """Check f(control, changes) -> {"control": ..., name: ...}: each run differs by its own change."""
    for control, changes in PLANS:
        got = ask(student, control, changes).answer
        if not isinstance(got, Mapping) or not all(
            isinstance(run, Mapping) for run in got.values()
        ):
            raise Wrong("return a dict: a name for each run, and its settings as a dict.")
        if changes and set(got) == set(changes):
            raise Wrong("the control is missing: without it there is nothing to compare with.")
        if set(got) != {"control", *changes}:
            raise Wrong(
                f"expected runs named {', '.join(map(repr, ('control', *changes)))}, got "
                f"{', '.join(map(repr, got))}."
            )
        if dict(got["control"]) != control:
            raise Wrong("the control was changed: copy its settings for every run.")
        for name, change in changes.items():
            _judge_run(dict(got[name]), control, change)


def _judge_run(run: Settings, control: Settings, change: Settings) -> None:
    """Compare one run's settings with the control's and its own change on top."""
    if run == control | change:
        return
    if run == change:
        raise Wrong("a run needs all settings: the control's, and its own change on top.")
    if run == change | control:
        raise Wrong("the control's settings overwrite the change: put the change on top.")
    if run == control | {key: new for key, new in change.items() if key in control}:
        raise Wrong("a change may set what the control leaves open: keep its new settings, too.")
    raise Wrong("more than one thing changes between a run and the control.")


Returns = dict[Hashable, float]
PAIRS: tuple[tuple[Returns, Returns], ...] = (
    ({2: 70.0, 0: 76.0, 1: 73.0}, {0: 71.0, 1: 75.0, 2: 60.0, 7: 99.0}),
    (
        {"3": 1.5, "12": -4.0, "5": 0.0, "4": 8.0},
        {"5": 3.0, "3": 0.0, "4": 9.5, "12": 2.0, "8": 1.0},
    ),
    ({9: 5.0, 4: 1.0}, {4: 2.0}),
    ({1: 5.0}, {2: 5.0}),
)


@answered
def seed_differences(student: Student) -> None:
    """Check f(control, switched), dicts seed -> return: switched less control for each common seed."""
    for control, switched in PAIRS:
        got = ask(student, control, switched).answer
        if not isinstance(got, Mapping):
            raise Wrong("return a dict, seed -> difference.")
        if not set(got) <= {*control, *switched}:
            raise Wrong("the keys must be the seeds.")
        lonely = set(got) - (set(control) & set(switched))
        if lonely:
            side = "control" if lonely & set(switched) else "switched run"
            raise Wrong(
                f"seed {min(lonely, key=str)} has no {side}: leave out seeds that only one side has."
            )
        expected = {seed: switched[seed] - control[seed] for seed in control if seed in switched}
        if set(got) != set(expected):
            names = [sorted(seeds, key=str) for seeds in (expected, got)]
            raise Wrong(f"expected the common seeds {names[0]}, got {names[1]}.")
        what = "each difference as a number"
        values = {seed: as_number(value, what) for seed, value in got.items()}
        _judge_differences(values, expected, control, switched)


def _judge_differences(
    values: Returns, expected: Returns, control: Returns, switched: Returns
) -> None:
    """Compare the differences; name the mistake that they equal."""

    def equal(other: Returns) -> bool:
        return all(
            math.isclose(values[s], other.get(s, math.nan), rel_tol=1e-5, abs_tol=1e-6)
            for s in values
        )

    if equal(expected):
        return
    if equal({seed: -value for seed, value in expected.items()}):
        raise Wrong("the sign is turned: a switch that helps must come out positive.")
    paired = zip(control.items(), switched.values(), strict=False)
    if equal({seed: new - old for (seed, old), new in paired}):
        raise Wrong("you paired by position: two runs belong together when their seeds agree.")
    mean = sum(control.values()) / len(control)
    common = sum(control[seed] for seed in expected) / max(len(expected), 1)
    for level in (mean, common):
        if equal({seed: switched[seed] - level for seed in expected}):
            raise Wrong("you compare with the mean: take the control of the same seed.")
    if equal({seed: abs(value) for seed, value in expected.items()}):
        raise Wrong("keep the sign: a switch that harms must come out negative.")
    raise Wrong("the numbers differ. For each common seed: switched[seed] - control[seed].")


@answered
def averaged_log_density(student: Student) -> None:
    """Check the released code's log-density: f(mean, sigma, action), (..., dim) -> mean over dim."""
    shapes = (((5, 3), (3,)), ((2, 4, 2), (2, 4, 2)), ((1, 1, 6, 2), (1, 1, 6, 2)), ((4, 4), (4,)))
    for seed, (shape, of_sigma) in enumerate(shapes, start=80):
        normal = draws(seed, torch.float32)
        mean, action = normal(*shape).requires_grad_(), normal(*shape)
        sigma = (0.1 + 1.2 * normal(*of_sigma).abs()).requires_grad_()
        asked = ask(student, mean, sigma, action)
        got = as_graph(asked.answer, shape[:-1], "one number for each action, over its dimensions")
        exact = [part.detach().double().requires_grad_() for part in (mean, sigma)]
        _judge_averaged(got, *exact, action.double())
        right = torch.distributions.Normal(*exact).log_prob(action.double()).mean(-1)
        weights = draws(seed + 100)(*shape[:-1])
        for leaf, own, name in zip(asked.given, exact, ("mean", "sigma"), strict=False):
            cut = f"right numbers, but without a gradient by {name}: is there a `.detach()` in it?"
            pulled = pulled_back(got, leaf, weights, cut)
            if not close(pulled, pulled_back(right, own, weights, cut), 1e-3):
                raise Wrong(
                    f"right numbers, but the gradient by the {name} is off: is a part detached?"
                )


def _judge_averaged(
    got: torch.Tensor, mean: torch.Tensor, sigma: torch.Tensor, action: torch.Tensor
) -> None:
    """Compare the averaged log-density; name the mistake that it equals."""
    each = torch.distributions.Normal(mean, sigma).log_prob(action).detach()  # (..., dim)
    spread = sigma.detach().expand_as(each)
    gap = (action - mean.detach()) / spread
    constant = 0.5 * math.log(2 * math.pi)
    mistakes = {
        "that is the joint log-density, the sum over dimensions: average them.": each.sum(-1),
        "you divide by two, but an action may have another number of dimensions.": (
            each.sum(-1) / 2
        ),
        "you divide by three, but an action may have another number of dimensions.": (
            each.sum(-1) / 3
        ),
        "log sigma is missing: a wider Gaussian is lower.": (each + spread.log()).mean(-1),
        "the constant -log(2 pi) / 2 is missing.": (each + constant).mean(-1),
        "you divide the squared distance by sigma; it is sigma squared.": (
            (-0.5 * gap**2 * spread - spread.log() - constant).mean(-1)
        ),
        "the half in front of the squared distance is missing.": (each - 0.5 * gap**2).mean(-1),
        "the sign of log sigma is turned: a wider Gaussian is lower.": (
            (each + 2 * spread.log()).mean(-1)
        ),
        "the squared distance lowers the density: its sign is turned.": (each + gap**2).mean(-1),
        "the sign is turned: that is minus the log-density.": -each.mean(-1),
    }
    hint = "the numbers differ. Log-density of each dimension, then the mean over the last axis."
    judge(as_tensor(got, each.shape[:-1], "numbers"), each.mean(-1), mistakes, hint)

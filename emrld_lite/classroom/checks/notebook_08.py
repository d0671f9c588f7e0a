"""Checks of notebook 08: ablations and switches."""

from __future__ import annotations

import math

import torch

from .answers import Student, Wrong, answered, as_number, as_tensor, close, draws


@answered
def one_at_a_time(student: Student) -> None:
    """Check f(control, changes) -> {"control": ..., name: ...}: each run differs by its own change."""
    control = {"seed": 0, "w_bc": 1.0, "learn_sigma": True}
    changes = {"no cloning": {"w_bc": 0.0}, "fixed sigma": {"learn_sigma": False}}
    got = student(dict(control), {name: dict(change) for name, change in changes.items()})
    if not isinstance(got, dict) or not all(isinstance(run, dict) for run in got.values()):
        raise Wrong("return a dict: a name for each run, and its settings as a dict.")
    if set(got) == set(changes):
        raise Wrong("the control is missing: without it there is nothing to compare with.")
    if set(got) != {"control", *changes}:
        raise Wrong(f"expected runs named 'control', {', '.join(map(repr, changes))}.")
    if got["control"] != control:
        raise Wrong("the control was changed: copy its settings for every run.")
    for name, change in changes.items():
        if got[name] == control | change:
            continue
        if got[name] == change:
            raise Wrong("a run needs all settings: the control's, and its own change on top.")
        if got[name] == change | control:
            raise Wrong("the control's settings overwrite the change: put the change on top.")
        raise Wrong("more than one thing changes between a run and the control.")


@answered
def seed_differences(student: Student) -> None:
    """Check f(control, switched), dicts seed -> return: switched less control for each common seed."""
    control = {2: 70.0, 0: 76.0, 1: 73.0}
    switched = {0: 71.0, 1: 75.0, 2: 60.0, 7: 99.0}
    got = student(dict(control), dict(switched))
    if not isinstance(got, dict):
        raise Wrong("return a dict, seed -> difference.")
    if not set(got) <= {*control, *switched}:
        raise Wrong("the keys must be the seeds.")
    if 7 in got:
        raise Wrong("seed 7 has no control: leave out seeds that only one side has.")
    expected = {seed: switched[seed] - control[seed] for seed in control}
    if set(got) != set(expected):
        raise Wrong(f"expected the common seeds {sorted(expected)}, got {sorted(got)}.")
    values = {seed: as_number(value, "each difference as a number") for seed, value in got.items()}
    if all(math.isclose(values[seed], expected[seed]) for seed in expected):
        return
    if all(math.isclose(values[seed], -expected[seed]) for seed in expected):
        raise Wrong("the sign is turned: a switch that helps must come out positive.")
    paired = dict(zip(control, switched, strict=False))
    if all(math.isclose(values[s], switched[paired[s]] - control[s]) for s in control):
        raise Wrong("you paired by position: two runs belong together when their seeds agree.")
    mean = sum(control.values()) / 3
    if all(math.isclose(values[seed], switched[seed] - mean) for seed in expected):
        raise Wrong("you compare with the mean: take the control of the same seed.")
    raise Wrong("the numbers differ. For each common seed: switched[seed] - control[seed].")


@answered
def averaged_log_density(student: Student) -> None:
    """Check the released code's log-density: f(mean, sigma, action), (..., dim) -> mean over dim."""
    normal = draws(80)
    mean = normal(5, 3).requires_grad_()
    sigma, action = 0.5 + normal(3).abs(), normal(5, 3)
    got = as_tensor(student(mean, sigma, action), (5,), "a number for each of the five actions")
    each = torch.distributions.Normal(mean.detach(), sigma).log_prob(action)  # (5, 3)
    if close(got, each.mean(-1)):
        return
    if close(got, each.sum(-1)):
        raise Wrong("that is the joint log-density, the sum over dimensions: average them.")
    if close(got, each.sum(-1) / 2):
        raise Wrong("you divide by two, but an action may have another number of dimensions.")
    if close(got, (each + sigma.log()).mean(-1)):
        raise Wrong("log sigma is missing: a wider Gaussian is lower.")
    if close(got, (each + 0.5 * math.log(2 * math.pi)).mean(-1)):
        raise Wrong("the constant -log(2 pi) / 2 is missing.")
    raise Wrong(
        "the numbers differ. Log-density of each dimension, then the mean over the last axis."
    )

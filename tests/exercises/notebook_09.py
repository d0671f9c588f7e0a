"""Notebook 09: random questions for its exercises, and right answers in other styles and types."""

from __future__ import annotations

import math

import numpy as np
import torch

from emrld_lite import adapt as adaptation

from .draw import Draw, Question, Questions


def _odometry(draw: Draw) -> Question:
    readings = draw.whole(2, 20)
    heading = (0.6 * draw.normal(readings) + 0.3).cumsum(0)
    measured = torch.remainder(heading + math.pi, 2 * math.pi) - math.pi
    return draw.normal(readings, 2).cumsum(0), measured, draw.between(0.01, 0.1)


def _wheel_command(draw: Draw) -> Question:
    action, bias = 1.5 * draw.normal(2), 1.5 * float(draw.normal(1))
    if draw.whole(0, 4) == 0:
        action[draw.whole(0, 2)] = (math.nan, math.inf, -math.inf)[draw.whole(0, 3)]
    return action, bias


QUESTIONS: Questions = {
    "odometry": _odometry,
    "wheel_command": _wheel_command,
}
MANY_ANSWERS = {"largest_gain", "one_adaptation"}


def odometry__loop(angles, headings, radius):
    x = y = heading = 0.0
    poses = [[x, y, heading]]
    for before, now, old, new in zip(
        angles[:-1].tolist(),
        angles[1:].tolist(),
        headings[:-1].tolist(),
        headings[1:].tolist(),
        strict=True,
    ):
        turned = math.remainder(new - old, 2 * math.pi)
        driven = radius * (now[0] - before[0] + now[1] - before[1]) / 2
        x += driven * math.cos(heading + turned / 2)
        y += driven * math.sin(heading + turned / 2)
        heading += turned
        poses.append([x, y, heading])
    return poses


def odometry__numpy(angles, headings, radius):
    heading = np.unwrap(headings.numpy())
    heading = heading - heading[0]
    driven = radius * np.diff(angles.numpy(), axis=0).mean(1)
    middle = (heading[1:] + heading[:-1]) / 2
    ways = np.stack([driven * np.cos(middle), driven * np.sin(middle)], 1)
    return np.concatenate([np.concatenate([[[0, 0]], ways.cumsum(0)]), heading[:, None]], 1)


def wheel_command__numpy(action, bias):
    action = action.double().numpy()
    if not np.isfinite(action).all():
        return np.zeros(2)
    v = np.clip((np.clip(action[0], -1, 1) + 1) * 0.075, -0.22, 0.22)
    omega = np.clip(np.clip(action[1], -1, 1) * 1.5 + bias, -2.84, 2.84)
    return np.array([v - 0.08 * omega, v + 0.08 * omega]) / 0.033


def wheel_command__plain(action, bias):
    a, b = (float(part) for part in action)
    if not (math.isfinite(a) and math.isfinite(b)):
        return [0, 0]
    v = 0.15 * (min(max(a, -1), 1) + 1) / 2
    turn = 0.08 * min(max(1.5 * min(max(b, -1), 1) + bias, -2.84), 2.84)
    return [(v - turn) / 0.033, (v + turn) / 0.033]


def largest_gain__bisection(delay_steps, time_step):
    low, high = 0.0, 4.0 / time_step
    for _ in range(40):
        gain = (low + high) / 2
        roots = np.roots(
            [1, -1, *[0] * (delay_steps - 1), gain * time_step]
            if delay_steps
            else [1, gain * time_step - 1]
        )
        low, high = (gain, high) if np.abs(roots).max() < 1 else (low, gain)
    return low


def largest_gain__simulation(delay_steps, time_step):
    def settles(gain):
        errors = [1.0] * (delay_steps + 1)
        for _ in range(3000):
            errors.append(errors[-1] - gain * time_step * errors[-1 - delay_steps])
            if abs(errors[-1]) > 1e6:
                return False
        return max(map(abs, errors[-50:])) < 1.0

    low, high = 0.0, 3.0 / time_step
    while high - low > 1e-3 / time_step:
        middle = (low + high) / 2
        low, high = (middle, high) if settles(middle) else (low, middle)
    return torch.tensor(low)


def one_adaptation__one_line(meta_params, drive, demonstration, rule, score):
    start = adaptation.warm_start(meta_params, demonstration, rule)
    return adaptation.adapt(meta_params, score(drive(start, 5)), demonstration, rule)


def one_adaptation__only_where_it_is_warm(meta_params, drive, demonstration, rule, score):
    driver = (
        adaptation.warm_start(meta_params, demonstration, rule) if rule.warm_start else meta_params
    )
    return adaptation.adapt(meta_params, score(drive(driver, 5)), demonstration, rule)

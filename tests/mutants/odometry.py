import math

import torch


def _poses(angles, headings, radius, unwrap=True, at=0.5, ways="mean", start=True):
    turned = headings.diff()
    if unwrap:
        turned = torch.remainder(turned + math.pi, 2 * math.pi) - math.pi
    rolled = radius * angles.diff(dim=0)
    driven = {"mean": rolled.mean(-1), "sum": rolled.sum(-1), "left": rolled[:, 0]}[ways]
    first = headings.new_zeros(1) if start else headings[:1]
    heading = torch.cat([first, turned]).cumsum(0)
    along = heading[:-1] + at * turned
    steps = torch.stack([driven * along.cos(), driven * along.sin()], -1)
    places = torch.cat([steps.new_zeros(1, 2), steps]).cumsum(0)
    return torch.cat([places, heading[:, None]], -1)


def jumps(angles, headings, radius):
    """the short way round"""
    return _poses(angles, headings, radius, unwrap=False)


def first_heading(angles, headings, radius):
    """not along the first"""
    return _poses(angles, headings, radius, at=0.0)


def second_heading(angles, headings, radius):
    """not along the second"""
    return _poses(angles, headings, radius, at=1.0)


def sum_of_wheels(angles, headings, radius):
    """mean of its wheels"""
    return _poses(angles, headings, radius, ways="sum")


def one_wheel(angles, headings, radius):
    """left wheel alone"""
    return _poses(angles, headings, radius, ways="left")


def no_radius(angles, headings, radius):
    """radius is missing"""
    return _poses(angles, headings, 1.0)


def degrees(angles, headings, radius):
    """without 2 pi"""
    return _poses(angles, headings, 2 * math.pi * radius)


def keeps_the_first_heading(angles, headings, radius):
    """looks along x at its first reading"""
    return _poses(angles, headings, radius, start=False)


def swapped(angles, headings, radius):
    """swapped"""
    return _poses(angles, headings, radius)[:, [1, 0, 2]]


def one_reading_less(angles, headings, radius):
    """expected x, y and heading at every reading"""
    return _poses(angles, headings, radius)[1:]

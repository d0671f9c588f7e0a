"""The environments by name, batched for the algorithms and registered for everyone else.

>>> environment = make("point2d")
>>> import gymnasium
>>> single = gymnasium.make("emrld_lite/Point2D-v0")
"""

from __future__ import annotations

from dataclasses import fields

import gymnasium

from ..validation import known, lookup
from .base import Environment, Transition
from .half_cheetah import HalfCheetahForwardBackward
from .point2d import Point2D
from .shell import SingleEpisode
from .two_wheeled import TwoWheeled, TwoWheeledDrift

__all__ = ["ENVIRONMENTS", "Environment", "SingleEpisode", "Transition", "make"]

ENVIRONMENTS: dict[str, type[Environment]] = {
    "point2d": Point2D,
    "two_wheeled": TwoWheeled,
    "half_cheetah": HalfCheetahForwardBackward,
    "two_wheeled_drift": TwoWheeledDrift,
}
GYMNASIUM_IDS = {
    "point2d": "emrld_lite/Point2D-v0",
    "two_wheeled": "emrld_lite/TwoWheeled-v0",
    "half_cheetah": "emrld_lite/HalfCheetahForwardBackward-v0",
    "two_wheeled_drift": "emrld_lite/TwoWheeledDrift-v0",
}


def make(name: str, **options: str) -> Environment:
    """Return the batched environment called ``name``; an unknown name or option raises InputError."""
    family = lookup("environment", name, ENVIRONMENTS)
    allowed = [field.name for field in fields(family)]
    for option in options:
        known(f"option of {name}", option, allowed)
    return family(**options)


def single_episode(name: str, render_mode: str | None = None, **options: str) -> SingleEpisode:
    """Return the environment called ``name`` as a ``gymnasium.Env``; what ``gymnasium.make`` calls."""
    return SingleEpisode(make(name, **options), render_mode)


for _name, _id in GYMNASIUM_IDS.items():
    if _id not in gymnasium.registry:
        gymnasium.register(id=_id, entry_point=single_episode, kwargs={"name": _name})

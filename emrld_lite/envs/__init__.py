"""The environments by name, batched for the algorithms and registered for everyone else.

>>> environment = make("point2d")
>>> import gymnasium
>>> single = gymnasium.make("emrld_lite/Point2D-v0")
"""

from __future__ import annotations

import gymnasium

from ..validation import lookup
from .base import Environment, Transition
from .point2d import Point2D
from .shell import SingleEpisode

__all__ = ["ENVIRONMENTS", "Environment", "SingleEpisode", "Transition", "make"]

ENVIRONMENTS: dict[str, type[Environment]] = {"point2d": Point2D}
GYMNASIUM_IDS = {"point2d": "emrld_lite/Point2D-v0"}


def make(name: str, **options: str) -> Environment:
    """Return the batched environment called ``name``; an unknown name raises InputError."""
    return lookup("environment", name, ENVIRONMENTS)(**options)


def single_episode(name: str, **options: str) -> SingleEpisode:
    """Return the environment called ``name`` as a ``gymnasium.Env``; what ``gymnasium.make`` calls."""
    return SingleEpisode(make(name, **options))


for _name, _id in GYMNASIUM_IDS.items():
    if _id not in gymnasium.registry:
        gymnasium.register(id=_id, entry_point=single_episode, kwargs={"name": _name})

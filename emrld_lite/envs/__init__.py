"""The environments by name, batched for the algorithms; the package registers them for everyone else.

Each is imported when it is first made, so that only the cheetah and the robot load MuJoCo.

>>> environment = make("point2d")
>>> import emrld_lite, gymnasium
>>> single = gymnasium.make("emrld_lite/Point2D-v0")
"""

from __future__ import annotations

import importlib
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from .. import GYMNASIUM_IDS
from ..validation import check_choice, lookup
from .base import Environment, Transition

if TYPE_CHECKING:
    from .gymnasium_env import SingleEpisode

__all__ = ["ENVIRONMENTS", "GYMNASIUM_IDS", "ROBOTS", "Environment", "Transition", "family", "make"]

ENVIRONMENTS = {  # name: module and class
    "point2d": ("point2d", "Point2D"),
    "two_wheeled": ("two_wheeled", "TwoWheeled"),
    "half_cheetah": ("half_cheetah", "HalfCheetahForwardBackward"),
    "two_wheeled_drift": ("two_wheeled_drift", "TwoWheeledDrift"),
    "two_wheeled_literal_drift": ("two_wheeled_drift", "TwoWheeledLiteralDrift"),
}

ROBOTS = {"turtlebot": ("turtlebot", "TurtleBot")}  # to drive, not to train in


def family(name: str) -> type[Environment]:
    """Return the class of the environment called ``name``; an unknown name raises InputError."""
    module, cls = lookup("environment", name, ENVIRONMENTS | ROBOTS)
    return getattr(importlib.import_module(f".{module}", __name__), cls)


def make(name: str, **options: Any) -> Environment:
    """Return the batched environment called ``name``; an unknown name or option raises InputError."""
    chosen = family(name)
    allowed = [field.name for field in fields(chosen)]
    for option in options:
        check_choice(f"option of {name}", option, allowed)
    return chosen(**options)


def single_episode(name: str, render_mode: str | None = None, **options: Any) -> SingleEpisode:
    """Return the environment called ``name`` as a ``gymnasium.Env``; what ``gymnasium.make`` calls."""
    module = importlib.import_module(".gymnasium_env", __name__)
    return module.SingleEpisode(make(name, **options), render_mode)

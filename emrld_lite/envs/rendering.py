"""MuJoCo's own pictures, where a GL library can make them."""

from __future__ import annotations

import functools
import logging
import os
import sys

import mujoco
import numpy as np
from jaxtyping import UInt8

logger = logging.getLogger(__name__)

SIZE = 480  # pixels, either way


@functools.cache
def renderer(model: mujoco.MjModel) -> mujoco.Renderer | None:
    """Return MuJoCo's renderer, or None (and an info in the log) where there is no GL library for it.

    Without a screen, OSMesa or EGL and MUJOCO_GL=osmesa or egl before Python starts make one.
    """
    windowed = os.environ.get("MUJOCO_GL", "glfw") == "glfw"
    screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform == "linux" and windowed and not screen:
        logger.info("no screen for MuJoCo's pictures: matplotlib draws instead")
        return None
    try:
        return mujoco.Renderer(model, SIZE, SIZE)
    except Exception as error:  # each GL library fails with errors of its own
        logger.info("no GL library for MuJoCo (%s): matplotlib draws instead", error)
        return None


def picture(
    model: mujoco.MjModel, data: mujoco.MjData, camera: str
) -> UInt8[np.ndarray, "height width 3"] | None:
    """Return what ``camera`` sees of a simulation, or None where MuJoCo cannot draw."""
    maker = renderer(model)
    if maker is None:
        return None
    maker.update_scene(data, camera=camera)
    return maker.render().copy()

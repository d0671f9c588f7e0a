"""The cheetah's body: its MuJoCo model, its capsules for drawing, and MuJoCo's own pictures of it."""

from __future__ import annotations

import functools
import logging
from pathlib import Path

import gymnasium
import mujoco
import numpy as np
from jaxtyping import Float
from torch import Tensor

from .rendering import picture

logger = logging.getLogger(__name__)


@functools.cache
def cheetah_model() -> mujoco.MjModel:
    """Return Gymnasium's HalfCheetah as a MuJoCo model; its warnings go to ``logging``."""
    mujoco.set_mju_user_warning(lambda text: logger.info("mujoco: %s", text))
    folder = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
    return mujoco.MjModel.from_xml_path(str(folder / "half_cheetah.xml"))


def full_state(
    state: Float[Tensor, " 20"],
) -> tuple[Float[np.ndarray, " 9"], Float[np.ndarray, " 9"]]:
    """Return qpos and qvel from an observation."""
    values = state.double().numpy()
    return np.concatenate([values[17:18], values[:8]]), values[8:17]


def posed(state: Float[Tensor, " 20"]) -> mujoco.MjData:
    """Return a simulation in the pose of an observation."""
    data = mujoco.MjData(cheetah_model())
    data.qpos[:], data.qvel[:] = full_state(state)
    mujoco.mj_forward(cheetah_model(), data)
    return data


def capsules(state: Float[Tensor, " 20"]) -> list[tuple[Float[np.ndarray, "end xz"], float]]:
    """Return the body's capsules as their ends and radii, metres, from an observation."""
    model, data = cheetah_model(), posed(state)
    drawn = []
    for geom in range(model.ngeom):
        if model.geom_type[geom] != int(mujoco.mjtGeom.mjGEOM_CAPSULE):
            continue
        radius, half = model.geom_size[geom, :2]
        axis = data.geom_xmat[geom].reshape(3, 3)[:, 2] * half
        ends = np.stack([data.geom_xpos[geom] - axis, data.geom_xpos[geom] + axis])
        drawn.append((ends[:, [0, 2]], float(radius)))
    return drawn


def rendered(state: Float[Tensor, " 20"]) -> np.ndarray | None:
    """Return MuJoCo's picture (480, 480, 3), uint8, of an observation, or None where it cannot draw."""
    return picture(cheetah_model(), posed(state), "track")

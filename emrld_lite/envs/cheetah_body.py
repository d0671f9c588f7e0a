"""The cheetah's body: its MuJoCo model, what is observed of it, and how it is drawn."""

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

TORSO_HEIGHT = 0.7  # of the torso when its joints are at 0, metres
TORSO_X = 17  # where an observation has the torso's x
logger = logging.getLogger(__name__)


@functools.cache
def cheetah_model() -> mujoco.MjModel:
    """Return Gymnasium's HalfCheetah as a MuJoCo model; its warnings go to ``logging``."""
    mujoco.set_mju_user_warning(lambda text: logger.info("mujoco: %s", text))
    folder = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
    return mujoco.MjModel.from_xml_path(str(folder / "half_cheetah.xml"))


def observation(
    qpos: Float[np.ndarray, "*at 9"], qvel: Float[np.ndarray, "*at 9"]
) -> Float[np.ndarray, "*at 20"]:
    """Return the joint positions but x (8), all velocities (9), the torso's position (3).

    The released code's observation, not the 17 of HalfCheetah-v5.
    """
    x, z = qpos[..., :1], qpos[..., 1:2] + TORSO_HEIGHT
    return np.concatenate([qpos[..., 1:], qvel, x, np.zeros_like(x), z], axis=-1)


def full_state(
    state: Float[Tensor, " 20"],
) -> tuple[Float[np.ndarray, " 9"], Float[np.ndarray, " 9"]]:
    """Return qpos and qvel from an observation."""
    values = state.double().numpy()
    return np.concatenate([values[TORSO_X : TORSO_X + 1], values[:8]]), values[8:17]


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

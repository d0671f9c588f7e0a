"""HalfCheetah Forward-Backward: run one way or the other, paid only beyond two metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco.batch
import numpy as np
import torch
from matplotlib.axes import Axes

from ..validation import InputError, known, positive_count, shaped
from .base import Environment, Transition, refuse_wrong
from .cheetah_body import capsules, cheetah_model, rendered
from .drawing import BODY_COLOUR, GOAL_COLOUR

HORIZON = 100  # control steps, appendix B
FRAME_SKIP = 5  # physics steps a control step, as in Gymnasium's HalfCheetah
TORSO_HEIGHT = 0.7  # of the torso when its joints are at 0, metres
REWARD_BEYOND = 2.0  # metres from the start
CONTROL_COST = 0.05  # times the squared norm of the action, released code
POSITION_BOUND, VELOCITY_BOUND = 100.0, 1000.0  # beyond, a simulation counts as broken


def observation(qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    """Return (..., 20): the joint positions but x (8), all velocities (9), the torso's position (3).

    ``qpos`` and ``qvel`` are (..., 9). The released code's observation, not the 17 of HalfCheetah-v5.
    """
    x, z = qpos[..., :1], qpos[..., 1:2] + TORSO_HEIGHT
    return np.concatenate([qpos[..., 1:], qvel, x, np.zeros_like(x), z], axis=-1)


def run_reward(
    before: torch.Tensor,
    after: torch.Tensor,
    direction: torch.Tensor,
    cost: torch.Tensor,
    dt: float,
) -> torch.Tensor:
    """Return d_g (x_{t+1} - x_t) / dT - c_t, (...), the reward wherever one is paid. Appendix B."""
    return direction * (after - before) / dt - cost


@dataclass(frozen=True)
class HalfCheetahForwardBackward(Environment):
    """The paper's HalfCheetah Forward-Backward (appendix B, Environments), in MuJoCo.

    =========== ====== ================================================================
    Observation 0-7    height and pitch of the root, six joint angles (metres, radians)
    Observation 8-16   velocities of x, height, pitch and the six joints (m/s, rad/s)
    Observation 17-19  position of the torso, metres; x starts at 0
    Action      0-5    torques at the six joints, [-1, 1] of their range
    Task        0      direction: +1 forward, -1 backward
    =========== ====== ================================================================

    A control step lasts 0.05 s. Every episode starts at rest. All episodes are stepped in native
    threads; the environment holds their simulations between ``reset`` and the last ``step``, so one
    rollout at a time. Raises InputError for an unknown reward.
    """

    reward: Literal["sparse", "dense"] = "sparse"
    """Paid beyond two metres only (paper), or everywhere, which the experts learn from."""
    threads: int | None = None
    """Native threads; by default as many as torch uses. The numbers do not depend on it."""

    name = "half_cheetah"
    horizon = HORIZON
    state_dim = 20
    action_dim = 6
    task_dim = 1
    observation_high = (POSITION_BOUND,) * 8 + (VELOCITY_BOUND,) * 9 + (POSITION_BOUND,) * 3
    observation_low = tuple(-bound for bound in observation_high)

    def __post_init__(self) -> None:
        known("reward", self.reward, ("sparse", "dense"))
        if self.threads is not None:
            positive_count("threads", self.threads)
        object.__setattr__(self, "_running", {})

    @property
    def time_step(self) -> float:
        """dT in seconds."""
        return FRAME_SKIP * cheetah_model().opt.timestep

    def training_tasks(self) -> torch.Tensor:
        """Return the two directions in 10 task slots, five each, (10, 1)."""
        return torch.tensor([1.0] * 5 + [-1.0] * 5)[:, None]

    def sample_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return directions drawn evenly, (count, 1): the paper trains and tests on the same two."""
        drawn = random.choice([-1.0, 1.0], (positive_count("tasks", count), 1))
        return torch.tensor(drawn, dtype=torch.float32)

    def test_tasks(self, count: int, random: np.random.Generator) -> torch.Tensor:
        """Return both directions in turn, (count, 1), so that neither is missed."""
        signs = [1.0, -1.0] * positive_count("tasks", count)
        return torch.tensor(signs[:count])[:, None]

    def check_tasks(self, tasks: torch.Tensor) -> torch.Tensor:
        """Return directions (task, 1) unless one is neither +1 nor -1."""
        shaped("HalfCheetah directions", tasks, ("task", 1))
        wrong = tasks[:, 0].abs() != 1.0
        expected = "a direction of 1 (forward) or -1 (backward)"
        return refuse_wrong("HalfCheetah", tasks, wrong, expected)

    def reset(self, tasks: torch.Tensor, episodes: int) -> torch.Tensor:
        """Return the start, at rest, of every episode, (task, episode, 20)."""
        count = len(tasks) * positive_count("episodes", episodes)
        threads = self.threads or torch.get_num_threads()
        if self._running.get("size") != (count, threads):
            batch = mujoco.batch.Batch(cheetah_model(), count, threads)
            self._running.update(size=(count, threads), batch=batch)
        self._running["batch"].reset()
        return self._observe(len(tasks), episodes, tasks.device)

    def step(
        self, tasks: torch.Tensor, states: torch.Tensor, actions: torch.Tensor, time: int
    ) -> Transition:
        """Apply the torques for 0.05 s and pay the reward; raises InputError for foreign states."""
        if not torch.equal(states, self._running.get("states", torch.empty(0))):
            raise InputError(
                "states: HalfCheetah steps its own simulations, so expected the states of its "
                "last reset or step, got others"
            )
        clipped = actions.clamp(-1.0, 1.0)
        batch = self._running["batch"]
        batch.bind("ctrl")[:] = clipped.reshape(-1, self.action_dim).cpu().numpy()
        batch.step(nstep=FRAME_SKIP)
        moved = self._observe(*states.shape[:2], states.device)
        before, after = states[..., 17], moved[..., 17]  # (task, episode)
        cost = CONTROL_COST * clipped.square().sum(-1)
        rewards = run_reward(before, after, tasks, cost, self.time_step)
        beyond = after.abs() > REWARD_BEYOND
        if self.reward == "sparse":
            rewards = torch.where(beyond, rewards, torch.zeros_like(rewards))
        broken = self._running["broken"].to(states.device)
        rewards = torch.where(broken, torch.zeros_like(rewards), rewards)
        return Transition(moved, rewards, broken, beyond & (after * tasks > 0) & ~broken)

    def _observe(self, tasks: int, episodes: int, device: torch.device) -> torch.Tensor:
        """Return the states of all simulations; one out of bounds is marked broken, and reads zero."""
        batch = self._running["batch"]
        seen = observation(batch.bind("qpos"), batch.bind("qvel"))
        states = torch.from_numpy(seen.astype(np.float32)).reshape(tasks, episodes, -1)
        bound = torch.tensor(self.observation_high)
        broken = ~(states.abs() <= bound).all(-1)  # (task, episode); also where not a number
        states = torch.where(broken[..., None], torch.zeros_like(states), states).to(device)
        self._running.update(states=states, broken=broken)
        return states

    def distance_to_reward(self, tasks: torch.Tensor, states: torch.Tensor) -> torch.Tensor:
        """Return how much of the two metres is left, whichever way it ran."""
        return REWARD_BEYOND - states[..., 17].abs()

    def draw(self, axes: Axes, task: torch.Tensor, states: torch.Tensor) -> None:
        """Draw the cheetah from the side, and where its reward begins."""
        x = float(states[-1, 17])
        edge = float(task[0]) * REWARD_BEYOND
        axes.axvspan(edge, edge + float(task[0]) * 40, color=GOAL_COLOUR, alpha=0.25)
        axes.axhline(0, color=BODY_COLOUR, linewidth=1.5)
        for ends, radius in capsules(states[-1]):
            axes.plot(
                *np.transpose(ends),
                color=BODY_COLOUR,
                linewidth=160 * radius,
                solid_capstyle="round",
            )
        axes.set(xlim=(x - 1.6, x + 1.6), ylim=(-0.6, 2.6))

    def picture(self, task: torch.Tensor, states: torch.Tensor) -> np.ndarray:
        """Return MuJoCo's own picture where there is a GL library, else the drawing."""
        picture = rendered(states[-1])
        return super().picture(task, states) if picture is None else picture

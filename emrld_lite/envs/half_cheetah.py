"""HalfCheetah Forward-Backward: run one way or the other, paid only beyond two metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import mujoco.batch
import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from ..validation import InputError, check_choice, positive_count, shaped
from .base import (
    Actions,
    Axes,
    Environment,
    PaidSide,
    PerEpisode,
    Reward,
    Start,
    States,
    Tasks,
    Transition,
    refuse_wrong,
)
from .cheetah_body import TORSO_X, capsules, cheetah_model, observation, rendered

HORIZON = 100  # control steps, appendix B
FRAME_SKIP = 5  # physics steps per control step, as in Gymnasium's HalfCheetah
REWARD_BEYOND = 2.0  # metres from the start
CONTROL_COST = 0.05  # times the squared norm of the action, released code
POSITION_BOUND, VELOCITY_BOUND = 100.0, 1000.0  # beyond, a simulation counts as broken
START_NOISE = 0.1  # of a random start, as in Gymnasium's HalfCheetah and the released code


def run_reward(
    before: PerEpisode,
    after: PerEpisode,
    direction: Float[Tensor, "task 1"],
    cost: PerEpisode,
    dt: float,
) -> PerEpisode:
    """Return d_g (x_{t+1} - x_t) / dT - c_t, the reward wherever one is paid. Appendix B."""
    return direction * (after - before) / dt - cost


@dataclass(frozen=True)
class HalfCheetahForwardBackward(Environment):
    """The paper's HalfCheetah Forward-Backward (appendix B, Environments), in MuJoCo.

    ## Description
    Gymnasium's HalfCheetah, a planar body with six joints, runs forward or backward without being
    told which: the direction is the task. A control step lasts 0.05 s. All episodes are stepped in
    native threads; the environment holds their simulations between ``reset`` and the last ``step``,
    so one rollout at a time.

    ## Observation space
    ====== =============================================== ====== ===== =================
    Num    Observation                                     Min    Max   Unit
    ====== =============================================== ====== ===== =================
    0      height of the root, from its start              -100   100   metres
    1      pitch of the root                               -100   100   radians
    2-4    angles of the back thigh, shin and foot         -100   100   radians
    5-7    angles of the front thigh, shin and foot        -100   100   radians
    8, 9   velocities of x and height                      -1000  1000  metres per second
    10-16  velocities of pitch and the six joints          -1000  1000  radians per second
    17-19  x, y (always 0) and z of the torso              -100   100   metres
    ====== =============================================== ====== ===== =================

    ## Action space
    === ================================================ === === ==========================
    Num Action                                           Min Max Unit
    === ================================================ === === ==========================
    0-2 torques at the back thigh, shin and foot         -1  1   the joint's gear in N m
    3-5 torques at the front thigh, shin and foot        -1  1   (120, 90, 60; 120, 60, 30)
    === ================================================ === === ==========================

    ## Rewards
    Where the torso is more than 2 m from its start, whichever way: direction times its velocity in
    metres per second, minus 0.05 times the squared norm of the action; 0 elsewhere.
    ``reward="dense"``: the same everywhere. ``paid_side="correct"``: 0 also on the wrong side.

    ## Starting state
    At rest, torso at x = 0, all joints at 0; ``start="random"``: each position off by up to 0.1, each
    velocity by a normal number of deviation 0.1.

    ## Episode end
    Truncated after 100 steps; terminated, without reward, if the simulation leaves the observation's
    bounds.

    ## Tasks and options
    A task is the direction, 1 (forward) or -1 (backward): five slots of each to train on; the tests
    take both in turn. The options as below; InputError for what cannot be used.
    """

    reward: Reward = Environment.reward
    """Paid beyond two metres only (paper), or everywhere, which the experts learn from."""
    start: Start = "rest"
    """How an episode begins: at rest, or at random (released code)."""
    paid_side: PaidSide = "both"
    """Where the sparse reward is not 0: beyond two metres either way, so that the wrong way is punished
    (appendix B's formula, released code), or only in the task's direction (section 4.1's words)."""
    threads: int | None = None
    """Native threads; by default as many as torch uses. The numbers do not depend on it."""

    name = "half_cheetah"
    horizon = HORIZON
    state_dim = 20
    action_dim = 6
    task_dim = 1
    observation_high = (POSITION_BOUND,) * 8 + (VELOCITY_BOUND,) * 9 + (POSITION_BOUND,) * 3
    observation_low = tuple(-bound for bound in observation_high)
    idle_action = (0.0,) * 6

    def __post_init__(self) -> None:
        check_choice("reward", self.reward, get_args(Reward))
        check_choice("start", self.start, get_args(Start))
        check_choice("paid side", self.paid_side, get_args(PaidSide))
        if self.threads is not None:
            positive_count("threads", self.threads)
        object.__setattr__(self, "_running", {})

    @property
    def time_step(self) -> float:
        """dT in seconds."""
        return FRAME_SKIP * cheetah_model().opt.timestep

    def training_tasks(self) -> Tasks:
        """Return the two directions in 10 task slots, five each."""
        return torch.tensor([1.0] * 5 + [-1.0] * 5)[:, None]

    def sample_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return directions drawn evenly: the paper trains and tests on the same two."""
        drawn = random.choice([-1.0, 1.0], (positive_count("tasks", count), 1))
        return torch.tensor(drawn, dtype=torch.float32)

    def test_tasks(self, count: int, random: np.random.Generator) -> Tasks:
        """Return both directions in turn, so that neither is missed."""
        signs = [1.0, -1.0] * positive_count("tasks", count)
        return torch.tensor(signs[:count])[:, None]

    def check_tasks(self, tasks: Tensor) -> Tasks:
        """Return directions (task, 1) unless one is neither +1 nor -1."""
        shaped("HalfCheetah directions", tasks, ("task", 1))
        wrong = tasks[:, 0].abs() != 1.0
        expected = "a direction of 1 (forward) or -1 (backward)"
        return refuse_wrong("HalfCheetah", tasks, wrong, expected)

    def reset(self, tasks: Tasks, episodes: int, random: torch.Generator | None = None) -> States:
        """Return the start of every episode; raises InputError for a random one without ``random``."""
        count = len(tasks) * positive_count("episodes", episodes)
        threads = self.threads or torch.get_num_threads()
        if self._running.get("size") != (count, threads):
            batch = mujoco.batch.Batch(cheetah_model(), count, threads)
            self._running.update(size=(count, threads), batch=batch)
        self._running["batch"].reset()
        if self.start == "random":
            self._disturb(random)
        return self._observe(len(tasks), episodes, tasks.device)

    def step(self, tasks: Tasks, states: States, actions: Actions, time: int) -> Transition:
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
        before, after = states[..., TORSO_X], moved[..., TORSO_X]  # (task, episode)
        cost = CONTROL_COST * clipped.square().sum(-1)
        rewards = run_reward(before, after, tasks, cost, self.time_step)
        beyond = after.abs() > REWARD_BEYOND
        if self.reward == "sparse":
            rewards = torch.where(beyond & self._paid(after, tasks), rewards, 0.0)
        broken = self._running["broken"].to(states.device)
        rewards = torch.where(broken, torch.zeros_like(rewards), rewards)
        return Transition(moved, rewards, broken, beyond & (after * tasks > 0) & ~broken)

    def _paid(self, x: PerEpisode, tasks: Tasks) -> Bool[Tensor, "task episode"]:
        """Return whether a place is on a side that pays."""
        return (x * tasks > 0) | (self.paid_side == "both")

    def _disturb(self, random: torch.Generator | None) -> None:
        """Move every simulation off its rest, as Gymnasium's HalfCheetah is at its start."""
        if random is None:
            raise InputError("random: expected a generator, since start is 'random', got None")
        positions, velocities = (self._running["batch"].bind(name) for name in ("qpos", "qvel"))
        shift = 2.0 * torch.rand(positions.shape, generator=random, dtype=torch.float64) - 1.0
        positions += START_NOISE * shift.numpy()
        pushed = torch.randn(velocities.shape, generator=random, dtype=torch.float64)
        velocities += START_NOISE * pushed.numpy()

    def _observe(self, tasks: int, episodes: int, device: torch.device) -> States:
        """Return the states of all simulations; one out of bounds is marked broken, and reads zero."""
        batch = self._running["batch"]
        seen = observation(batch.bind("qpos"), batch.bind("qvel"))
        states = torch.from_numpy(seen.astype(np.float32)).reshape(tasks, episodes, -1)
        bound = torch.tensor(self.observation_high)
        broken = ~(states.abs() <= bound).all(-1)  # (task, episode); also where not a number
        states = torch.where(broken[..., None], torch.zeros_like(states), states).to(device)
        self._running.update(states=states, broken=broken)
        return states

    def distance_to_reward(self, tasks: Tasks, states: States) -> PerEpisode:
        """Return how much of the two metres is left, whichever way it ran."""
        return REWARD_BEYOND - states[..., TORSO_X].abs()

    def draw(
        self, axes: Axes, task: Float[Tensor, " task_dim"], states: Float[Tensor, "time state"]
    ) -> None:
        """Draw the cheetah from the side, and where its reward begins."""
        from .drawing import BODY_COLOUR, GOAL_COLOUR

        x = float(states[-1, TORSO_X])
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

    def draw_tasks(self, axes: Axes, tasks: Tasks) -> None:
        """Draw the two metres from which on either direction pays."""
        from .drawing import GOAL_COLOUR

        for edge in (-REWARD_BEYOND, REWARD_BEYOND):
            axes.axhline(edge, color=GOAL_COLOUR, linewidth=2)
        axes.set(xlabel="time (s)", ylabel="x of the torso (m)")

    def track(self, states: Float[Tensor, "time state"]) -> Float[Tensor, "2 time"]:
        """Return the time in seconds, and x of the torso in metres."""
        return torch.stack([self.time_step * torch.arange(len(states)), states[:, TORSO_X]])

    def picture(
        self, task: Float[Tensor, " task_dim"], states: Float[Tensor, "time state"]
    ) -> np.ndarray:
        """Return MuJoCo's own picture where there is a GL library, else the drawing."""
        picture = rendered(states[-1])
        return super().picture(task, states) if picture is None else picture

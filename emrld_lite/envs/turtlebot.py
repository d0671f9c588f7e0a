"""The TurtleBot: the drifting robot with wheels, motors, a delay and odometry, which training never saw."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco.batch
import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from ..validation import InputError, positive_count
from .base import Actions, Axes, PerEpisode, States, Tasks, Transition
from .goals import goal_distance
from .turtlebot_body import (
    OMEGA_MAX,
    PHYSICS_STEP,
    SEEN,
    V_MAX,
    Hardware,
    Odometry,
    turtlebot_model,
    wheel_speeds,
)
from .two_wheeled import ARENA, TIME_STEP, sparse_reward, velocities
from .two_wheeled_drift import TwoWheeledDrift

CONTROL_STEPS = round(TIME_STEP / PHYSICS_STEP)  # of the physics, within one control step
READING_STEPS = 5  # of the physics, between two readings of the odometry: 40 per second
DRIFT_LIMIT = 2.0  # rad/s; the literal reading of the largest drift is 1.4


@dataclass(frozen=True)
class TurtleBot(TwoWheeledDrift):
    """The robot of Section 4.2 in simulation: TwoWheeledDrift's task on a differential drive in MuJoCo.

    ## Description
    A TurtleBot3 Burger drives to the goal at (2, 1), commanded every 0.5 s by linear and angular
    velocity; a bias that nobody sees is added to the angular one. Its motors have limits, its wheels
    slip, commands arrive late, and what it sees of its place is odometry. All episodes are stepped in
    native threads; the environment holds their simulations, so one rollout at a time.

    ## Observation space
    === ============================= ======= ====== =============
    Num Observation                   Min     Max    Unit
    === ============================= ======= ====== =============
    0   x by odometry                 -2.75   2.75   metres
    1   y by odometry                 -2.75   2.75   metres
    2   heading, not wrapped          -175    175    radians
    === ============================= ======= ====== =============

    ## Action space
    === ======================== === === ======================================
    Num Action                   Min Max Stands for
    === ======================== === === ======================================
    0   linear velocity v        -1  1   0 to 0.15 metres per second
    1   angular velocity omega   -1  1   -1.5 to 1.5 radians per second
    === ======================== === === ======================================

    ## Rewards
    As in TwoWheeledDrift, by the odometry: a real robot has nothing else to know its place by.

    ## Starting state
    The origin, heading along x, at rest.

    ## Episode end
    As in TwoWheeledDrift, by the odometry; also when the robot falls over, without reward.

    ## Tasks and options
    A task is the bias of the angular velocity, at most 2 radians per second either way. ``hardware`` says
    what the robot is made of; other options as in TwoWheeledDrift.
    """

    largest_drift: float = DRIFT_LIMIT
    """The largest bias of any task, either way."""
    hardware: Hardware = field(default_factory=Hardware)
    """Friction, motors, delay and odometry."""
    threads: int | None = None
    """Native threads; by default as many as torch uses. The numbers do not depend on it."""

    name = "turtlebot"
    drift_limit = DRIFT_LIMIT

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.hardware, Hardware):
            raise InputError(f"hardware: expected a Hardware, got {self.hardware!r}")
        if self.threads is not None:
            positive_count("threads", self.threads)
        object.__setattr__(self, "_running", {})

    @property
    def observation_high(self) -> tuple[float, ...]:  # type: ignore[override]
        """The arena and a step beyond it; the heading is never wrapped."""
        edge = ARENA + 2 * self.v_limit * TIME_STEP
        return (edge, edge, self.horizon * self._largest_turn())[: self.state_dim]

    def reset(self, tasks: Tasks, episodes: int, random: torch.Generator | None = None) -> States:
        """Return the origin, at rest, for every episode; ``random`` draws the odometry's errors."""
        count = len(tasks) * positive_count("episodes", episodes)
        threads = self.threads or torch.get_num_threads()
        if self._running.get("size") != (count, threads):
            batch = mujoco.batch.Batch(turtlebot_model(self.hardware), count, threads)
            self._running.update(size=(count, threads), batch=batch)
        self._running["batch"].reset()
        seed = 0 if random is None else int(torch.randint(2**62, (), generator=random))
        still = np.zeros((count, 2))
        self._running.update(
            odometry=Odometry(count, self.hardware, np.random.default_rng(seed)),
            commands=[still] * (2 + self.hardware.delay_steps // CONTROL_STEPS),
        )
        return self._states(len(tasks), episodes, tasks.device)

    def step(self, tasks: Tasks, states: States, actions: Actions, time: int) -> Transition:
        """Send one command, drive for half a second, pay by what the odometry says."""
        if not torch.equal(states, self._running.get("states", torch.empty(0))):
            raise InputError(
                "states: TurtleBot steps its own simulations, so expected the states of its last "
                "reset or step, got others"
            )
        v, omega = velocities(actions, self.v_limit, self.omega_limit).unbind(-1)
        self._drive(v, omega + tasks[:, :1])
        moved = self._states(*states.shape[:2], states.device)
        goals = self._goals(tasks)[:, None]
        rewards, reached = sparse_reward(moved[..., :SEEN], goals, time, self.reached_box)
        if self.reward == "dense":
            rewards = -goal_distance(moved, goals)
        outside = (moved[..., :2].abs() > ARENA).any(-1)
        fallen = torch.from_numpy(self._running["odometry"].fallen).reshape(rewards.shape)
        fallen = fallen.to(rewards.device)
        rewards = torch.where(fallen, torch.zeros_like(rewards), rewards)
        return Transition(moved, rewards, reached | outside | fallen, reached & ~fallen)

    @property
    def fallen(self) -> int:
        """How many robots of the last rollout fell over, or broke their simulation."""
        return int(self._running["odometry"].fallen.sum())

    def truly_reached(self, tasks: Tasks, states: States) -> Bool[Tensor, "task episode"]:
        """Return whether the robot itself, whatever its odometry says, stands in the goal's box."""
        off = (states[..., SEEN : SEEN + 2] - self._goals(tasks)[:, None]).abs()
        return (off <= self.reached_box).all(-1)

    def draw(
        self, axes: Axes, task: Float[Tensor, " task_dim"], states: Float[Tensor, "time state"]
    ) -> None:
        """Draw the goal, the way that the robot went, and the robot where it is."""
        super().draw(axes, task, states[..., SEEN:])

    def track(self, states: Float[Tensor, "time state"]) -> Float[Tensor, "2 time"]:
        """Return x and y as they are."""
        return states[:, SEEN : SEEN + 2].T

    def _drive(self, v: PerEpisode, omega: PerEpisode) -> None:
        """Let the motors follow the commands that have arrived, and read the odometry on the way.

        A command that is d steps of the physics late acts from step d of its control step on; until
        then the one before it does.
        """
        flat = [part.reshape(-1).double().cpu().numpy() for part in (v, omega)]
        command = wheel_speeds(flat[0].clip(-V_MAX, V_MAX), flat[1].clip(-OMEGA_MAX, OMEGA_MAX))
        commands = [*self._running["commands"][1:], command]  # the oldest first
        self._running["commands"] = commands
        batch, arrival = self._running["batch"], self.hardware.delay_steps % CONTROL_STEPS
        for start in range(0, CONTROL_STEPS, READING_STEPS):
            until = min(max(arrival - start, 0), READING_STEPS)
            for acting, steps in ((commands[0], until), (commands[1], READING_STEPS - until)):
                if steps:
                    batch.bind("ctrl")[:] = acting
                    batch.step(nstep=steps)
            self._running["odometry"].read(batch.bind("qpos"), READING_STEPS * PHYSICS_STEP)

    def _states(self, tasks: int, episodes: int, device: torch.device) -> States:
        """Return what the odometry says and what is true, of all robots."""
        odometry = self._running["odometry"]
        both = np.concatenate([odometry.seen, odometry.true], axis=-1).astype(np.float32)
        states = torch.from_numpy(both).reshape(tasks, episodes, -1).to(device)
        self._running.update(states=states)
        return states

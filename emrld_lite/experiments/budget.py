"""What a command will need, estimated before it starts: memory, which must fit, and time, which is said.

The memory's constants were fitted to peaks measured with 1 to 400 tasks, 2 to 1600 episodes and 20 to
800 Fisher samples (Point2D and HalfCheetah, within a third); the time's are those of the stored runs.
"""

from __future__ import annotations

from ..config import TrainConfig
from ..envs.base import Environment
from ..learners import Trpo
from ..limits import check_memory, readable_bytes, readable_time
from ..trpo import TrustRegion
from ..validation import InputError

BASE = 100e6  # bytes that any training adds to its program
PER_STEP, PER_NUMBER = (
    600,
    40,
)  # bytes a step of a rollout takes, and each number of state and action in it
PER_FISHER_SAMPLE = 9500  # bytes
PER_POLICY = 200e3  # bytes of a task's parameters and their gradients
PER_WORKING_STEP = 3000  # bytes, of the tasks that are worked on at once
WORKED_ON = 4  # tasks at once
MOST_DRAWN = 2**24  # steps of one task among which torch can draw samples
SECONDS_PER_TASK = {  # of one iteration of 20 episodes, on one core, in the stored runs
    "point2d": 0.065,
    "two_wheeled": 0.045,
    "two_wheeled_drift": 0.05,
    "two_wheeled_literal_drift": 0.05,
    "half_cheetah": 0.19,
}
FISHER_SHARE = 0.3  # of an iteration with the default number of samples, measured on Point2D
NOTEWORTHY_BYTES, NOTEWORTHY_SECONDS = 1e9, 15.0  # of an iteration: more is said before it begins


def training_memory(config: TrainConfig, tasks: int) -> float:
    """Return about how many bytes meta-training on so many tasks takes at its peak."""
    world = config.environment()
    samples = config.trust_region.fisher_samples if _draws(config) else 0
    episodes = rollout_memory(world, 1, config.started_episodes or config.episodes)
    steps = min(WORKED_ON, tasks) * config.episodes * world.horizon
    each = episodes + samples * PER_FISHER_SAMPLE + PER_POLICY
    return BASE + tasks * each + steps * PER_WORKING_STEP


def rollout_memory(world: Environment, tasks: int, episodes: int) -> float:
    """Return about how many bytes the rollouts of one iteration take at their peak."""
    per_step = PER_STEP + PER_NUMBER * (world.state_dim + world.action_dim)
    return tasks * episodes * world.horizon * per_step


def evaluation_memory(world: Environment, tasks: int, steps: int, episodes: int) -> float:
    """Return about how many bytes an adaptation curve takes, which keeps every step's rollouts."""
    kept = rollout_memory(world, tasks, episodes) + tasks * PER_POLICY
    working = min(WORKED_ON, tasks) * episodes * world.horizon * PER_WORKING_STEP
    return BASE + kept * (1 + 0.3 * steps) + working


def check_training(config: TrainConfig, tasks: int) -> None:
    """Raise InputError for a training that this machine, or torch, has no room for."""
    drawn = config.episodes * config.environment().horizon
    if _draws(config) and drawn > MOST_DRAWN:
        most = MOST_DRAWN // config.environment().horizon
        raise InputError(f"episodes: expected at most {most}, got {config.episodes}")
    what = f"training on {tasks} tasks with {config.episodes} episodes each"
    if _draws(config):
        what += f" and {config.trust_region.fisher_samples} Fisher samples"
    check_memory(what, training_memory(config, tasks))


def check_evaluation(world: Environment, tasks: int, steps: int, episodes: int) -> None:
    """Raise InputError for an evaluation that this machine has no memory for."""
    what = f"an evaluation with {tasks} tasks, {steps} steps and {episodes} episodes"
    check_memory(what, evaluation_memory(world, tasks, steps, episodes))


def seconds_per_iteration(config: TrainConfig, tasks: int) -> float:
    """Return about how long one iteration takes on one core, at the stored runs' pace."""
    default = TrustRegion.fisher_samples
    drawn = config.trust_region.fisher_samples if _draws(config) else default
    share = 1.0 - FISHER_SHARE + FISHER_SHARE * drawn / default
    return SECONDS_PER_TASK[config.env] * tasks * config.episodes / 20 * share


def announcement(config: TrainConfig, tasks: int) -> str | None:
    """Return what to say before a training of unusual size; None before one of the usual size."""
    memory, seconds = training_memory(config, tasks), seconds_per_iteration(config, tasks)
    if memory < NOTEWORTHY_BYTES and seconds < NOTEWORTHY_SECONDS:
        return None
    return (
        f"{tasks} tasks, {config.episodes} episodes each: about {readable_bytes(memory)} of memory, "
        f"{readable_time(seconds)} an iteration"
    )


def _draws(config: TrainConfig) -> bool:
    """Return whether the meta-update draws samples of the steps, as TRPO's Fisher product does."""
    return issubclass(config.learner_type(), Trpo)

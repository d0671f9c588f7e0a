"""Stored policies on the simulated TurtleBot: Section 4.2's experiment, and how far its success reaches.

A meta-policy drives the robot for five trajectories, sees one simulated demonstration, takes one step,
and drives again. Then the same for other drifts, delays, frictions and errors of the odometry, which the
paper's one robot could not be given.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from .. import storage
from ..adapt import adapt, warm_start
from ..demonstrations import Demonstrations
from ..demonstrators import recipes
from ..envs import family
from ..envs.base import Actions, Dynamics, States, Tasks, Transition
from ..envs.turtlebot import TurtleBot
from ..envs.turtlebot_body import Hardware
from ..envs.two_wheeled import TIME_STEP
from ..envs.two_wheeled_drift import DRIFT_GOAL, ROBOT_DRIFT, ROBOT_TRIALS, TwoWheeledDrift
from ..policy import per_task
from ..rollout import Rollout, collect, episode_returns, follow
from ..validation import InputError
from .runs import Run, load_config, load_run
from .textbook import GAIN, aim

STORED = storage.DATA / "robot" / "study.csv"
TRIES = 4  # adaptations per case, each with trajectories of its own: five are few, and luck tells
EPISODES = 4  # that measure each of them
CONTROLLER = "aim-at-goal"  # the textbook controller's rows
BEFORE, TRIAL, AFTER = "before", "trial", "after"  # the meta-policy, what collects, one step later
HARDWARE = {  # varied, one at a time, at the paper's drift
    "delay": (0.0, 0.25, 0.5, 1.0, 1.5, 2.0),
    "friction": (0.3, 0.05, 0.02),
    "odometry_turn": (0.0, 0.1, 0.2, 0.4),
    "odometry_slide": (0.0, 0.1, 0.2),
}
DRIFTS = (-1.0, -0.8125, -0.5, -0.25, 0.0, 0.25, 0.5, 0.8125, 1.0)  # of a world's largest drift


class Row(NamedTuple):
    """How one policy drove in one case, a row of the study's table."""

    run: str
    """Name of the stored run, or of the controller."""
    varied: str
    """What differs from the paper's case: drift, or a field of Hardware."""
    value: float
    """Its value: a drift in the unit of the run's environment, a field in its own."""
    bias: float
    """By how much the robot turns by itself, rad/s."""
    stage: str
    """The meta-policy before adaptation; what collects the five trajectories (EMRLD-WS: after its warm
    start); or after the adaptation step."""
    mean_return: float
    """Mean over the tries and their episodes."""
    reached: float
    """Share of the episodes that ended at the goal, by the odometry."""
    truly: float
    """Share of the episodes in which the robot itself stood in the goal's box then."""


class Driven(NamedTuple):
    """Episodes on the robot, and where it really was."""

    rollout: Rollout
    """What the policy saw and did, (task, episode, time)."""
    truth: Float[Tensor, "task episode time 3"]
    """True x, y and heading after each step, zero after the end."""
    truly: Bool[Tensor, "task episode"]
    """Whether the robot itself, whatever its odometry said, stood in the goal's box at the end."""


class Witness(Dynamics):
    """A robot whose true places are written down while a policy drives it."""

    def __init__(self, robot: TurtleBot) -> None:
        self.robot, self.visited = robot, list[States]()
        self.horizon, self.state_dim, self.action_dim = (
            robot.horizon,
            robot.state_dim,
            robot.action_dim,
        )

    def reset(self, tasks: Tasks, episodes: int, random: torch.Generator | None = None) -> States:
        """Begin anew."""
        self.visited = []
        return self.robot.reset(tasks, episodes, random)

    def observe(self, states: Float[Tensor, "*at inside"]) -> Float[Tensor, "*at state"]:
        """Return what a policy sees."""
        return self.robot.observe(states)

    def step(self, tasks: Tasks, states: States, actions: Actions, time: int) -> Transition:
        """Step the robot and write down where it is."""
        moved = self.robot.step(tasks, states, actions, time)
        self.visited.append(moved.states)
        return moved

    def driven(self, tasks: Tasks, rollout: Rollout) -> Driven:
        """Return the episodes with the places of the last rollout."""
        states = torch.stack(self.visited, dim=2)  # (task, episode, time, 6)
        last = rollout.mask.sum(-1).long() - 1  # (task, episode)
        index = last[..., None, None].expand(*last.shape, 1, states.shape[-1])
        ends = states.gather(2, index).squeeze(2)
        truth = states[..., 3:] * rollout.mask[..., None]
        return Driven(rollout, truth, self.robot.truly_reached(tasks, ends) & rollout.success)


def robot_bias(world: TwoWheeledDrift, drifts: Float[Tensor, "task 1"]) -> Float[Tensor, "task 1"]:
    """Return by how many rad/s a robot must turn by itself to drift as ``world`` does.

    The literal reading of the paper's formula adds a drift to the heading in every step of half a second.
    """
    return world.drift_per_step(drifts) / TIME_STEP


def robot_for(world: TwoWheeledDrift, hardware: Hardware | None = None) -> TurtleBot:
    """Return the robot for a policy that was trained in ``world``: it sees a heading if that one did."""
    return TurtleBot(heading=world.heading, hardware=hardware or Hardware())


def simulated_demonstrations(
    run: Run, drifts: Float[Tensor, "task 1"], seed: int = 0
) -> Demonstrations:
    """Return one demonstration per drift by the workbook's expert, in the world that trained ``run``."""
    quality = run.load_demonstrations().quality
    expert = recipes.load_or_train_expert(run.config.env, quality)
    shown = recipes.demonstrate(expert, run.config.env, drifts, quality, seed)
    return shown.seen_in(run.config.environment())


class Adapted(NamedTuple):
    """The experiment of Section 4.2: driving before, the trajectories adapted on, driving after."""

    before: Driven
    trial: Driven
    after: Driven


def adapt_on_robot(
    run: Run,
    drifts: Float[Tensor, "task 1"],
    hardware: Hardware | None = None,
    episodes: int = EPISODES,
    seed: int = 0,
) -> Adapted:
    """Drive with the meta-policy, adapt it to five trajectories and a demonstration, drive again.

    One task per drift, in the unit of the environment of ``run``; another environment raises InputError.
    """
    world = run.config.environment()
    if not isinstance(world, TwoWheeledDrift):
        raise InputError(f"{run.config.env}: expected a run of changing dynamics")
    tasks, robot = robot_bias(world, drifts), Witness(robot_for(world, hardware))
    shown = simulated_demonstrations(run, drifts, seed)
    rule = run.config.adaptation(shown.quality)
    random = torch.Generator().manual_seed(seed)
    meta_params = per_task(run.meta_params, len(drifts))
    before = robot.driven(tasks, collect(robot, tasks, meta_params, episodes, random))
    start = warm_start(meta_params, shown, rule)
    trial = robot.driven(tasks, collect(robot, tasks, start, ROBOT_TRIALS, random))
    adapted = adapt(meta_params, run.config.score()(trial.rollout), shown, rule)
    after = robot.driven(tasks, collect(robot, tasks, adapted, episodes, random))
    return Adapted(before, trial, after)


def controller_on_robot(
    biases: Float[Tensor, "task 1"],
    hardware: Hardware | None = None,
    episodes: int = EPISODES,
    seed: int = 0,
    gain: float = GAIN,
) -> Driven:
    """Drive with the textbook controller, which is told the goal and not the bias."""
    bot = TurtleBot(hardware=hardware or Hardware())
    robot, act = Witness(bot), aim(torch.tensor([DRIFT_GOAL]), bot.omega_limit, gain)
    random = torch.Generator().manual_seed(seed)
    return robot.driven(biases, follow(robot, biases, act, episodes, random))


class Case(NamedTuple):
    """What is varied together, in one batch: drifts on one hardware, or one hardware at one drift."""

    varied: str
    values: tuple[float, ...]
    """One per task."""
    drifts: Float[Tensor, "task 1"]
    hardware: Hardware


def cases(world: TwoWheeledDrift) -> list[Case]:
    """Return the study's cases for the policies of a world, the drifts first."""
    drifts = tuple(round(share * world.drift_limit, 4) for share in DRIFTS)
    drifts = tuple(sorted({*drifts, ROBOT_DRIFT}))
    found = [Case("drift", drifts, torch.tensor(drifts)[:, None], Hardware())]
    paper = torch.tensor([[ROBOT_DRIFT]])
    for name, values in HARDWARE.items():
        found += [
            Case(name, (value,), paper, replace(Hardware(), **{name: value})) for value in values
        ]
    return found


def study_run(run: Run, name: str, seed: int = 0) -> Iterator[Row]:
    """Yield the rows of one stored run."""
    world = run.config.environment()
    assert isinstance(world, TwoWheeledDrift)
    for case in cases(world):
        drifts = case.drifts.repeat_interleave(TRIES, dim=0)
        adapted = adapt_on_robot(run, drifts, case.hardware, seed=seed)
        bias = robot_bias(world, case.drifts)
        for stage, driven in zip((BEFORE, TRIAL, AFTER), adapted, strict=True):
            yield from _rows(name, case, bias, stage, driven)


def study_controller(world: TwoWheeledDrift, seed: int = 0) -> Iterator[Row]:
    """Yield the rows of the textbook controller in the cases of ``world``."""
    for case in cases(world):
        bias = robot_bias(world, case.drifts)
        tried = bias.repeat_interleave(TRIES, dim=0)
        driven = controller_on_robot(tried, case.hardware, seed=seed)
        yield from _rows(controller_name(world), case, bias, BEFORE, driven)


def controller_name(world: TwoWheeledDrift) -> str:
    """Return what the controller's rows in the cases of a world are called."""
    return f"{CONTROLLER}-{world.name}"


def study(runs_folder: Path, out: Path) -> Iterator[str]:
    """Drive every stored run of changing dynamics, and the controller; yields each name when it is done.

    The table ``out`` is written after each, and what it holds is not driven again: a study that was
    stopped goes on. Raises InputError for a folder without such runs, and for a damaged table.
    """
    rows = load_study(out) if out.exists() else []
    have = {row.run for row in rows}
    driving = drift_runs(runs_folder)
    worlds = {
        controller_name(run.config.environment()): run.config.environment()
        for run in map(load_run, driving)
    }
    for folder in driving:
        if folder.name not in have:
            rows += study_run(load_run(folder), folder.name)
            write_study(out, rows)
            yield folder.name
    for name, world in sorted(worlds.items()):
        if name not in have:
            rows += study_controller(world)
            write_study(out, rows)
            yield name


def drift_runs(folder: Path) -> list[Path]:
    """Return the runs of changing dynamics in a folder; raises InputError where there is none."""
    found = [
        path
        for path in sorted(Path(folder).glob("*-seed[0-9]*"))
        if issubclass(family(load_config(path).env), TwoWheeledDrift)
    ]
    if not found:
        raise InputError(f"{folder}: expected runs of changing dynamics, got none")
    return found


def _rows(
    name: str, case: Case, bias: Float[Tensor, "task 1"], stage: str, driven: Driven
) -> Iterator[Row]:
    count = len(case.values)
    scores = (episode_returns(driven.rollout), driven.rollout.success, driven.truly)
    means = zip(
        *(score.float().reshape(count, -1).mean(-1).tolist() for score in scores), strict=True
    )
    for value, turning, (total, reached, truly) in zip(
        case.values, bias[:, 0].tolist(), means, strict=True
    ):
        yield Row(name, case.varied, value, round(turning, 4), stage, total, reached, truly)


def write_study(path: Path, rows: Sequence[Row]) -> None:
    """Write the table of the study, atomically."""
    storage.write_csv(path, Row._fields, rows)


def load_study(path: Path = STORED) -> list[Row]:
    """Read the table of the study; a cell that is no number raises InputError with its line."""
    rows = []
    for line, row in enumerate(storage.read_csv(path, "robot study", Row._fields), start=2):
        numbers = ("value", "bias", "mean_return", "reached", "truly")
        try:
            rows.append(Row(**row | {field: float(row[field]) for field in numbers}))
        except (TypeError, ValueError) as error:
            raise InputError(f"{path}: line {line}: {error}") from error
    return rows

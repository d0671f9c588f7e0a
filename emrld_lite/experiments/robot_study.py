"""How far the success of Section 4.2's experiment reaches, as a table of cases on the simulated TurtleBot.

Every stored policy that trained on drifts as a rate adapts and drives under other drifts, delays,
frictions and errors of the odometry, which the paper's one robot could not be given.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from .. import storage
from ..envs.turtlebot_body import Hardware
from ..envs.two_wheeled_drift import ROBOT_DRIFT, TwoWheeledDrift
from ..rollout import episode_returns
from ..validation import InputError
from .results import stored_seeds
from .robot_driving import Driven, adapt_on_robot, controller_on_robot, robot_bias
from .runs import Run, load_run
from .studies import READINGS

STORED = storage.DATA / "robot" / "study.csv"
TRIES = 4  # adaptations per case, each with trajectories of its own: five are few, and luck tells
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
    """Return the runs to drive: with the heading and without, where the drift is a rate, as a robot's is.

    Raises InputError where there is none.
    """
    found = [
        path
        for reading in READINGS
        if reading.env == TwoWheeledDrift.name
        for seeds in stored_seeds(folder, reading.runs, "optimal").values()
        for path in seeds
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

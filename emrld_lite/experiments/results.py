"""What the stored runs say, as numbers: their seeds, returns on test tasks, and how flat a curve ends."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..algorithms import ALGORITHMS
from ..validation import InputError
from .evaluation import SAMPLED, read_evaluation
from .runs import load_curve

TITLES = {
    "point2d": "Point2D",
    "two_wheeled": "TwoWheeled",
    "half_cheetah": "HalfCheetah",
}
STEPS_SHOWN = {"optimal": 1, "suboptimal": 3}  # adaptation steps after which Fig. 5 looks
# mean return of the optimal demonstrators, uncut, as their files say
EARNED = {
    "point2d": 80.9,
    "two_wheeled": 84.0,
    "half_cheetah": 237.0,
    "two_wheeled_drift": 74.4,
    "two_wheeled_literal_drift": 74.5,
}


class Place(NamedTuple):
    """Where returns are compared: an environment, or one direction of HalfCheetah.

    HalfCheetah is tested on the two tasks it was trained on, and its mean over them hides that a
    policy may run one way whichever way it is asked.
    """

    title: str
    env: str
    goal: str | None
    """As a table of test tasks writes it; None for all."""
    earned: float
    """The mean return of the optimal demonstrations; HalfCheetah's without the last of their hundred
    steps, whose outcome their file does not hold."""


FORWARD = Place("HalfCheetah forward", "half_cheetah", "1.0", 138.0)
BACKWARD = Place("HalfCheetah backward", "half_cheetah", "-1.0", 329.9)
PLACES = (
    *(Place(TITLES[env], env, None, EARNED[env]) for env in ("point2d", "two_wheeled")),
    FORWARD,
    BACKWARD,
)
BOTH_WAYS = Place("HalfCheetah mean", "half_cheetah", None, EARNED["half_cheetah"])
LATE = 5  # the last fifth of a run against the fifth before says whether its curve still rises
FLAT = 0.05  # of the level at the end: a curve that rises by less has ended its rise
NOTHING = 0.05  # of the demonstrator's return: a level below it counts as this much


def seeds_of(folder: Path, name: str) -> list[Path]:
    """Return the run folders called ``name``-seed0, ``name``-seed1, ... that are stored."""
    return sorted(Path(folder).glob(f"{name}-seed[0-9]*"))


def check_runs(folder: Path) -> Path:
    """Return a folder that holds runs named as this workbook's; another raises InputError."""
    if not any(path.is_dir() for path in Path(folder).glob("*-seed[0-9]*")):
        raise InputError(
            f"{folder}: expected a folder of runs named like point2d-optimal-emrld-seed0, got none"
        )
    return Path(folder)


def stored_seeds(folder: Path, env: str, quality: str) -> dict[str, list[Path]]:
    """Return the run folders of each algorithm, one per seed, named like env-quality-algorithm-seed0.

    MAML reads no demonstrations, so its runs are stored once, under optimal.
    """
    found = {}
    for name in ALGORITHMS:
        stored_as = "optimal" if name == "maml" else quality
        if seeds := seeds_of(folder, f"{env}-{stored_as}-{name}"):
            found[name] = seeds
    return found


def task_returns(run: Path, goal: str | None = None, table: str = SAMPLED) -> np.ndarray:
    """Return a run's return on each test task by adaptation step, (step, task).

    Of all tasks, or of those whose goal is written as ``goal``; InputError where there is none.
    ``table`` is the file that says so, with sampled actions or by the mean action.
    """
    path = run / table
    rows = [row for row in read_evaluation(path) if goal in (None, row.goal)]
    if not rows:
        raise InputError(f"{path}: expected tasks with the goal {goal}, got none")
    steps = sorted({row.step for row in rows})
    return np.array([[row.mean_return for row in rows if row.step == step] for step in steps])


def returns_by_step(run: Path, goal: str | None = None) -> list[float]:
    """Return a run's mean return over test tasks after 0, 1, 2, ... adaptation steps."""
    return [float(mean) for mean in task_returns(run, goal).mean(1)]


def task_scores(
    runs: Sequence[Path], step: int, goal: str | None = None, table: str = SAMPLED
) -> np.ndarray:
    """Return each test task's mean return after ``step`` adaptation steps, (seed, task).

    Raises InputError for no runs, and for a run that was not tested after so many steps.
    """
    scores = []
    for run in _some(runs):
        returns = task_returns(run, goal, table)
        if not 0 <= step < len(returns):
            raise InputError(f"{run / table}: expected rows of step {step}, got none")
        scores.append(returns[step])
    return np.array(scores)


def run_scores(
    runs: Sequence[Path], step: int, goal: str | None = None, table: str = SAMPLED
) -> np.ndarray:
    """Return each run's score: its mean return over test tasks after ``step`` steps, (seed,)."""
    return task_scores(runs, step, goal, table).mean(1)


def training_scores(runs: Sequence[Path], end: int | None = None, window: int = 10) -> np.ndarray:
    """Return the mean return after adaptation over the ``window`` iterations before ``end``, (seed,).

    On the training tasks; by default at the end of each run. Raises InputError for a shorter run.
    """
    means = []
    for run in _some(runs):
        returns = _returns_after(run)[:end]
        if len(returns) < max(window, end or 0):
            raise InputError(f"{run}: expected {end or window} iterations, got {len(returns)}")
        means.append(np.mean(returns[-window:]))
    return np.array(means)


def iterations_to(run: Path, target: float, end: int | None = None) -> int | None:
    """Return after how many iterations a run first returns ``target`` or more after adaptation.

    None where it does not, or not within the first ``end`` iterations.
    """
    reached = (n for n, mean in enumerate(_returns_after(run)[:end], 1) if mean >= target)
    return next(reached, None)


def largest_fall(runs: Sequence[Path], window: int = 10) -> float:
    """Return how far the mean over runs and ``window`` iterations falls below its best, as a share of it."""
    smooth = _smoothed(runs, window)
    return float((np.maximum.accumulate(smooth) - smooth).max() / smooth.max())


def updates_without_step(run: Path) -> int:
    """Return in how many meta-iterations of a run TRPO took no step: a zero gradient, or no trial passed."""
    return sum("no step" in row.note for row in load_curve(run / "curve.csv"))


def best_and_last(run: Path, window: int = 10) -> tuple[float, float]:
    """Return the best mean return after adaptation over ``window`` iterations, and the last."""
    smooth = _smoothed([run], window)
    return float(smooth.max()), float(smooth[-1])


def _smoothed(runs: Sequence[Path], window: int) -> np.ndarray:
    """Return the runs' mean training return over each ``window`` iterations in a row."""
    return np.convolve(_mean_curve(runs), np.ones(window) / window, "valid")


def _mean_curve(runs: Sequence[Path], end: int | None = None) -> np.ndarray:
    """Return the mean training return over runs, (iteration,), as far as the shortest goes or to ``end``."""
    curves = [_returns_after(run)[:end] for run in _some(runs)]
    shortest = min(map(len, curves))
    return np.mean([curve[:shortest] for curve in curves], axis=0)


def _returns_after(run: Path) -> list[float]:
    """Return the mean return after adaptation of each meta-iteration of a run."""
    return [row.return_after for row in load_curve(run / "curve.csv")]


def _some(runs: Sequence[Path]) -> Sequence[Path]:
    """Return the runs; raises InputError if there are none."""
    if not runs:
        raise InputError("runs: expected at least one stored run, got none")
    return runs


def late_rise(runs: Sequence[Path], earned: float, end: int | None = None) -> float:
    """Return by how much the mean over seeds still rises, as a share of its level at the end.

    The mean return of the last fifth of all iterations less that of the fifth before, divided by
    that of the last fifth. A level below a twentieth of ``earned``, the demonstrator's return, counts
    as that twentieth: so little is as good as nothing, and a share of nothing would say nothing. With
    ``end`` only the iterations before it count.
    """
    mean = _mean_curve(runs, end)
    window = len(mean) // LATE
    level = mean[-window:].mean()
    return float((level - mean[-2 * window : -window].mean()) / max(level, NOTHING * earned))


def summary(folder: Path) -> str:
    """Return the test tasks' mean returns as a Markdown table: mean over seeds (lowest to highest).

    A row per place and quality of the data, after one adaptation step on optimal data and three on
    sub-optimal data, as in Fig. 5; first the return of the demonstrations themselves. A cell with another
    number of seeds than most says so.
    """
    heads = ["", "data", "demonstrations", *(ALGORITHMS[name].label for name in ALGORITHMS)]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    rows = [(place, quality) for place in PLACES for quality in STEPS_SHOWN]
    stored = [stored_seeds(folder, place.env, quality) for place, quality in rows]
    usual = statistics.mode([len(runs) for found in stored for runs in found.values()] or [0])
    for (place, quality), found in zip(rows, stored, strict=True):
        recorded = place.earned if quality == "optimal" else 0.0  # cut before any reward
        cells = [
            _cell(found.get(name, []), STEPS_SHOWN[quality], place.goal, usual)
            for name in ALGORITHMS
        ]
        lines.append("| " + " | ".join([place.title, quality, f"{recorded:.1f}", *cells]) + " |")
    return "\n".join(lines)


def _cell(runs: list[Path], step: int, goal: str | None, usual: int) -> str:
    """Return one cell of the summary, with the number of seeds where it is not the usual one."""
    if not runs:
        return "not run"
    returns = list(run_scores(runs, step, goal))
    cell = f"{np.mean(returns):.1f}"
    if len(runs) > 1:
        cell += f" ({min(returns):.1f} to {max(returns):.1f})"
    return cell if len(runs) == usual else f"{cell}, {len(runs)} seed{'s' * (len(runs) > 1)}"

"""What the stored runs say, as numbers: their seeds, returns on unseen tasks, and how flat a curve ends."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..algorithms import ALGORITHMS
from ..validation import InputError
from .evaluation import read_evaluation
from .runs import load_curve

TITLES = {
    "point2d": "Point2D",
    "two_wheeled": "TwoWheeled",
    "half_cheetah": "HalfCheetah",
}
STEPS_SHOWN = {"optimal": 1, "suboptimal": 3}  # adaptation steps after which Fig. 5 looks
# mean return of the optimal demonstrators, uncut, as their files say
EARNED = {"point2d": 80.9, "two_wheeled": 84.0, "half_cheetah": 237.0}
LATE = 20  # iterations in each of the two windows that say whether a curve still rises
FLAT = 0.05  # of the demonstrator's return: a curve that rises by less has ended its rise


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


def returns_by_step(run: Path) -> list[float]:
    """Return a run's mean return over unseen tasks after 0, 1, 2, ... adaptation steps."""
    rows = read_evaluation(run / "unseen.csv")
    steps = sorted({row.step for row in rows})
    by_step = [[row.mean_return for row in rows if row.step == step] for step in steps]
    return [float(np.mean(returns)) for returns in by_step]


def unseen_scores(runs: Sequence[Path], step: int) -> np.ndarray:
    """Return each unseen task's mean return after ``step`` adaptation steps, (seed, task).

    Raises InputError for no runs, and for a run that was not tested after so many steps.
    """
    scores = []
    for run in _some(runs):
        rows = read_evaluation(run / "unseen.csv")
        scores.append([row.mean_return for row in rows if row.step == step])
        if not scores[-1]:
            raise InputError(f"{run / 'unseen.csv'}: expected rows of step {step}, got none")
    return np.array(scores)


def run_scores(runs: Sequence[Path], step: int) -> np.ndarray:
    """Return each run's score: its mean return over unseen tasks after ``step`` steps, (seed,)."""
    return unseen_scores(runs, step).mean(1)


def training_scores(runs: Sequence[Path], end: int | None = None, window: int = 10) -> np.ndarray:
    """Return the mean return after adaptation over the ``window`` iterations before ``end``, (seed,).

    On the training tasks; by default at the end of each run. Raises InputError for a shorter run.
    """
    means = []
    for run in _some(runs):
        returns = [row.return_after for row in load_curve(run / "curve.csv")][:end]
        if len(returns) < max(window, end or 0):
            raise InputError(f"{run}: expected {end or window} iterations, got {len(returns)}")
        means.append(np.mean(returns[-window:]))
    return np.array(means)


def largest_fall(run: Path, window: int = 10) -> float:
    """Return how far the mean over ``window`` iterations falls below its best so far, as a share of it."""
    returns = [row.return_after for row in load_curve(run / "curve.csv")]
    smooth = np.convolve(returns, np.ones(window) / window, "valid")
    return float((np.maximum.accumulate(smooth) - smooth).max() / smooth.max())


def _some(runs: Sequence[Path]) -> Sequence[Path]:
    """Return the runs; raises InputError if there are none."""
    if not runs:
        raise InputError("runs: expected at least one stored run, got none")
    return runs


def late_rise(run: Path, window: int = LATE) -> float:
    """Return by how much the last ``window`` iterations' mean return exceeds that of those before."""
    returns = [row.return_after for row in load_curve(run / "curve.csv")]
    return float(np.mean(returns[-window:]) - np.mean(returns[-2 * window : -window]))


def summary(folder: Path) -> str:
    """Return the unseen tasks' mean returns as a Markdown table: mean over seeds (lowest to highest).

    After one adaptation step on optimal data and three on sub-optimal data, as in Fig. 5.
    """
    columns = [(env, quality) for env in TITLES for quality in STEPS_SHOWN]
    heads = [f"{TITLES[env]}, {quality}" for env, quality in columns]
    lines = ["| | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    stored = [stored_seeds(folder, env, quality) for env, quality in columns]
    for name in ALGORITHMS:
        cells = [
            _cell(runs.get(name, []), STEPS_SHOWN[quality])
            for runs, (_, quality) in zip(stored, columns, strict=True)
        ]
        lines.append(f"| {ALGORITHMS[name].label} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cell(runs: list[Path], step: int) -> str:
    """Return one cell of the summary; other numbers of seeds than three are said."""
    if not runs:
        return "not run"
    returns = list(run_scores(runs, step))
    cell = f"{np.mean(returns):.1f}"
    if len(runs) > 1:
        cell += f" ({min(returns):.1f} to {max(returns):.1f})"
    return cell if len(runs) == 3 else f"{cell}, {len(runs)} seed{'s' * (len(runs) > 1)}"

"""The paper's figures, drawn from stored runs: Figs. 3 and 4 (results), Fig. 5 (trajectories)."""

from __future__ import annotations

import io
import itertools
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from . import plots
from .evaluate import EVALUATION_COLUMNS, evaluate_run, unseen_demonstrations
from .runs import load_run
from .storage import read_csv, write_atomically

TITLES = {
    "point2d": "Point2D",
    "two_wheeled": "TwoWheeled",
    "half_cheetah": "HalfCheetah",
}
STEPS_SHOWN = {"optimal": 1, "suboptimal": 3}  # adaptation steps in Fig. 5
GOALS_SHOWN = 20


def draw(folder: Path, out: Path) -> list[Path]:
    """Draw every figure from the runs in ``folder`` and write it to ``out`` as PNG and SVG."""
    plots.use_style()
    drawn = {
        "fig-3-optimal": results(folder, "optimal"),
        "fig-4-suboptimal": results(folder, "suboptimal"),
        "fig-5-trajectories": trajectories(folder),
    }
    paths = []
    for (name, figure), suffix in itertools.product(drawn.items(), ("png", "svg")):
        content = io.BytesIO()
        facts = {"Date": None} if suffix == "svg" else None
        figure.savefig(content, format=suffix, metadata=facts)
        paths.append(Path(out) / f"{name}.{suffix}")
        write_atomically(paths[-1], content.getvalue())
    return paths


def stored_seeds(folder: Path, env: str, quality: str) -> dict[str, list[Path]]:
    """Return the run folders of each algorithm, one a seed, named like env-quality-algorithm-seed0.

    MAML reads no demonstrations, so its runs are stored once, under optimal.
    """
    found = {}
    for name in plots.LOOKS:
        stored_as = "optimal" if name == "maml" else quality
        seeds = sorted(Path(folder).glob(f"{env}-{stored_as}-{name}-seed*"))
        if seeds:
            found[name] = seeds
    return found


def returns_by_step(path: Path) -> list[float]:
    """Return the mean return over tasks after 0, 1, 2, ... adaptation steps of an evaluation."""
    rows = read_csv(path, "evaluation", EVALUATION_COLUMNS)
    steps = sorted({int(row["step"]) for row in rows})
    by_step = [[float(row["return"]) for row in rows if int(row["step"]) == step] for step in steps]
    return [float(np.mean(returns)) for returns in by_step]


def results(folder: Path, quality: str) -> Figure:
    """Draw training (top) and adaptation to unseen tasks (bottom), a column an environment.

    Fig. 3 for ``quality`` optimal, Fig. 4 for suboptimal; lines are means over the stored seeds,
    bands reach from the lowest to the highest.
    """
    figure, panels = plt.subplots(2, len(TITLES), figsize=(10.5, 5.6), squeeze=False)
    named: dict[str, object] = {}
    for (env, title), (top, bottom) in zip(TITLES.items(), panels.T, strict=True):
        stored = stored_seeds(folder, env, quality)
        curves = {name: [load_run(run).curve for run in seeds] for name, seeds in stored.items()}
        unseen = {
            name: [returns_by_step(run / "unseen.csv") for run in seeds]
            for name, seeds in stored.items()
        }
        top.set_title(title)
        if not stored:
            top.text(0.5, 0.5, "no stored runs", transform=top.transAxes, ha="center")
            continue
        plots.learning_curves(curves, top)
        plots.adaptation_steps(unseen, bottom)
        for axes in (top, bottom):
            lines, labels = axes.get_legend_handles_labels()
            named |= dict(zip(labels, lines, strict=True))
            axes.get_legend().remove()
    for axes in panels[:, 1:].flat:
        axes.set_ylabel("")
    names = [plots.label(name) for name in plots.LOOKS if plots.label(name) in named]
    lines = [named[name] for name in names]
    figure.legend(lines, names, loc="outside upper center", ncols=len(plots.LOOKS))
    return figure


def trajectories(folder: Path, seed: int = 0) -> Figure:
    """Draw adapted TwoWheeled policies on 20 random goals, a column an algorithm. Fig. 5.

    Top: after one adaptation step on optimal data; bottom: after three on sub-optimal data. One
    episode a goal, of the run with ``seed``; the goals are those of ``evaluate --seed 0``.
    """
    names = list(plots.LOOKS)
    figure, panels = plt.subplots(2, len(names), figsize=(12, 4.6), squeeze=False)
    for row, (quality, steps) in zip(panels, STEPS_SHOWN.items(), strict=True):
        data = unseen_demonstrations("two_wheeled", quality, GOALS_SHOWN)
        stored = stored_seeds(folder, "two_wheeled", quality)
        for axes, name in zip(row, names, strict=True):
            plots.wheeled_arena(axes, data.tasks)
            axes.set_title(plots.label(name) if quality == "optimal" else "")
            axes.set_xlabel("" if quality == "optimal" else "x (length units)")
            runs = [run for run in stored.get(name, []) if run.name.endswith(f"-seed{seed}")]
            if runs:
                rollout = evaluate_run(load_run(runs[0]), data, steps).rollouts[-1]
                for task in range(GOALS_SHOWN):
                    colour = plots.LOOKS[name]["color"]
                    plots.trajectories(rollout, axes, task, 1, color=colour, alpha=0.9)
            else:
                axes.text(0.5, 0.1, "no stored run", transform=axes.transAxes, ha="center")
        row[0].set_ylabel(f"{quality} data,\n{steps} step{'s' * (steps > 1)}\ny (length units)")
    return figure


def summary(folder: Path) -> str:
    """Return the unseen tasks' mean returns as a Markdown table: mean over seeds (lowest to highest).

    After one adaptation step on optimal data and three on sub-optimal data, as in Fig. 5.
    """
    columns = [(env, quality) for env in TITLES for quality in STEPS_SHOWN]
    heads = [f"{TITLES[env]}, {quality}" for env, quality in columns]
    lines = ["| | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    stored = [stored_seeds(folder, env, quality) for env, quality in columns]
    for name in plots.LOOKS:
        cells = [
            _cell(runs.get(name, []), STEPS_SHOWN[quality])
            for runs, (_, quality) in zip(stored, columns, strict=True)
        ]
        lines.append(f"| {plots.label(name)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cell(runs: list[Path], step: int) -> str:
    """Return one cell of the summary; other numbers of seeds than three are said."""
    if not runs:
        return "not run"
    returns = [returns_by_step(run / "unseen.csv")[step] for run in runs]
    cell = f"{np.mean(returns):.1f}"
    if len(runs) > 1:
        cell += f" ({min(returns):.1f} to {max(returns):.1f})"
    return cell if len(runs) == 3 else f"{cell}, {len(runs)} seed{'s' * (len(runs) > 1)}"

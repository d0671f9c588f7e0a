"""The paper's figures, one function per figure, from the stored demonstrations and runs."""

from __future__ import annotations

import io
import itertools
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ..demonstrations import load_demonstrations
from ..demonstrators.recipes import unseen_demonstrations
from ..envs import make
from ..storage import write_atomically
from . import plotting
from .drift_figures import by_drift, drift, readings
from .evaluation import evaluate_run
from .panels import GOALS_SHOWN, adaptation, one_legend, training
from .results import PLACES, STEPS_SHOWN, TITLES, stored_seeds
from .robot_figures import paper_robot
from .runs import load_run
from .study_figures import ablation, sensitivity, switches


def draw(folder: Path, out: Path) -> list[Path]:
    """Draw every figure from the runs in ``folder`` and write it to ``out`` as PNG and SVG."""
    plotting.use_style()
    drawn = {
        "fig-2-demonstrations": demonstrations(),
        "fig-3-optimal": results(folder, "optimal"),
        "fig-4-suboptimal": results(folder, "suboptimal"),
        "fig-5-trajectories": trajectories(folder),
        "fig-6-drift": drift(folder),
        "drift-readings": readings(folder),
        "drift-narrow": by_drift(folder),
        "fig-6-robot": paper_robot(folder),
        "fig-7-sensitivity": sensitivity(folder),
        "fig-8-ablation": ablation(folder),
        "switches": switches(folder),
    }
    paths = []
    for (name, figure), suffix in itertools.product(drawn.items(), ("png", "svg")):
        content = io.BytesIO()
        facts = {"Date": None} if suffix == "svg" else None
        figure.savefig(content, format=suffix, metadata=facts)
        paths.append(Path(out) / f"{name}.{suffix}")
        write_atomically(paths[-1], content.getvalue())
    return paths


def demonstrations() -> Figure:
    """Draw every demonstration: optimal above, sub-optimal below, a column per environment. Fig. 2."""
    figure, panels = plt.subplots(2, len(TITLES), figsize=(10.5, 5.2))
    for row, quality in zip(panels, STEPS_SHOWN, strict=True):
        for axes, (env, title) in zip(row, TITLES.items(), strict=True):
            plotting.all_demonstrations(load_demonstrations(quality, env), axes)
            axes.set_title(f"{title}, {quality}")
    return figure


def results(folder: Path, quality: str) -> Figure:
    """Draw training (top) and adaptation to test tasks (bottom), a column per environment.

    Fig. 3 for ``quality`` optimal, Fig. 4 for suboptimal; lines are means over the stored seeds,
    bands reach from the lowest to the highest. HalfCheetah's test has a panel per direction; the grey
    line is what the optimal demonstrator earns.
    """
    figure = plt.figure(figsize=(11.5, 5.8))
    grid = figure.add_gridspec(2, 4)
    spans = (grid[0, 0], grid[0, 1], grid[0, 2:])
    tops = {env: figure.add_subplot(span) for env, span in zip(TITLES, spans, strict=True)}
    for env, title in TITLES.items():
        tops[env].set_title(f"{title}, training")
        training(stored_seeds(folder, env, quality), tops[env])
    for column, place in enumerate(PLACES):
        bottom = figure.add_subplot(grid[1, column])
        bottom.set_title(f"{place.title}, test")
        adaptation(stored_seeds(folder, place.env, quality), bottom, place.goal, place.earned)
    for axes in (*figure.axes[1:3], *figure.axes[4:]):
        axes.set_ylabel("")
    one_legend(figure, figure.axes)
    return figure


def trajectories(folder: Path, seed: int = 0) -> Figure:
    """Draw adapted TwoWheeled policies on 20 random goals, a column per algorithm. Fig. 5.

    Top: after one adaptation step on optimal data; bottom: after three on sub-optimal data. One
    episode per goal, of the run with ``seed``; the goals are those of ``evaluate --seed 0``. An
    episode that reaches its goal has the algorithm's colour, another is grey and dotted; the title counts.
    """
    names = list(plotting.LOOKS)
    figure, panels = plt.subplots(2, len(names), figsize=(12, 3.9), squeeze=False)
    for row, (quality, steps) in zip(panels, STEPS_SHOWN.items(), strict=True):
        data = unseen_demonstrations("two_wheeled", quality, GOALS_SHOWN)
        stored = stored_seeds(folder, "two_wheeled", quality)
        for axes, name in zip(row, names, strict=True):
            make("two_wheeled").draw_tasks(axes, data.tasks)
            axes.set_title(plotting.label(name))
            axes.set(ylabel="", **({"xlabel": ""} if quality == "optimal" else {}))
            runs = [run for run in stored.get(name, []) if run.name.endswith(f"-seed{seed}")]
            if runs:
                rollout = evaluate_run(load_run(runs[0]), data, steps).rollouts[-1]
                hits = [bool(hit) for hit in rollout.success[:, 0]]
                hit_look = {"color": plotting.LOOKS[name]["color"], "alpha": 0.9}
                for task, hit in enumerate(hits):
                    look = hit_look if hit else {"color": "#777777", "linestyle": ":"}
                    plotting.trajectories(rollout, axes, task, 1, **look)
                axes.set_title(f"{plotting.label(name)}: {sum(hits)}/{GOALS_SHOWN}")
            else:
                axes.text(0.5, 0.1, "no stored run", transform=axes.transAxes, ha="center")
        row[0].set_ylabel(f"{quality} data,\n{steps} step{'s' * (steps > 1)}\ny (length units)")
    return figure

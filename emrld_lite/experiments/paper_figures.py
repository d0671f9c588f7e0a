"""The paper's figures, one function per figure, from the stored demonstrations and runs."""

from __future__ import annotations

import io
import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..demonstrations import load_demonstrations
from ..demonstrators.recipes import unseen_demonstrations
from ..envs import make
from ..envs.two_wheeled_drift import ROBOT_DRIFT
from ..storage import write_atomically
from . import plotting
from .evaluation import evaluate_run
from .intervals import worst_to_best
from .results import (
    EARNED,
    PLACES,
    STEPS_SHOWN,
    TITLES,
    returns_by_step,
    run_scores,
    stored_seeds,
)
from .robot_figures import paper_robot
from .runs import load_curve, load_run
from .studies import (
    SENSITIVITY_END,
    STUDY_END,
    ablation_runs,
    sensitivity_runs,
    switch_runs,
)

GOALS_SHOWN = 20
DRIFT = "two_wheeled_drift"


def draw(folder: Path, out: Path) -> list[Path]:
    """Draw every figure from the runs in ``folder`` and write it to ``out`` as PNG and SVG."""
    plotting.use_style()
    drawn = {
        "fig-2-demonstrations": demonstrations(),
        "fig-3-optimal": results(folder, "optimal"),
        "fig-4-suboptimal": results(folder, "suboptimal"),
        "fig-5-trajectories": trajectories(folder),
        "fig-6-drift": drift(folder),
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
        _training(stored_seeds(folder, env, quality), tops[env])
    for column, place in enumerate(PLACES):
        bottom = figure.add_subplot(grid[1, column])
        bottom.set_title(f"{place.title}, test")
        _adaptation(stored_seeds(folder, place.env, quality), bottom, place.goal, place.earned)
    for axes in (*figure.axes[1:3], *figure.axes[4:]):
        axes.set_ylabel("")
    _one_legend(figure, figure.axes)
    return figure


def _training(stored: Mapping[str, Sequence[Path]], axes: Axes) -> None:
    """Draw learning curves, or say that there are none."""
    if not stored:
        _none_stored(axes)
        return
    curves = {
        name: [load_curve(run / "curve.csv") for run in seeds] for name, seeds in stored.items()
    }
    plotting.learning_curves(curves, axes)


def _adaptation(
    stored: Mapping[str, Sequence[Path]], axes: Axes, goal: str | None, earned: float
) -> None:
    """Draw returns on test tasks by adaptation step, and the demonstrator's return."""
    if not stored:
        return
    tested = {name: [returns_by_step(run, goal) for run in seeds] for name, seeds in stored.items()}
    plotting.adaptation_steps(tested, axes)
    axes.axhline(earned, color="#777777", linewidth=1.2, label="_demonstrator")


def _none_stored(axes: Axes) -> None:
    axes.text(0.5, 0.5, "no stored runs", transform=axes.transAxes, ha="center")


def _one_legend(figure: Figure, panels: Sequence[Axes]) -> None:
    """Put one legend of all algorithms above the figure in place of one in each panel."""
    named: dict[str, object] = {}
    for axes in panels:
        lines, labels = axes.get_legend_handles_labels()
        named |= dict(zip(labels, lines, strict=True))
        if axes.get_legend():
            axes.get_legend().remove()
    names = [plotting.label(name) for name in plotting.LOOKS if plotting.label(name) in named]
    figure.legend([named[name] for name in names], names, loc="outside upper center", ncols=5)


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


def drift(folder: Path, seed: int = 0) -> Figure:
    """Draw TwoWheeled with changing dynamics: training, unseen drifts, paths. Fig. 6, simulated part.

    The paths, a panel per algorithm, are three episodes of its run with ``seed``, after one adaptation
    step, in the unseen task nearest the drift of the paper's robot.
    """
    figure = plt.figure(figsize=(11.0, 6.2))
    names = list(plotting.LOOKS)
    grid = figure.add_gridspec(2, 2 * len(names), height_ratios=(3, 2))
    left, middle = (figure.add_subplot(grid[0, half]) for half in (slice(0, 5), slice(5, 10)))
    stored = stored_seeds(folder, DRIFT, "optimal")
    _training(stored, left)
    _adaptation(stored, middle, None, EARNED[DRIFT])
    unseen = unseen_demonstrations(DRIFT, "optimal", GOALS_SHOWN)
    shown_task = int((unseen.tasks - ROBOT_DRIFT).abs().argmin())
    for place, name in enumerate(names):
        axes = figure.add_subplot(grid[1, 2 * place : 2 * place + 2])
        make(DRIFT).draw_tasks(axes, unseen.tasks)
        axes.set(xlim=(-1.2, 2.6), ylim=(-2.6, 1.8), title=plotting.label(name))
        ylabel = f"drift {float(unseen.tasks[shown_task]):+.2f} rad/s\ny (length units)"
        axes.set(ylabel=ylabel if place == 0 else "")
        for run in stored.get(name, []):
            if run.name.endswith(f"-seed{seed}"):
                rollout = evaluate_run(load_run(run), unseen, 1).rollouts[-1]
                look = {"color": plotting.LOOKS[name]["color"], "linewidth": 1.4}
                plotting.trajectories(rollout, axes, shown_task, 3, **look)
    _one_legend(figure, (left, middle))
    return figure


def sensitivity(folder: Path) -> Figure:
    """Draw EMRLD and EMRLD-WS with five values of w_rl (w_bc = 1) and of w_bc (w_rl = 1). Fig. 7."""
    figure, panels = plt.subplots(2, 2, figsize=(8.4, 5.8), sharex=True, sharey=True)
    for row, varied in zip(panels.T, ("w_rl", "w_bc"), strict=True):
        for axes, algorithm in zip(row, ("emrld", "emrld-ws"), strict=True):
            symbol, fixed = (f"$w_{{\\mathrm{{{part}}}}}$" for part in _pair(varied))
            stored = sensitivity_runs(folder, algorithm, varied)
            labels = {f"{symbol} = {value}": runs for value, runs in stored.items()}
            looks = dict(zip(labels, plotting.shades(algorithm, len(labels)), strict=True))
            _study(labels, looks, axes, SENSITIVITY_END)
            axes.set_title(f"{plotting.label(algorithm)}, {fixed} = 1")
    for axes in panels[0]:
        axes.set_xlabel("")
    for axes in panels[:, 1]:
        axes.set_ylabel("")
    return figure


def _pair(varied: str) -> tuple[str, str]:
    """Return the subscript of the varied weight, then that of the fixed one."""
    return ("rl", "bc") if varied == "w_rl" else ("bc", "rl")


def ablation(folder: Path) -> Figure:
    """Draw EMRLD on Point2D, whole, without cloning and without RL in the adaptation. Fig. 8."""
    figure, panels = plt.subplots(1, 2, figsize=(8.4, 3.4), sharey=True)
    labels = {
        "EMRLD": "EMRLD",
        "w_bc = 0": r"no cloning, $w_{\mathrm{bc}} = 0$",
        "w_rl = 0": r"no RL, $w_{\mathrm{rl}} = 0$",
    }
    without = (("black", ":", "^"), ("#777777", "--", "D"))
    looks = [dict(zip(("color", "linestyle", "marker"), look, strict=True)) for look in without]
    looks = dict(zip(labels.values(), [plotting.LOOKS["emrld"], *looks], strict=True))
    for axes, quality in zip(panels, STEPS_SHOWN, strict=True):
        stored = {labels[name]: runs for name, runs in ablation_runs(folder, quality).items()}
        _study(stored, looks, axes, STUDY_END)
        axes.set_title(f"Point2D, {quality} data")
    panels[1].set_ylabel("")
    return figure


def _study(
    stored: Mapping[str, Sequence[Path]],
    looks: Mapping[str, Mapping[str, object]],
    axes: Axes,
    end: int,
) -> None:
    """Draw the learning curves of one panel of a study up to iteration ``end``."""
    if not stored:
        _none_stored(axes)
        return
    curves = {
        name: [load_curve(run / "curve.csv") for run in runs] for name, runs in stored.items()
    }
    plotting.banded_curves(curves, looks, axes, end)


def switches(folder: Path) -> Figure:
    """Draw what each switch of the ledger leaves of EMRLD-WS's return on unseen goals.

    A row per switch, the control first; one that is stored with a single seed has no interval, and is
    left out.
    """
    figure, axes = plt.subplots(figsize=(7.2, 3.6))
    stored = {name: seeds for name, seeds in switch_runs(folder).items() if len(seeds) > 1}
    if not stored:
        _none_stored(axes)
        return figure
    scores = {name: run_scores(runs, step=1) for name, runs in stored.items()}
    rows = {name: (worst_to_best(seeds), seeds) for name, seeds in scores.items()}
    plotting.forest(rows, axes)
    axes.set_xlabel("return on unseen goals after one step")
    return figure

"""Sliders for one adaptation step on two tasks with one parameter, one flat and one steep.

Task i has the loss h_i / 2 (theta - c_i)^2. The pictures show what a step of length alpha does, what is
left over after it, and where the whole and the first-order meta-gradient come to rest.
"""

from __future__ import annotations

import ipywidgets
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import display
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...validation import real_number
from .answer import as_image

CURVATURES, OPTIMA = np.array([1.0, 9.0]), np.array([-1.0, 1.0])
LARGEST_ALPHA = 0.15  # beyond 2/9 the steep task's step would lead away from its optimum
EDGE = 1.5  # of the meta-parameters that are shown
LOOKS = (("flat task", "#0072B2", "-"), ("steep task", "#D55E00", "--"))


def task_losses(theta: np.ndarray | float) -> np.ndarray:
    """Return both tasks' losses at ``theta``, (task,) or (task, theta)."""
    away = np.subtract.outer(-OPTIMA, -np.asarray(theta))
    return 0.5 * (CURVATURES * (away**2).T).T


def adapted(theta: np.ndarray | float, alpha: float) -> np.ndarray:
    """Return both tasks' parameters one step on from ``theta``, (task,) or (task, theta)."""
    away = np.subtract.outer(-OPTIMA, -np.asarray(theta))
    return np.asarray(theta) - alpha * (CURVATURES * away.T).T


def losses_after(theta: np.ndarray | float, alpha: float) -> np.ndarray:
    """Return both tasks' losses after one step from ``theta``, (task,) or (task, theta)."""
    own = adapted(theta, alpha)
    return 0.5 * (CURVATURES * ((own.T - OPTIMA) ** 2)).T


def resting_points(alpha: float) -> tuple[float, float | None]:
    """Return where the whole and the first-order meta-gradient are zero; None where the latter runs away."""
    real_number("alpha", alpha, 0.0, LARGEST_ALPHA)
    kept = 1.0 - alpha * CURVATURES  # the share of the way to the optimum that a step leaves
    whole, first = CURVATURES * kept**2, CURVATURES * kept
    pulls_back = first.sum() > 1e-9
    return (
        float(whole @ OPTIMA / whole.sum()),
        float(first @ OPTIMA / first.sum()) if pulls_back else None,
    )


def one_step_sliders() -> None:
    """Show sliders for alpha and theta above the two panels."""

    def show(alpha: float, theta: float) -> None:
        display(as_image(one_step_picture(alpha, theta)))

    ipywidgets.interact(
        show,
        alpha=ipywidgets.FloatSlider(
            value=0.1,
            min=0.0,
            max=LARGEST_ALPHA,
            step=0.005,
            readout_format=".3f",
            continuous_update=False,
        ),
        theta=ipywidgets.FloatSlider(
            value=0.0, min=-EDGE, max=EDGE, step=0.1, continuous_update=False
        ),
    )


def two_losses(alpha: float = 0.1, theta: float = 0.0) -> Figure:
    """Return the two losses, their optima, and one step from ``theta`` in either task."""
    figure, axes = plt.subplots(figsize=(6.4, 3.0))
    _draw_step(axes, alpha, theta)
    axes.legend(loc="upper right", ncols=2)
    plt.close(figure)
    return figure


def one_step_picture(alpha: float = 0.1, theta: float = 0.0) -> Figure:
    """Return one step from ``theta`` (left) and the loss after a step from anywhere (right)."""
    real_number("alpha", alpha, 0.0, LARGEST_ALPHA)
    real_number("theta", theta, -EDGE, EDGE)
    # Margins, few ticks and no formulas as text: a layout that is computed takes as long as the picture.
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.0), layout="none")
    figure.subplots_adjust(left=0.07, right=0.99, bottom=0.16, top=0.9, wspace=0.17)
    _draw_step(left, alpha, theta)
    _draw_rest(right, alpha)
    plt.close(figure)
    return figure


def _draw_step(axes: Axes, alpha: float, theta: float) -> None:
    """Draw the losses with their optima, and below them how far one step leads in either task."""
    places = np.linspace(-EDGE, EDGE + 0.5, 141)
    losses, there = task_losses(places), adapted(theta, alpha)
    axes.plot([theta, theta], [-2.2, 6.5], ":", color="#777777", linewidth=1.2)
    for task, (name, colour, line) in enumerate(LOOKS):
        axes.plot(places, losses[task], line, color=colour, label=name)
        axes.plot(OPTIMA[task], 0, "*", color=colour, markersize=13, zorder=3)
        height = -0.9 - 0.9 * task
        look = {"arrowstyle": "->", "color": colour, "linewidth": 2.0, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=(there[task], height), xytext=(theta, height), arrowprops=look)
    axes.set(xlabel="parameter theta", ylabel="loss before the step", ylim=(-2.5, 8.5))
    axes.set(xlim=(-EDGE - 0.1, EDGE + 0.5), xticks=range(-1, 3), yticks=(0, 4, 8))
    axes.set_title(f"one step of alpha = {alpha:.3f} from theta = {theta:.1f}")


def _draw_rest(axes: Axes, alpha: float) -> None:
    places = np.linspace(-EDGE, EDGE, 121)
    left_over = losses_after(places, alpha)
    for task, (name, colour, line) in enumerate(LOOKS):
        axes.plot(places, left_over[task], line, color=colour, linewidth=1.3, label=name)
    axes.plot(places, left_over.mean(0), color="black", linewidth=2.2, label="mean")
    whole, first = resting_points(alpha)
    for name, place, marker in (("whole gradient", whole, "v"), ("first order", first, "^")):
        if place is None:
            axes.plot([], [], " ", label=f"{name} never rests")
        elif abs(place) > EDGE:
            axes.plot([], [], " ", label=f"{name} rests far off, at {place:+.1f}")
        else:
            height = float(losses_after(place, alpha).mean())
            axes.plot(place, height, marker, color="black", markersize=10, zorder=4)
            axes.plot(
                [], [], marker, color="black", label=f"{name} rests at {round(place, 2) + 0.0:+.2f}"
            )
    top = 2.2 * float(left_over.mean(0).max())  # room for the legend
    axes.set(xlabel="meta-parameter theta", ylabel="loss after the step", ylim=(-0.05, top))
    axes.set(xlim=(-EDGE - 0.1, EDGE + 0.1), xticks=(-1, 0, 1), yticks=range(0, int(top) + 1))
    axes.set_title("left over after the step")
    axes.legend(fontsize=8, loc="upper center")

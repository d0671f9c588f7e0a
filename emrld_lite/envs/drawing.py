"""How environments draw themselves: goals, ways and bodies on matplotlib axes, and axes as pixels."""

from __future__ import annotations

import logging
from collections.abc import Callable

import matplotlib.pyplot as plt
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Circle, Polygon, Rectangle
from torch import Tensor

from .goals import GOAL_RADIUS, Goals

logger = logging.getLogger(__name__)

GOAL_COLOUR = "#E69F00"
PATH_COLOUR = "#0072B2"
BODY_COLOUR = "#444444"


def round_goal(axes: Axes, goal: list[float], near: float, strength: float = 0.35) -> None:
    """Draw a goal as a star in the disc that pays a reward, of opacity ``strength``."""
    axes.add_patch(Circle((goal[0], goal[1]), near, color=GOAL_COLOUR, alpha=strength, linewidth=0))
    axes.plot(*goal, marker="*", color="black", markersize=8, linestyle="none", zorder=5)


def goals_in_the_plane(axes: Axes, goals: Goals, near: float) -> None:
    """Draw the start, the goals, and the semicircle that they lie on, if they do.

    The discs of many goals overlap: the more there are, the fainter each is.
    """
    apart = goals.unique(dim=0)
    if (apart.norm(dim=-1) - GOAL_RADIUS).abs().max() < 1e-3:
        angles = np.linspace(0.0, np.pi, 100)
        arc = GOAL_RADIUS * np.cos(angles), GOAL_RADIUS * np.sin(angles)
        axes.plot(*arc, color="grey", linewidth=0.6, zorder=0)
    for goal in apart.tolist():
        round_goal(axes, goal, near, min(0.35, 2.0 / len(apart)))
    axes.plot(0, 0, marker="x", color="black", markersize=7, linestyle="none")
    axes.set_aspect("equal")
    axes.set(xlim=(-2.6, 2.6), ylim=(-1.1, 2.6))
    axes.set(xlabel="x (length units)", ylabel="y (length units)")


def box_goal(axes: Axes, goal: list[float], near: float, box: float) -> None:
    """Draw a goal as a star in the box that ends the episode, in the disc that pays a reward."""
    round_goal(axes, goal, near)
    corner = (goal[0] - box, goal[1] - box)
    axes.add_patch(Rectangle(corner, 2 * box, 2 * box, fill=False, edgecolor="black", linewidth=1))


def path(axes: Axes, states: Float[Tensor, "time state"]) -> None:
    """Draw the way through the states' x and y from a cross at its start."""
    axes.plot(states[:, 0], states[:, 1], color=PATH_COLOUR, linewidth=1.4)
    axes.plot(*states[0, :2].tolist(), marker="x", color="black", markersize=6, linestyle="none")


def robot(axes: Axes, pose: list[float], length: float = 0.22) -> None:
    """Draw a wheeled robot at (x, y, heading): a disc with two wheels and a nose."""
    x, y, heading = pose
    forward = np.array([np.cos(heading), np.sin(heading)])
    left = np.array([-forward[1], forward[0]])
    centre = np.array([x, y])
    axes.add_patch(
        Circle((x, y), 0.45 * length, facecolor="#9BC7E4", edgecolor=BODY_COLOUR, zorder=6)
    )
    for side in (-1, 1):
        middle = centre + side * 0.5 * length * left
        ends = [middle - 0.3 * length * forward, middle + 0.3 * length * forward]
        axes.plot(
            *np.transpose(ends), color=BODY_COLOUR, linewidth=3, solid_capstyle="butt", zorder=7
        )
    nose = [
        centre + 0.75 * length * forward,
        centre + 0.2 * length * left,
        centre - 0.2 * length * left,
    ]
    axes.add_patch(Polygon(nose, facecolor=BODY_COLOUR, zorder=7))


def pixels(draw: Callable[[Axes], None], size: tuple[int, int] = (480, 480)) -> np.ndarray:
    """Return what ``draw`` leaves on a fresh pair of axes, (height, width, 3), uint8."""
    width, height = size
    figure = Figure(
        figsize=(width / 100, height / 100), dpi=100, layout="none"
    )  # whatever the style
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    draw(axes)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


class Window:
    """A window that shows one picture after another, where there is a screen.

    Without one (matplotlib falls back to a backend that draws files) the pictures go nowhere, and the
    log says so.
    """

    def __init__(self, title: str) -> None:
        self._figure, self._axes = plt.subplots(figsize=(4.8, 4.8), num=title)
        self._axes.axis("off")
        self._image: AxesImage | None = None
        if plt.get_backend().lower() in ("agg", "pdf", "svg", "ps", "template"):
            logger.warning(
                'render_mode "human": no screen (matplotlib backend %s); use "rgb_array" for pictures',
                plt.get_backend(),
            )

    def show(self, picture: np.ndarray) -> None:
        """Show ``picture`` (height, width, 3) and let the window breathe."""
        if self._image is None:
            self._image = self._axes.imshow(picture)
        self._image.set_data(picture)
        self._figure.canvas.draw_idle()
        self._figure.canvas.flush_events()

    def close(self) -> None:
        """Close the window."""
        plt.close(self._figure)

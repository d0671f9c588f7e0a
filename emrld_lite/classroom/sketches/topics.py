"""The robot's topics as a drawing: who tells whom what, and how often."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .shapes import DATA, PARAMETERS, arrow, box

TOLD, HEARD = "#9A6A00", "#333333"


def topics() -> Figure:
    """Return a drawing of the loop over ROS: the policy's side, the two topics, the robot's side."""
    figure, axes = plt.subplots(figsize=(9.6, 2.9))
    axes.set(xlim=(0.0, 14.4), ylim=(0.0, 4.3))
    axes.axis("off")
    axes.grid(visible=False)
    box(axes, (1.2, 2.1), "policy", PARAMETERS)
    box(axes, (4.4, 2.1), "environment", PARAMETERS)
    box(axes, (13.0, 2.1), "robot", DATA)
    _curved(axes, (1.9, 2.5), (3.1, 2.5), "action")
    _curved(axes, (3.1, 1.7), (1.9, 1.7), "state, reward")
    arrow(axes, (5.8, 3.0), (12.2, 3.0), "/cmd_vel: velocities, repeated at every reading", TOLD)
    arrow(
        axes, (12.2, 1.2), (5.8, 1.2), "/odom: where the robot believes to be, 40 per second", HEARD
    )
    axes.text(8.8, 2.1, "ROS master: who publishes, who listens", ha="center", fontsize=9)
    axes.text(4.4, 0.35, "one computer", ha="center", fontsize=9, color="#555555")
    axes.text(
        12.6, 0.35, "clamps speeds, stops in silence", ha="center", fontsize=9, color="#555555"
    )
    return figure


def _curved(axes: Axes, start: tuple[float, float], end: tuple[float, float], text: str) -> None:
    """Draw a short arrow with its word above or below."""
    axes.annotate("", xy=end, xytext=start, arrowprops={"arrowstyle": "->", "linewidth": 1.3})
    above = end[0] > start[0]
    middle = ((start[0] + end[0]) / 2, start[1] + (0.35 if above else -0.45))
    axes.text(*middle, text, ha="center", va="center", fontsize=8)

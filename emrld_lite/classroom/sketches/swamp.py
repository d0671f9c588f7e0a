"""The two states that break the substitution, as a drawing made from the family's own tables."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from torch import Tensor

from ...tabular import TabularMDP
from .shapes import DATA, PARAMETERS

PLACES = (1.6, 8.8)  # of the path and of the swamp, from left to right
NAMES = ("the path (start)", "the swamp")
WIDTH, HEIGHT = 2.9, 1.2  # of a state's box


def two_states(axes: Axes, mdp: TabularMDP, policy: Tensor, visits: Tensor | None = None) -> None:
    """Draw where each action leads, what it pays and with which probability the policy takes it.

    The wider an arrow, the likelier it is; one that the policy never takes is thin, dotted and grey.
    With ``visits``, each state says which share of the policy's time it has.
    """
    axes.set(xlim=(-0.2, 10.6), ylim=(-1.1, 2.1))
    axes.axis("off")
    for state, (x, name) in enumerate(zip(PLACES, NAMES, strict=True)):
        corner = (x - WIDTH / 2, -HEIGHT / 2)
        axes.add_patch(
            Rectangle(
                corner, WIDTH, HEIGHT, facecolor=(PARAMETERS, DATA)[state], edgecolor="#555555"
            )
        )
        text = name if visits is None else f"{name}\n{float(visits[state]):.0%} of the time"
        axes.text(x, 0, text, ha="center", va="center", fontsize=10)
        for target in range(2):
            _arrow(axes, mdp, policy, state, target)


def _arrow(axes: Axes, mdp: TabularMDP, policy: Tensor, state: int, target: int) -> None:
    """Draw one arrow for all actions that lead from one state to another, or back into it."""
    actions = [a for a in range(mdp.actions) if mdp.transition[state, a, target] > 0.5]
    share = float(policy[state, actions].sum())
    told = "\n".join(
        f"action {a} pays {float(mdp.reward[state, a]):+.0f}, taken {float(policy[state, a]):.0%}"
        for a in actions
    ).replace("+0", "0")
    colour = "black" if share else "#777777"
    start, end, bend, at = _route(state, target)
    axes.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={
            "arrowstyle": "-|>",
            "color": colour,
            "linewidth": 1 + 2.5 * share,
            "linestyle": "-" if share else ":",
            "connectionstyle": bend,
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )
    axes.text(*at, told, ha="center", va="center", fontsize=8.5, color=colour)


def _route(state: int, target: int) -> tuple[tuple, tuple, str, tuple]:
    """Return where an arrow begins and ends, how it bends, and where its text stands."""
    x, other = PLACES[state], PLACES[target]
    top = HEIGHT / 2
    if state == target:
        return (x - 0.8, top), (x + 0.8, top), "arc3,rad=-0.9", (x, top + 1.1)
    side = 1 if target > state else -1
    height = 0.3 * side
    ends = (x + side * WIDTH / 2, height), (other - side * WIDTH / 2, height)
    return *ends, "arc3,rad=0", ((x + other) / 2, 0.62 if side > 0 else -0.85)

"""The waterfall of Theorem 1: from the true improvement down to the bound, one inequality at a time."""

from __future__ import annotations

from matplotlib.axes import Axes

from ...tabular import proof_lines
from ...tabular.families import Family
from ...tabular.figures import LABELS
from ..proof_drops import DROPS, drops

# the bound that is reached when a drop has been taken
REACHED = {"b_demo": "bound_average_delta", "a_assumption": "bound_group_2"}
LOOKS = {
    "demo": {"color": "#56B4E9", "hatch": ""},
    "assumption": {"color": "#E69F00", "hatch": ".."},
    "old": {"color": "#B0A0C8", "hatch": "//"},
}
TOTAL = {"color": "#444444"}


def waterfall(axes: Axes, family: Family, per_step: bool = False, named: bool = False) -> None:
    """Draw the improvement, what each inequality of the proof takes from it, and the printed bound.

    In returns, or per discounted step: times 1 - gamma. With ``named``, the tighter bounds stand
    where they are reached.
    """
    lines = proof_lines(*family)
    horizon = 1 / (1 - float(family[0][0].discount))
    scale = 1.0 if per_step else horizon
    given_away = {name: scale * float(drop) for name, drop in drops(lines).items()}
    level, bound = (float(side) * scale / horizon for side in (lines[-1].left, lines[-1].right))
    digits, labels = 3 if per_step else 2, ["true improvement"]
    low, high = min(0.0, bound), max(0.0, level)
    _bar(axes, 0, 0.0, level, TOTAL, digits)
    for place, (name, drop) in enumerate(given_away.items(), start=1):
        look = next(look for word, look in LOOKS.items() if name.endswith(word))
        axes.plot([level, level], [place - 1, place], color="#777777", linewidth=0.8)
        _bar(axes, place, level, -drop, look, digits)
        level -= drop
        labels.append(f"less: {DROPS[name]}")
        if named and name in REACHED:
            labels[-1] += f"\n= {LABELS[REACHED[name]]}: {round(level, digits) + 0.0:.{digits}f}"
    axes.plot(
        [level, level], [len(given_away), len(given_away) + 1], color="#777777", linewidth=0.8
    )
    _bar(axes, len(given_away) + 1, 0.0, bound, TOTAL, digits)
    axes.axvline(0, color="black", linewidth=0.8)
    axes.set_yticks(range(len(labels) + 1), [*labels, LABELS["bound"]])
    span = max(high - low, 1e-3)  # where nothing changes and nothing is lost, all bars are 0
    axes.set(xlim=(low - 0.06 * span, high + 0.2 * span))
    axes.set(ylim=(len(labels) + 0.5, -0.6), xlabel="return per step" if per_step else "return")


def _bar(axes: Axes, place: int, start: float, width: float, look: dict, digits: int) -> None:
    """Draw one bar with its number beyond its end on the right."""
    axes.barh(place, width, 0.62, left=start, edgecolor="white", **look)
    axes.annotate(
        f"{width:+.{digits}f}" if abs(width) >= 0.5 * 10**-digits else f"{0:.{digits}f}",
        (max(start, start + width), place),
        (4, 0),
        textcoords="offset points",
        va="center",
        fontsize=9,
    )

"""Null pairs as a drawing: every way to deal the ranks of equally good runs to two sides."""

from __future__ import annotations

from itertools import combinations

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

FIRST, SECOND, MARK = "#0072B2", "white", "#B03A00"


def pairs_lost(mine: tuple[int, ...], runs: int) -> int:
    """Return how many pairs of runs, one of each side, the side with the ranks ``mine`` loses."""
    theirs = set(range(2 * runs)) - set(mine)
    return sum(a < b for a in mine for b in theirs)


def rank_deals(runs: int = 3) -> Figure:
    """Return every deal of 2 * ``runs`` ranks, a column each, in the order of the pairs that are lost.

    Filled circles are runs of the first side; the frame marks the deals in which it loses no pair.
    """
    ranks = range(2 * runs)
    deals = sorted(combinations(ranks, runs), key=lambda mine: (pairs_lost(mine, runs), mine))
    figure, axes = plt.subplots(figsize=(9.4, 3.2))
    for column, mine in enumerate(deals):
        for rank in ranks:
            colour = FIRST if rank in mine else SECOND
            axes.plot(column, rank + 1, "o", color=FIRST, markerfacecolor=colour, markersize=9)
        lost = pairs_lost(mine, runs)
        axes.text(column, 0.1, str(lost), ha="center", va="center", fontsize=10)
        if lost == 0:
            frame = {"fill": False, "edgecolor": MARK, "linewidth": 2}
            axes.add_patch(plt.Rectangle((column - 0.42, 0.5), 0.84, 2 * runs, **frame))
    axes.plot([], [], "o", color=FIRST, label="a run of the first side")
    axes.plot([], [], "o", color=FIRST, markerfacecolor=SECOND, label="a run of the second side")
    axes.set(xlim=(-0.8, len(deals) - 0.2), ylim=(-0.5, 2 * runs + 0.7), xticks=[])
    axes.set_yticks([0.1, *(rank + 1 for rank in ranks)], ["pairs lost", *(r + 1 for r in ranks)])
    axes.set_ylabel("rank of the score")
    axes.grid(visible=False)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure

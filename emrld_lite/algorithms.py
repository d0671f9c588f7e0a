"""The algorithms of the comparison as data: one row each; only their settings differ besides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .adapt import Adaptation
from .learners import Adam, Learner, Trpo

W_RL = {"optimal": 0.2, "suboptimal": 1.0}  # Table 1, "0.2/1"
W_BC = 1.0  # Table 1


@dataclass(frozen=True)
class Algorithm:
    """One row of the comparison: what happens in the adaptation step and in the meta-update."""

    name: str
    """Name on the command line."""
    label: str
    """Name in figures and tables."""
    warm_start: bool
    """Whether one cloning step precedes the adaptation."""
    w_rl: float | None
    """Weight of RL in the adaptation; None: by the data's quality, as in Table 1."""
    w_bc: float
    """Weight of behaviour cloning in the adaptation."""
    learner: type[Learner]
    """What makes the meta-update: TRPO on D^val, or Adam on the demonstrations' likelihood."""

    def adaptation(self, quality: str, **settings: Any) -> Adaptation:
        """Return this row's adaptation for data of ``quality``.

        A setting of Adaptation that is given, and not None, replaces the row's or the default.
        """
        row = {
            "w_rl": W_RL[quality] if self.w_rl is None else self.w_rl,
            "w_bc": self.w_bc,
            "warm_start": self.warm_start,
        }
        given = {name: value for name, value in settings.items() if value is not None}
        return Adaptation(**{**row, **given})


ALGORITHMS = {
    row.name: row
    for row in (
        Algorithm("emrld", "EMRLD", warm_start=False, w_rl=None, w_bc=W_BC, learner=Trpo),
        Algorithm("emrld-ws", "EMRLD-WS", warm_start=True, w_rl=None, w_bc=W_BC, learner=Trpo),
        Algorithm("maml", "MAML", warm_start=False, w_rl=1.0, w_bc=0.0, learner=Trpo),
        Algorithm("meta-bc", "Meta-BC", warm_start=False, w_rl=0.0, w_bc=1.0, learner=Adam),
        Algorithm("gmps", "GMPS", warm_start=False, w_rl=1.0, w_bc=0.0, learner=Adam),
    )
}

"""The algorithms of the comparison as data: one row each, and nothing else differs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .adapt import Adaptation

W_RL = {"optimal": 0.2, "suboptimal": 1.0}  # Table 2, "0.2/1"
W_BC = 1.0  # Table 2


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
    """Weight of RL in the adaptation; None: by the data's quality, as in Table 2."""
    w_bc: float
    """Weight of behaviour cloning in the adaptation."""
    meta_update: Literal["rl", "bc"]
    """"rl": TRPO on D^val; "bc": Adam on the demonstrations' likelihood after adaptation."""

    def adaptation(
        self,
        quality: str,
        adapt_lr: float = 0.01,
        w_rl: float | None = None,
        w_bc: float | None = None,
        bc_reduction: str = "mean",
    ) -> Adaptation:
        """Return this row's adaptation for data of ``quality``; ``w_rl`` and ``w_bc`` override it."""
        default_w_rl = W_RL[quality] if self.w_rl is None else self.w_rl
        return Adaptation(
            w_rl=default_w_rl if w_rl is None else w_rl,
            w_bc=self.w_bc if w_bc is None else w_bc,
            warm_start=self.warm_start,
            adapt_lr=adapt_lr,
            bc_reduction=bc_reduction,
        )


ALGORITHMS = {
    row.name: row
    for row in (
        Algorithm("emrld", "EMRLD", warm_start=False, w_rl=None, w_bc=W_BC, meta_update="rl"),
        Algorithm("emrld-ws", "EMRLD-WS", warm_start=True, w_rl=None, w_bc=W_BC, meta_update="rl"),
        Algorithm("maml", "MAML", warm_start=False, w_rl=1.0, w_bc=0.0, meta_update="rl"),
        Algorithm("meta-bc", "Meta-BC", warm_start=False, w_rl=0.0, w_bc=1.0, meta_update="bc"),
        Algorithm("gmps", "GMPS", warm_start=False, w_rl=1.0, w_bc=0.0, meta_update="bc"),
    )
}

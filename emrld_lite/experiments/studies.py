"""Which stored runs belong to which study: sensitivity, ablation, the ledger's switches, changing dynamics.

The first three vary one thing on Point2D and compare with a control that stands in the main
comparison; the grids are data/grids/{sensitivity,ablation,switches,drift}.toml.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..trpo import TrustRegion
from ..validation import check_choice
from .results import seeds_of

WEIGHTS = (0.2, 0.4, 0.6, 0.8, 1.0)
SENSITIVITY_END = 100  # iterations of every run in the sensitivity study
STUDY_END = 150  # iterations of every run in the ablation and among the switches
CONTROL = "as the workbook does it"
AS_STORED = {
    "log_density": "joint",
    "meta_momentum": 0.0,
    "trust_region": TrustRegion(damping=0.1, fisher_samples=200),
}
"""What was the default when the stored runs were made, and is no longer."""
SWITCHES = {
    "fixed-sigma": "sigma fixed at 1",
    "exact-steps": "steps of length exactly 0.1",
    "averaged-log-density": "log-density averaged over dimensions",
    "summed-cloning": "cloning loss summed",
    "first-order": "first-order meta-gradient",
    "aliased-cg": "aliased conjugate gradient",
    "reward-elsewhere": "reward of 1e-5 elsewhere",
    "no-normalisation": "advantages not normalised",
}


class Reading(NamedTuple):
    """One way to read Section 4.2's experiment: how the drift acts, and what a policy sees."""

    title: str
    env: str
    heading: bool
    """Whether the heading is in the state; the paper's text has S in R^2."""
    runs: str
    """What its runs are called before the quality of their data."""


READINGS = tuple(
    Reading(f"{drift}, heading {seen}", env, heading, env + ("" if heading else "-headless"))
    for heading, seen in ((True, "seen"), (False, "hidden"))
    for env, drift in (
        ("two_wheeled_drift", "drift a rate"),
        ("two_wheeled_literal_drift", "drift as printed"),
    )
)


def sensitivity_runs(folder: Path, algorithm: str, varied: str) -> dict[float, list[Path]]:
    """Return the runs of one panel of Fig. 7 by the weight ``varied``, w_rl or w_bc; the other is 1."""
    check_choice("varied weight", varied, ("w_rl", "w_bc"))
    found = {}
    for value in WEIGHTS:
        w_rl, w_bc = (value, 1.0) if varied == "w_rl" else (1.0, value)
        name = f"sensitivity-{algorithm}-w_rl{w_rl}-w_bc{w_bc}"
        if (w_rl, w_bc) == (0.2, 1.0):  # Table 1's own setting
            name = f"point2d-optimal-{algorithm}"
        if seeds := seeds_of(folder, name):
            found[value] = seeds
    return found


def ablation_runs(folder: Path, quality: str) -> dict[str, list[Path]]:
    """Return the runs of one panel of Fig. 8: EMRLD, without cloning, without RL.

    With sub-optimal data w_rl is 1, so EMRLD without cloning is MAML.
    """
    without_cloning = {"optimal": "ablation-optimal-w_bc0.0", "suboptimal": "point2d-optimal-maml"}
    check_choice("data", quality, without_cloning)
    names = {
        "EMRLD": f"point2d-{quality}-emrld",
        "w_bc = 0": without_cloning[quality],
        "w_rl = 0": f"ablation-{quality}-w_rl0.0",
    }
    found = {label: seeds_of(folder, name) for label, name in names.items()}
    return {label: seeds for label, seeds in found.items() if seeds}


def switch_runs(folder: Path) -> dict[str, list[Path]]:
    """Return the runs of each switch of the ledger by what it changes; the control comes first."""
    names = {CONTROL: "point2d-optimal-emrld-ws"}
    names |= {label: f"switch-{name}" for name, label in SWITCHES.items()}
    found = {label: seeds_of(folder, name) for label, name in names.items()}
    return {label: seeds for label, seeds in found.items() if seeds}

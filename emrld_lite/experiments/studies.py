"""Which stored runs belong to which study: sensitivity, ablation, the ledger's switches, changing dynamics.

The first three vary one thing and compare with runs that have everything else alike: sensitivity and
switches with the main comparison's, the ablation with controls that have the defaults of when it was
run. The grids are data/grids/{sensitivity,ablation,switches,controls,drift}.toml.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..validation import check_choice
from .results import seeds_of

WEIGHTS = (0.2, 0.4, 0.6, 0.8, 1.0)
SENSITIVITY_END = {"emrld": 200, "emrld-ws": 100}  # iterations: those of the main comparison
STUDY_END = 150  # iterations of every run in the ablation
CONTROL = "as the workbook does it"
SWITCHES = {
    "fixed-sigma": "sigma fixed at 1",
    "exact-steps": "steps of length exactly 0.1",
    "joint-log-density": "log-density of the joint action",
    "summed-cloning": "cloning loss summed",
    "first-order": "first-order meta-gradient",
    "aliased-cg": "aliased conjugate gradient",
    "reward-elsewhere": "reward of 1e-5 elsewhere",
    "no-normalisation": "advantages not normalised",
    "first-20-of-30": "first 20 episodes to end, of 30",
    "xavier": "released start of the network",
    "no-momentum": "no momentum in the meta-update",
    "damping-0.1": "Fisher matrix damped by 0.1",
    "kl-0.01": "KL bound of 0.01, not 0.02",
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


def control_runs(folder: Path, env: str, quality: str, algorithm: str) -> list[Path]:
    """Return the runs that the ablation of one environment, data and algorithm is compared with."""
    stem = f"{env}-{quality}-{algorithm}"
    return seeds_of(folder, f"control-{stem}") or seeds_of(folder, stem)  # HalfCheetah's


def sensitivity_runs(folder: Path, algorithm: str, varied: str) -> dict[float, list[Path]]:
    """Return the runs of one panel of Fig. 7 by the weight ``varied``, w_rl or w_bc; the other is 1."""
    check_choice("varied weight", varied, ("w_rl", "w_bc"))
    found = {}
    for value in WEIGHTS:
        w_rl, w_bc = (value, 1.0) if varied == "w_rl" else (1.0, value)
        seeds = seeds_of(folder, f"sensitivity-{algorithm}-w_rl{w_rl}-w_bc{w_bc}")
        if (w_rl, w_bc) == (0.2, 1.0):  # Table 1's own setting
            seeds = seeds_of(folder, f"point2d-optimal-{algorithm}")
        if seeds:
            found[value] = seeds
    return found


def ablation_runs(folder: Path, quality: str) -> dict[str, list[Path]]:
    """Return the runs of one panel of Fig. 8: EMRLD, without cloning, without RL.

    With sub-optimal data w_rl is 1, so EMRLD without cloning is MAML.
    """
    check_choice("data", quality, ("optimal", "suboptimal"))
    without_cloning = {
        "optimal": seeds_of(folder, "ablation-optimal-w_bc0.0"),
        "suboptimal": control_runs(folder, "point2d", "optimal", "maml"),
    }
    found = {
        "EMRLD": control_runs(folder, "point2d", quality, "emrld"),
        "w_bc = 0": without_cloning[quality],
        "w_rl = 0": seeds_of(folder, f"ablation-{quality}-w_rl0.0"),
    }
    return {label: seeds for label, seeds in found.items() if seeds}


def switch_runs(folder: Path) -> dict[str, list[Path]]:
    """Return the runs of each switch of the ledger by what it changes; the control comes first."""
    found = {CONTROL: seeds_of(folder, "point2d-optimal-emrld-ws")}
    found |= {label: seeds_of(folder, f"switch-{name}") for name, label in SWITCHES.items()}
    return {label: seeds for label, seeds in found.items() if seeds}

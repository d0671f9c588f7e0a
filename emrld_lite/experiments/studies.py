"""Which stored runs belong to which study: sensitivity, ablation, the ledger's switches, changing dynamics.

The first three vary one thing and compare with runs that have everything else alike, most often the
main comparison's. The grids are data/grids/{sensitivity,ablation,switches,drift}.toml.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..algorithms import ALGORITHMS
from ..validation import check_choice
from .evaluation import SAMPLED
from .results import TITLES, run_scores, seeds_of, training_scores
from .runs import load_config

WEIGHTS = (0.2, 0.4, 0.6, 0.8, 1.0)
SENSITIVITY_END = {"emrld": 200, "emrld-ws": 100}  # iterations: those of the main comparison
ABLATION_END = 200  # iterations after which Fig. 8 compares, as long as the main comparison
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

    @property
    def narrow(self) -> str:
        """What its runs on training drifts of at most NARROW_DRIFT are called, likewise."""
        return f"{self.env}-narrow{self.runs.removeprefix(self.env)}"

    @property
    def cut(self) -> str:
        """What its runs on demonstrations with the steering cut are called (where there are any)."""
        return f"{self.env}-cut{self.runs.removeprefix(self.env)}"


NARROW_DRIFT = 0.3  # the largest training drift of data/demonstrations/ENV-narrow.npz
READINGS = tuple(
    Reading(f"{drift}, heading {seen}", env, heading, env + ("" if heading else "-headless"))
    for heading, seen in ((True, "seen"), (False, "hidden"))
    for env, drift in (
        ("two_wheeled_drift", "drift a rate"),
        ("two_wheeled_literal_drift", "drift as printed"),
    )
)

# what follows Reading.narrow in the name of EMRLD-WS's runs with an alpha of 0.003 in place of 0.01
SHORTER_STEP = "-alpha0.003"

# the drift a rate, where the demonstrations' steering can be cut to what the robot does
CUT_READINGS = (READINGS[0], READINGS[2])


class Pair(NamedTuple):
    """Runs with one part of the algorithm changed, and the runs that have everything else alike."""

    title: str
    env: str
    changed: str
    """What the changed runs are called before their seed."""
    control: str
    """What their control is called before its seed; it may be longer, and is cut at the same iteration."""

    def end(self, folder: Path) -> int:
        """Return after how many iterations the two are compared: those of the changed runs."""
        return load_config(self.runs(folder)[0][0]).iterations

    def runs(self, folder: Path) -> tuple[list[Path], list[Path]]:
        """Return the changed runs and their control's, one per seed."""
        return seeds_of(folder, self.changed), seeds_of(folder, self.control)

    def scores(self, folder: Path) -> tuple[np.ndarray, np.ndarray]:
        """Return the late training returns of the changed runs and of their control, (seed,) each."""
        changed, control = self.runs(folder)
        end = self.end(folder)
        return training_scores(changed, end), training_scores(control, end)

    def tested(self, folder: Path, table: str = SAMPLED) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the scores of both on test tasks after one step, (seed,) each.

        None where the control was trained longer: stored are the tests of finished policies only.
        ``table`` is the file that says so, with sampled actions or by the mean action.
        """
        changed, control = self.runs(folder)
        if load_config(control[0]).iterations != self.end(folder):
            return None
        return run_scores(changed, 1, table=table), run_scores(control, 1, table=table)


def _without_rl(env: str, quality: str, algorithm: str) -> Pair:
    """Return the pair that leaves RL out of the adaptation in a run of the main comparison."""
    whole = f"{env}-{quality}-{algorithm}"
    title = f"{TITLES[env]}, {quality}, {ALGORITHMS[algorithm].label}"
    return Pair(title, env, f"ablation-{whole}-w_rl0.0", whole)


def _without_rl_where(title: str, name: str, w_rl: float) -> Pair:
    """Return the pair that leaves RL out of the adaptation of EMRLD on Point2D in another setting."""
    stem = f"ablation-{name}-emrld-w_rl"
    return Pair(title, "point2d", f"{stem}0.0", f"{stem}{w_rl}")


WITHOUT_RL = (  # where the question of Fig. 8 is asked beyond its own two panels
    _without_rl("point2d", "optimal", "emrld-ws"),
    _without_rl("point2d", "suboptimal", "emrld-ws"),
    _without_rl("two_wheeled", "suboptimal", "emrld"),
    _without_rl("two_wheeled", "suboptimal", "emrld-ws"),
    _without_rl_where("data that mislead", "poor", 1.0),
    _without_rl_where("first 20 of 30, sub-optimal", "first-20-of-30-suboptimal", 1.0),
    _without_rl_where("cloning loss summed", "summed", 0.2),
    _without_rl_where("sigma fixed", "fixed-sigma", 0.2),
    _without_rl_where("all as the paper prints", "as-printed", 0.2),
)

_AGAIN = "ablation-again-two_wheeled-suboptimal-emrld-ws-w_rl"
WITHOUT_RL_AGAIN = Pair(  # the one loss that WITHOUT_RL shows, with seeds that no one had seen
    "TwoWheeled, suboptimal, EMRLD-WS, five new seeds",
    "two_wheeled",
    f"{_AGAIN}0.0",
    f"{_AGAIN}1.0",
)

CLONING_ALONE = (  # cloning in the meta-update, as in Meta-BC, in place of RL; both adapt by cloning alone
    Pair(
        "sigma learned",
        "point2d",
        "ablation-point2d-optimal-meta-bc-cloning-trpo",
        "ablation-point2d-optimal-emrld-w_rl0.0",
    ),
    Pair(
        "sigma fixed",
        "point2d",
        "ablation-fixed-sigma-meta-bc-cloning-trpo",
        "ablation-fixed-sigma-emrld-w_rl0.0",
    ),
)

_DOUBLE_USE = "ablation-point2d-optimal-emrld-"
DOUBLE_USE = (
    tuple(  # Section 3's "double use of the demonstration data": cloning in EMRLD's meta-update
        Pair(title, "point2d", _DOUBLE_USE + changed, "point2d-optimal-emrld")
        for title, changed in (
            ("in place of D^val", "cloning-trpo"),
            ("beside it, weight 1", "rl-and-cloning-trpo"),
            ("beside it, weight 0.1", "rl-and-cloning-trpo-w_bc0.1"),
            ("beside it, weight 0.01", "rl-and-cloning-trpo-w_bc0.01"),
        )
    )
)


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
    """Return the runs of one panel of Fig. 8: EMRLD, without cloning, without RL."""
    check_choice("data", quality, ("optimal", "suboptimal"))
    whole = f"point2d-{quality}-emrld"
    found = {
        "EMRLD": seeds_of(folder, whole),
        "w_bc = 0": seeds_of(folder, f"ablation-{whole}-w_bc0.0"),
        "w_rl = 0": seeds_of(folder, f"ablation-{whole}-w_rl0.0"),
    }
    return {label: seeds for label, seeds in found.items() if seeds}


def switch_runs(folder: Path) -> dict[str, list[Path]]:
    """Return the runs of each switch of the ledger by what it changes; the control comes first."""
    found = {CONTROL: seeds_of(folder, "point2d-optimal-emrld-ws")}
    found |= {label: seeds_of(folder, f"switch-{name}") for name, label in SWITCHES.items()}
    return {label: seeds for label, seeds in found.items() if seeds}

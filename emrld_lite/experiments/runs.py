"""Stored runs as they are read: what a run's folder holds, refused where it was changed or damaged."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import torch

from .. import storage
from ..config import TrainConfig
from ..demonstrations import Demonstrations, load_demonstrations
from ..learners import LEARNERS, Trpo
from ..policy import Params
from ..train import Record
from ..trpo import TrustRegion
from ..validation import InputError, number, real_number, shown, whole_number

LEFT_OUT = "left out"  # what a policy's file says of a memory that it does not hold
OLD_NAMES = {"adam_mean.": "adam.exp_avg.", "adam_square.": "adam.exp_avg_sq."}  # in older runs
BEFORE = {"log_density": "joint", "meta_momentum": 0.0}  # in runs older than the setting
SHIPPED = storage.DATA / "runs"


class Run(NamedTuple):
    """A stored run: its configuration, curve, last meta-policy, and what its learner remembers."""

    config: TrainConfig
    curve: tuple[Record, ...]
    meta_params: Params
    learner_state: Params
    demonstrations: str | None = None
    """Fingerprint of the demonstrations; None in runs that were stored before it was."""

    def load_demonstrations(self) -> Demonstrations:
        """Return the demonstrations it was trained on; others in their place raise InputError."""
        source, env = self.config.demos, self.config.env
        found = load_demonstrations(source, env)
        if self.demonstrations not in (None, found.fingerprint()):
            raise InputError(
                f"demos: expected the demonstrations that the run was trained on, but {source!r} "
                "holds others now: put the old ones back, or train a new run"
            )
        return found


def load_run(folder: Path) -> Run:
    """Read a run; its curve ends with the iteration of its policy. Damage raises InputError."""
    folder = Path(folder)
    config = load_config(folder)
    theta = config.initial_policy()
    path = folder / "policy.safetensors"
    tensors, facts = _read_policy(path, theta, config.learner(theta).state())
    iterations = _iterations(path, facts, config.env)
    curve = load_curve(folder / "curve.csv")
    if len(curve) < iterations:
        raise InputError(
            f"{folder / 'curve.csv'}: expected at least {iterations} rows, got {len(curve)}"
        )
    curve = curve[:iterations]  # a kill after the curve was written leaves it ahead of the policy
    if facts.get("curve") not in (None, curve_fingerprint(curve)):
        raise InputError(f"{folder / 'curve.csv'}: not the curve of {path}: a row was changed")
    if facts.get("tensors") not in (None, tensor_fingerprint(tensors)):
        raise InputError(f"{path}: not as it was stored: a number was changed")
    meta_params = {name: tensors.pop(name) for name in theta}
    return Run(config, curve, meta_params, tensors, facts.get("demonstrations"))


def _iterations(path: Path, facts: dict[str, str], env: str) -> int:
    """Return after how many iterations a policy was stored; raises InputError if it does not say."""
    if facts.get("environment") != env:
        raise InputError(
            f"{path}: environment: expected {env!r} as in config.json, "
            f"got {shown(facts.get('environment'))}"
        )
    return whole_number(f"{path}: iterations", facts.get("iterations"), minimum=1)


def load_config(folder: Path) -> TrainConfig:
    """Read the configuration of a run; unknown or wrong entries raise InputError."""
    path = Path(folder) / "config.json"
    entries = BEFORE | storage.read_json(path, "run configuration")
    unknown = sorted(set(entries) - set(_names(TrainConfig())))
    if unknown:
        raise InputError(f"{path}: unknown entries: {', '.join(unknown)}")
    try:
        region = TrustRegion(**entries.pop("trust_region", {}))
        return TrainConfig(**entries, trust_region=region)
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: {error}") from error


def load_curve(path: Path) -> tuple[Record, ...]:
    """Read curve.csv; a cell that cannot be, or a row out of its place, raises InputError with its line."""
    rows = storage.read_csv(path, "learning curve", Record._fields, optional=("unmoved",))
    return tuple(_record(f"{path}: line {n + 2}", n, row) for n, row in enumerate(rows))


def _record(where: str, place: int, row: dict[str, str]) -> Record:
    """Return one row of a curve, which must be that of iteration ``place``."""
    counts = ("iteration", "env_steps", "backtracks", "unmoved")
    values: dict[str, Any] = {"note": row["note"]}
    for name, cell in row.items():
        if name in counts and not (name == "unmoved" and not cell):  # not counted in older runs
            values[name] = whole_number(f"{where}: {name}", cell)
        elif name not in (*counts, "note"):
            values[name] = number(f"{where}: {name}", cell, finite=name != "kl")
    if values["iteration"] != place:
        raise InputError(
            f"{where}: iteration: expected {place}, since every iteration has one row, in order, "
            f"got {values['iteration']}"
        )
    real_number(f"{where}: success_after", values["success_after"], 0.0, 1.0)
    return Record(**values)


def _read_policy(path: Path, theta: Params, memory: Params) -> tuple[Params, dict[str, str]]:
    """Return the tensors of a policy's file, in the order of ``theta`` and ``memory``, and its facts.

    Raises InputError unless they are finite and of these names and shapes. A file that says that the
    learner's memory was left out holds none.
    """
    tensors, facts = storage.read_tensors(path, "policy")
    expected = theta if facts.get("memory") == LEFT_OUT else {**theta, **memory}
    for old, new in OLD_NAMES.items():
        tensors = {name.replace(old, new): value for name, value in tensors.items()}
    if "adam_step" in facts:  # where older runs kept it
        steps = torch.tensor(number(f"{path}: adam_step", facts["adam_step"]))
        tensors |= {name: steps for name in expected if name.startswith("adam.step.")}
    found = storage.fitting(path, tensors, expected)
    for name, value in found.items():
        if name.startswith(("adam.step.", "adam.exp_avg_sq.")) and (value < 0).any():
            raise InputError(f"{path}: {name}: expected no negative number, got one")
    return found, facts


def curve_fingerprint(curve: Sequence[Record]) -> str:
    """Return a hash of a curve as it is stored."""
    text = storage.csv_text(Record._fields, curve_cells(curve))
    return hashlib.sha256(text.encode()).hexdigest()


def curve_cells(curve: Sequence[Record]) -> list[list[str]]:
    """Return a curve as text that gives back the same numbers; None is an empty cell."""
    return [["" if value is None else _cell(value) for value in record] for record in curve]


def _cell(value: float | str) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def tensor_fingerprint(tensors: Params) -> str:
    """Return a hash of named tensors, in whatever order and on whatever device they are."""
    digest = hashlib.sha256()
    for name, value in sorted(tensors.items()):
        digest.update(name.encode() + value.detach().cpu().numpy().astype("<f4").tobytes())
    return digest.hexdigest()


def differences(one: TrainConfig, other: TrainConfig) -> list[str]:
    """Return the names of the settings in which two runs differ.

    TRPO's bound counts as it acts, its region and momentum only where TRPO makes the meta-update.
    """
    dim = one.environment().action_dim

    def as_it_acts(config: TrainConfig) -> TrainConfig:
        learner = config.learner_type()
        named = next(name for name, kind in LEARNERS.items() if kind is learner)
        region, momentum = config.trust_region.for_actions(dim), config.meta_momentum
        if not issubclass(learner, Trpo):
            region, momentum = TrustRegion(), 0.0
        return dataclasses.replace(
            config, meta_update=named, trust_region=region, meta_momentum=momentum
        )

    one, other = as_it_acts(one), as_it_acts(other)
    return [name for name in _names(one) if getattr(one, name) != getattr(other, name)]


def _names(config: TrainConfig) -> list[str]:
    return [entry.name for entry in dataclasses.fields(config)]

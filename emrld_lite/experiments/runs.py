"""Stored runs: a folder that is always whole, resumes where it was killed, and says how it was made."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import torch

from .. import storage
from ..config import TrainConfig
from ..demonstrations import load_demonstrations
from ..learners import Trpo
from ..policy import Params
from ..train import Iterate, Record, meta_train
from ..trpo import TrustRegion
from ..validation import InputError, shaped
from .machine import provenance

CHECKPOINT_EVERY = 10  # iterations
OLD_NAMES = {"adam_mean.": "adam.exp_avg.", "adam_square.": "adam.exp_avg_sq."}  # in older runs
BEFORE = {"log_density": "joint", "meta_momentum": 0.0}  # in runs older than the setting
SHIPPED = storage.DATA / "runs"


class Run(NamedTuple):
    """A stored run: its configuration, curve, last meta-policy, and what its learner remembers."""

    config: TrainConfig
    curve: tuple[Record, ...]
    meta_params: Params
    learner_state: Params


def train_run(
    config: TrainConfig,
    out: Path,
    resume: bool = False,
    device: str = "cpu",
    on_iteration: Callable[[Iterate], None] = lambda iterate: None,
    command: str | None = None,
) -> Run:
    """Meta-train and keep ``out`` up to date: config.json, curve.csv, policy.safetensors.

    A checkpoint is written every CHECKPOINT_EVERY iterations, at the end, and when the run is
    interrupted. With ``resume``, a run that was stopped, even killed, goes on from its last
    checkpoint to the same curve. ``command`` is what the provenance says made the run; by default
    this program's own. Raises InputError when ``out`` already holds a run that was not
    asked to resume, or one of another configuration.
    """
    out = Path(out)
    demonstrations = load_demonstrations(config.demos, config.env)
    stored = latest = _start(config, out, resume, command)
    try:
        for iterate in meta_train(
            config,
            demonstrations,
            stored.meta_params,
            stored.curve,
            stored.learner_state,
            device,
        ):
            curve = (*latest.curve, iterate.record)
            latest = Run(config, curve, iterate.meta_params, iterate.learner_state)
            if (iterate.record.iteration + 1) % CHECKPOINT_EVERY == 0:
                save_checkpoint(out, latest)
            on_iteration(iterate)
    finally:
        if len(latest.curve) > len(stored.curve):
            save_checkpoint(out, latest)
    return latest


def _start(config: TrainConfig, out: Path, resume: bool, command: str | None) -> Run:
    """Prepare ``out``; returns the run to go on from, one without a record if it is new."""
    theta = config.initial_policy()
    fresh = Run(config, (), theta, config.learner(theta).state())
    if not (out / "config.json").exists():
        if resume:
            raise InputError(f"{out}: nothing to resume: no config.json there")
        storage.write_json(out / "config.json", dataclasses.asdict(config))
        storage.write_json(out / "provenance.json", provenance(command))
        return fresh
    if not resume:
        raise InputError(f"{out}: already holds a run; choose another folder, or pass --resume")
    changed = differences(config, load_config(out))
    if changed := [name for name in changed if name not in ("iterations", "stop_at_return")]:
        raise InputError(f"{out}: cannot resume with other settings: {', '.join(changed)} differ")
    storage.write_json(out / "config.json", dataclasses.asdict(config))
    return load_run(out) if (out / "policy.safetensors").exists() else fresh


def save_checkpoint(out: Path, run: Run) -> None:
    """Write the curve, then the policy with its iteration: what is on disk always fits together.

    The learner's memory is in the policy's file: the two always belong together.
    """
    storage.write_csv(Path(out) / "curve.csv", Record._fields, [_cells(row) for row in run.curve])
    facts = {"iterations": str(len(run.curve)), "environment": run.config.env}
    tensors = {**run.meta_params, **run.learner_state}
    storage.write_tensors(Path(out) / "policy.safetensors", tensors, facts)


def _cells(record: Record) -> list[str]:
    """Return a record as text that gives back the same numbers; None is an empty cell."""
    cells = [repr(value) if isinstance(value, float) else str(value) for value in record]
    return ["" if value is None else cell for value, cell in zip(record, cells, strict=True)]


def load_run(folder: Path) -> Run:
    """Read a run; its curve ends with the iteration of its policy. Damage raises InputError."""
    folder = Path(folder)
    config = load_config(folder)
    theta = config.initial_policy()
    tensors, facts = _read_policy(
        folder / "policy.safetensors", {**theta, **config.learner(theta).state()}
    )
    curve = load_curve(folder / "curve.csv")
    iterations = int(facts.get("iterations", "0"))
    if len(curve) < iterations:
        raise InputError(
            f"{folder / 'curve.csv'}: expected at least {iterations} rows, got {len(curve)}"
        )
    meta_params = {name: tensors.pop(name) for name in theta}
    return Run(config, curve[:iterations], meta_params, tensors)


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
    """Read curve.csv; a cell that is no number raises InputError with its line."""
    rows = storage.read_csv(path, "learning curve", Record._fields, optional=("unmoved",))
    kinds = {"iteration": int, "env_steps": int, "backtracks": int, "note": str}
    kinds["unmoved"] = lambda cell: int(cell) if cell else None
    records = []
    for line, row in enumerate(rows, start=2):
        try:
            records.append(Record(**{k: kinds.get(k, float)(v) for k, v in row.items()}))
        except (TypeError, ValueError) as error:
            raise InputError(f"{path}: line {line}: {error}") from error
    return tuple(records)


def _read_policy(path: Path, expected: Params) -> tuple[Params, dict[str, str]]:
    """Return the tensors of a policy's file, in the order of ``expected``, and its facts.

    Raises InputError unless they are finite and of the names and shapes of ``expected``.
    """
    tensors, facts = storage.read_tensors(path, "policy")
    for old, new in OLD_NAMES.items():
        tensors = {name.replace(old, new): value for name, value in tensors.items()}
    if "adam_step" in facts:  # where older runs kept it
        steps = torch.tensor(float(facts["adam_step"]))
        tensors |= {name: steps for name in expected if name.startswith("adam.step.")}
    if set(tensors) != set(expected):
        raise InputError(f"{path}: expected tensors {sorted(expected)}, got {sorted(tensors)}")
    for name, value in expected.items():
        shaped(f"{path}: {name}", tensors[name], tuple(value.shape))
    return {name: tensors[name] for name in expected}, facts


def differences(one: TrainConfig, other: TrainConfig) -> list[str]:
    """Return the names of the settings in which two runs differ.

    TRPO's bound counts as it acts, its region and momentum only where TRPO makes the meta-update.
    """
    dim = one.environment().action_dim

    def as_it_acts(config: TrainConfig) -> TrainConfig:
        region = config.trust_region.for_actions(dim)
        used = config.comparison_row().learner is Trpo
        if used:
            return dataclasses.replace(config, trust_region=region)
        return dataclasses.replace(config, trust_region=TrustRegion(), meta_momentum=0.0)

    one, other = as_it_acts(one), as_it_acts(other)
    return [name for name in _names(one) if getattr(one, name) != getattr(other, name)]


def _names(config: TrainConfig) -> list[str]:
    return [entry.name for entry in dataclasses.fields(config)]

"""Stored runs: a folder that is always whole, resumes where it was killed, and says how it was made."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import torch

from .. import storage
from ..config import TrainConfig
from ..demonstrations import Demonstrations, load_demonstrations
from ..learners import Trpo
from ..policy import Params
from ..train import Iterate, Record, meta_train
from ..trpo import TrustRegion
from ..validation import InputError, number, real_number, shown, whole_number
from .budget import check_training
from .machine import provenance, resumption, stored_provenance

CHECKPOINT_EVERY = 10  # iterations
FILES = ("config.json", "curve.csv", "policy.safetensors", "provenance.json")
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
    out = storage.check_target("out", out, folder=True)
    stored = latest = _start(config, out, resume, command)
    demonstrations = stored.load_demonstrations()
    try:
        for iterate in meta_train(
            config,
            demonstrations,
            stored.meta_params,
            stored.curve,
            stored.learner_state,
            device,
        ):
            latest = latest._replace(
                curve=(*latest.curve, iterate.record),
                meta_params=iterate.meta_params,
                learner_state=iterate.learner_state,
            )
            if (iterate.record.iteration + 1) % CHECKPOINT_EVERY == 0:
                save_checkpoint(out, latest)
            on_iteration(iterate)
    finally:
        if len(latest.curve) > len(stored.curve):
            save_checkpoint(out, latest)
    return latest


def _start(config: TrainConfig, out: Path, resume: bool, command: str | None) -> Run:
    """Prepare ``out``; returns the run to go on from, one without a record if it is new.

    Whatever may fail comes before the first file is written, and config.json, which makes a folder
    a run, is the last one written.
    """
    begun = (out / "config.json").exists()
    if resume and not begun:
        raise InputError(f"{out}: nothing to resume: no config.json there")
    if begun and not resume:
        raise InputError(f"{out}: already holds a run; choose another folder, or pass --resume")
    run = _resumed(config, out) if begun else _fresh(config)
    demonstrations = run.load_demonstrations()
    check_training(config, len(demonstrations.tasks))
    if begun:
        stored = stored_provenance(out)
        storage.clean_up(out, FILES)
        written = resumption(stored, len(run.curve))
    else:
        stored, written = {}, provenance(command)
    if written != stored:
        storage.write_json(out / "provenance.json", written)
    if not begun or load_config(out) != config:
        storage.write_json(out / "config.json", dataclasses.asdict(config))
    return run._replace(demonstrations=demonstrations.fingerprint())


def _fresh(config: TrainConfig) -> Run:
    """Return a run before its first iteration."""
    theta = config.initial_policy()
    return Run(config, (), theta, config.learner(theta).state())


def _resumed(config: TrainConfig, out: Path) -> Run:
    """Return the run in ``out``, to go on as ``config`` says; raises InputError for other settings."""
    changed = differences(config, load_config(out))
    if changed := [name for name in changed if name not in ("iterations", "stop_at_return")]:
        raise InputError(f"{out}: cannot resume with other settings: {', '.join(changed)} differ")
    if not (out / "policy.safetensors").exists():
        return _fresh(config)
    run = load_run(out)
    if len(run.curve) > config.iterations:
        raise InputError(
            f"iterations: expected at least the {len(run.curve)} that {out} has, "
            f"got {config.iterations}"
        )
    return run._replace(config=config)


def save_checkpoint(out: Path, run: Run) -> None:
    """Write the curve, then the policy with its iteration: what is on disk always fits together.

    The learner's memory is in the policy's file, with fingerprints of it, of the curve and of the
    demonstrations: what does not belong together, or was changed, is noticed when it is read.
    Raises InputError, and writes nothing, for numbers that are not finite: none could be read back.
    """
    tensors = {**run.meta_params, **run.learner_state}
    facts = {
        "iterations": str(len(run.curve)),
        "environment": run.config.env,
        "curve": _curve_fingerprint(run.curve),
        "tensors": _tensor_fingerprint(tensors),
    }
    if run.demonstrations is not None:
        facts["demonstrations"] = run.demonstrations
    storage.check_finite(out / "policy.safetensors", tensors)
    storage.write_csv(Path(out) / "curve.csv", Record._fields, [_cells(row) for row in run.curve])
    storage.write_tensors(Path(out) / "policy.safetensors", tensors, facts)


def _curve_fingerprint(curve: tuple[Record, ...]) -> str:
    """Return a hash of a curve as it is stored."""
    text = storage.csv_text(Record._fields, [_cells(row) for row in curve])
    return hashlib.sha256(text.encode()).hexdigest()


def _tensor_fingerprint(tensors: Params) -> str:
    """Return a hash of named tensors, in whatever order and on whatever device they are."""
    digest = hashlib.sha256()
    for name, value in sorted(tensors.items()):
        digest.update(name.encode() + value.detach().cpu().numpy().astype("<f4").tobytes())
    return digest.hexdigest()


def _cells(record: Record) -> list[str]:
    """Return a record as text that gives back the same numbers; None is an empty cell."""
    cells = [repr(value) if isinstance(value, float) else str(value) for value in record]
    return ["" if value is None else cell for value, cell in zip(record, cells, strict=True)]


def load_run(folder: Path) -> Run:
    """Read a run; its curve ends with the iteration of its policy. Damage raises InputError."""
    folder = Path(folder)
    config = load_config(folder)
    theta = config.initial_policy()
    path = folder / "policy.safetensors"
    tensors, facts = _read_policy(path, {**theta, **config.learner(theta).state()})
    iterations = _iterations(path, facts, config.env)
    curve = load_curve(folder / "curve.csv")
    if len(curve) < iterations:
        raise InputError(
            f"{folder / 'curve.csv'}: expected at least {iterations} rows, got {len(curve)}"
        )
    curve = curve[:iterations]  # a kill after the curve was written leaves it ahead of the policy
    if facts.get("curve") not in (None, _curve_fingerprint(curve)):
        raise InputError(f"{folder / 'curve.csv'}: not the curve of {path}: a row was changed")
    if facts.get("tensors") not in (None, _tensor_fingerprint(tensors)):
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


def _read_policy(path: Path, expected: Params) -> tuple[Params, dict[str, str]]:
    """Return the tensors of a policy's file, in the order of ``expected``, and its facts.

    Raises InputError unless they are finite and of the names and shapes of ``expected``.
    """
    tensors, facts = storage.read_tensors(path, "policy")
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

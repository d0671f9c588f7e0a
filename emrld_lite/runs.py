"""Stored runs: a folder that is always whole, resumes where it was killed, and says how it was made."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from . import demonstrations as demonstration_files
from . import storage
from .config import TrainConfig
from .machine import provenance
from .policy import Params, initialise
from .supervised_update import Moments
from .train import Iterate, Record, meta_train
from .trpo import TrustRegion
from .validation import InputError, shaped

CHECKPOINT_EVERY = 10  # iterations
ADAM_PREFIXES = ("adam_mean.", "adam_square.")  # of Adam's tensors in policy.safetensors
SHIPPED = Path(__file__).resolve().parent.parent / "data" / "runs"


class Run(NamedTuple):
    """A stored run: its configuration, one record an iteration, its last meta-policy, Adam's memory."""

    config: TrainConfig
    curve: tuple[Record, ...]
    meta_params: Params
    moments: Moments | None = None


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
    demonstrations = demonstration_files.find(config.demos, config.env)
    curve, meta_params, moments = _start(config, out, resume, command)
    latest = Run(config, curve, meta_params, moments)
    try:
        for iterate in meta_train(config, demonstrations, meta_params, curve, device, moments):
            curve_so_far = (*latest.curve, iterate.record)
            latest = Run(config, curve_so_far, iterate.meta_params, iterate.moments)
            if (iterate.record.iteration + 1) % CHECKPOINT_EVERY == 0:
                save_checkpoint(out, latest)
            on_iteration(iterate)
    finally:
        if len(latest.curve) > len(curve):
            save_checkpoint(out, latest)
    return latest


def _start(
    config: TrainConfig, out: Path, resume: bool, command: str | None
) -> tuple[tuple[Record, ...], Params | None, Moments | None]:
    """Prepare ``out``; returns the records, policy and moments to go on from, or nothing and None."""
    if not (out / "config.json").exists():
        if resume:
            raise InputError(f"{out}: nothing to resume: no config.json there")
        storage.write_json(out / "config.json", dataclasses.asdict(config))
        storage.write_json(out / "provenance.json", provenance(command))
        return (), None, None
    if not resume:
        raise InputError(f"{out}: already holds a run; choose another folder, or pass --resume")
    changed = differences(config, load_config(out))
    if changed := [name for name in changed if name not in ("iterations", "stop_at_return")]:
        raise InputError(f"{out}: cannot resume with other settings: {', '.join(changed)} differ")
    storage.write_json(out / "config.json", dataclasses.asdict(config))
    if not (out / "policy.safetensors").exists():
        return (), None, None
    run = load_run(out)
    return run.curve, run.meta_params, run.moments


def save_checkpoint(out: Path, run: Run) -> None:
    """Write the curve, then the policy with its iteration: what is on disk always fits together."""
    storage.write_csv(Path(out) / "curve.csv", Record._fields, [_cells(row) for row in run.curve])
    facts = {"iterations": str(len(run.curve)), "environment": run.config.env}
    tensors = dict(run.meta_params)
    if run.moments is not None:  # in the same file: policy and memory always belong together
        facts["adam_step"] = str(run.moments.step)
        for prefix, part in zip(ADAM_PREFIXES, (run.moments.mean, run.moments.square), strict=True):
            tensors |= {prefix + name: value for name, value in part.items()}
    storage.write_tensors(Path(out) / "policy.safetensors", tensors, facts)


def _cells(record: Record) -> list[str]:
    """Return a record as text that gives back the same numbers."""
    return [repr(value) if isinstance(value, float) else str(value) for value in record]


def load_run(folder: Path) -> Run:
    """Read a run; its curve ends with the iteration of its policy. Damage raises InputError."""
    folder = Path(folder)
    config = load_config(folder)
    path = folder / "policy.safetensors"
    tensors, facts = storage.read_tensors(path, "policy")
    prefixes = ("", *ADAM_PREFIXES) if "adam_step" in facts else ("",)
    _check_policy(path, config, tensors, prefixes)
    meta_params, *memory = (_with_prefix(tensors, prefix) for prefix in prefixes)
    moments = Moments(int(facts["adam_step"]), *memory) if memory else None
    curve = load_curve(folder / "curve.csv")
    iterations = int(facts.get("iterations", "0"))
    if len(curve) < iterations:
        raise InputError(
            f"{folder / 'curve.csv'}: expected at least {iterations} rows, got {len(curve)}"
        )
    return Run(config, curve[:iterations], meta_params, moments)


def load_config(folder: Path) -> TrainConfig:
    """Read the configuration of a run; unknown or wrong entries raise InputError."""
    path = Path(folder) / "config.json"
    entries = storage.read_json(path, "run configuration")
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
    rows = storage.read_csv(path, "learning curve", Record._fields)
    kinds = {"iteration": int, "env_steps": int, "backtracks": int, "note": str}
    records = []
    for line, row in enumerate(rows, start=2):
        try:
            records.append(Record(**{k: kinds.get(k, float)(v) for k, v in row.items()}))
        except (TypeError, ValueError) as error:
            raise InputError(f"{path}: line {line}: {error}") from error
    return tuple(records)


def _with_prefix(tensors: Params, prefix: str) -> Params:
    """Return the tensors whose names are a parameter's after ``prefix``, under the parameter's name."""
    return {
        name.removeprefix(prefix): value
        for name, value in tensors.items()
        if name.startswith(prefix) and "." not in name.removeprefix(prefix)
    }


def _check_policy(
    path: Path, config: TrainConfig, tensors: Params, prefixes: tuple[str, ...]
) -> None:
    """Raise InputError unless ``tensors`` fit the run's environment, once for each prefix."""
    environment = config.environment()
    policy = initialise(
        environment.state_dim, environment.action_dim, 0, learn_sigma=config.learn_sigma
    )
    expected = {prefix + name: value for prefix in prefixes for name, value in policy.items()}
    if set(tensors) != set(expected):
        raise InputError(f"{path}: expected tensors {sorted(expected)}, got {sorted(tensors)}")
    for name, value in expected.items():
        shaped(f"{path}: {name}", tensors[name], tuple(value.shape))


def differences(one: TrainConfig, other: TrainConfig) -> list[str]:
    """Return the names of the settings in which two runs differ.

    TRPO's bound counts as it acts, and its region only where TRPO makes the meta-update.
    """
    dim = one.environment().action_dim

    def as_it_acts(config: TrainConfig) -> TrainConfig:
        region = config.trust_region.for_actions(dim)
        unused = config.row().meta_update == "bc"
        return dataclasses.replace(config, trust_region=TrustRegion() if unused else region)

    one, other = as_it_acts(one), as_it_acts(other)
    return [name for name in _names(one) if getattr(one, name) != getattr(other, name)]


def _names(config: TrainConfig) -> list[str]:
    return [entry.name for entry in dataclasses.fields(config)]

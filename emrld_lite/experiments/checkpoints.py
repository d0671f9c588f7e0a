"""Checkpoints: a run's folder is whole at every moment, and goes on from where it was killed."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

from .. import storage
from ..config import TrainConfig
from ..train import Iterate, Record, meta_train
from ..validation import InputError
from .budget import check_training
from .machine import provenance, resumption, stored_provenance
from .runs import (
    LEFT_OUT,
    Run,
    curve_cells,
    curve_fingerprint,
    differences,
    load_config,
    load_run,
    tensor_fingerprint,
)

CHECKPOINT_EVERY = 10  # iterations
FILES = ("config.json", "curve.csv", "policy.safetensors", "provenance.json")


def train_run(
    config: TrainConfig,
    out: Path,
    resume: bool = False,
    device: str = "cpu",
    on_iteration: Callable[[Iterate], None] = lambda iterate: None,
    command: str | None = None,
    checkpoint_every: int = CHECKPOINT_EVERY,
) -> Run:
    """Meta-train and keep ``out`` up to date: config.json, curve.csv, policy.safetensors.

    A checkpoint is written after every ``checkpoint_every`` iterations, at the end, and when the run is
    interrupted. With ``resume``, a run that was stopped, even killed, goes on from its last
    checkpoint to the same curve; one whose learner's memory was left out goes on with a fresh one, and
    its provenance says so. ``command`` is what the provenance says made the run; by default
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
            if (iterate.record.iteration + 1) % checkpoint_every == 0:
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
        fresh = bool(run.curve) and not run.learner_state and _remembers(run)
        written = resumption(stored, len(run.curve), fresh)
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
    storage.check_finite(out / "policy.safetensors", {**run.meta_params, **run.learner_state})
    storage.write_csv(Path(out) / "curve.csv", Record._fields, curve_cells(run.curve))
    _write_policy(out, run)


def forget_memory(folder: Path) -> None:
    """Store a run's policy without what its learner remembers: a half to a third of the size.

    A run that goes on from it begins with a fresh memory, so not as it would have; its provenance says so.
    """
    run = load_run(folder)
    if run.learner_state:
        _write_policy(folder, run._replace(learner_state={}))


def _remembers(run: Run) -> bool:
    """Return whether the run's learner has a memory; TRPO without momentum has none."""
    return bool(run.config.learner(run.meta_params).state())


def _write_policy(out: Path, run: Run) -> None:
    """Write a run's policy, its learner's memory, and what both belong to."""
    tensors = {**run.meta_params, **run.learner_state}
    facts = {
        "iterations": str(len(run.curve)),
        "environment": run.config.env,
        "curve": curve_fingerprint(run.curve),
        "tensors": tensor_fingerprint(tensors),
    }
    if run.demonstrations is not None:
        facts["demonstrations"] = run.demonstrations
    if not run.learner_state and _remembers(run):
        facts["memory"] = LEFT_OUT
    storage.write_tensors(Path(out) / "policy.safetensors", tensors, facts)

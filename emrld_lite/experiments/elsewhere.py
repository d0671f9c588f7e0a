"""A training in a process of its own, as on another machine, and a stored run repeated that way."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from .. import storage
from ..config import TrainConfig
from ..train import Record
from ..validation import InputError
from .grid import command_of
from .runs import load_config, load_curve

PORTABLE_RUN = storage.DATA / "portable"  # made with the variables of machine.PORTABLE


def train_elsewhere(
    config: TrainConfig, out: Path, threads: int, variables: Mapping[str, str]
) -> tuple[Record, ...]:
    """Train in a new process with more environment ``variables``; returns the curve.

    A run that ``out`` holds already goes on. Raises InputError, with the process's last line, for a
    training that failed.
    """
    words = shlex.split(command_of(config, str(out), threads))[1:]
    if (Path(out) / "config.json").exists():
        words.append("--resume")
    done = subprocess.run(
        [sys.executable, *words],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise InputError(f"{out}: the training failed: {last}")
    return load_curve(Path(out) / "curve.csv")


def repeat(folder: Path, out: Path, iterations: int | None = None) -> tuple[Record, ...]:
    """Make a stored run again in ``out``, with its threads and variables; returns the new curve.

    By default all of its iterations, or only the first ``iterations``.
    """
    config = load_config(folder)
    facts = storage.read_json(Path(folder) / "provenance.json", "provenance")
    config = replace(config, iterations=iterations or config.iterations)
    return train_elsewhere(config, out, facts["threads"], facts.get("variables", {}))

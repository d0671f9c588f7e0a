"""The machine: how many threads pay, what decides a sum's last bits, and what made a run."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import torch

from .. import storage
from ..limits import thread_count
from ..validation import InputError, shown

PORTABLE = {
    "ATEN_CPU_CAPABILITY": "default",
    "ONEDNN_MAX_CPU_ISA": "SSE41",
    "MKL_CBWR": "COMPATIBLE",
}
"""Environment variables with which AMD's processors add up in the same order, 1.6 times slower.

Tried on two (cpu family 23, model 1, and cpu family 25, model 17). An Intel Xeon (cpu family 6, model 207)
has other digits all the same: the KL of the first update differs by six parts in a million.
"""
ALIKE = (
    "cpu family 23, model 1,",
    "cpu family 25, model 17,",
)  # of AMD, as ``processor`` says them
LOTS = {
    "own": {},
    "plain": {"ATEN_CPU_CAPABILITY": "default"},
    "compatible": {"MKL_CBWR": "COMPATIBLE"},
    "portable": PORTABLE,
}
"""Environment variables that make this machine another one as far as digits go; ``own`` has none."""
PACKAGES = ("torch", "numpy", "gymnasium", "mujoco")


def choose_threads() -> int:
    """Return 2 if two torch threads are faster than one right now, else 1.

    On a quiet machine two threads are faster; while another process holds a core they wait for each
    other at every operation and are slower than one. A little work of the losses' kind tells.
    """
    if (os.cpu_count() or 1) < 2:
        return 1
    seconds = {}
    left, right = torch.ones(12, 500, 100), torch.ones(12, 100, 100)
    before = torch.get_num_threads()
    for threads in (1, 2):
        torch.set_num_threads(threads)
        torch.relu(left @ right)
        started = time.perf_counter()
        for _ in range(30):
            torch.relu(left @ right)
        seconds[threads] = time.perf_counter() - started
    torch.set_num_threads(before)
    return 2 if seconds[2] < 0.8 * seconds[1] else 1


def use_threads(threads: int | None) -> None:
    """Use ``threads``, or as many as are fastest; more than the machine has cores are refused."""
    chosen = choose_threads() if threads is None else thread_count("threads", threads)
    torch.set_num_threads(chosen)


def stored_threads(folder: Path) -> int | None:
    """Return the number of threads that a run was made with; None where it was not written down.

    Raises InputError for a number that this machine has no cores for.
    """
    threads = stored_provenance(folder).get("threads")
    if threads is None:
        return None
    where = Path(folder) / "provenance.json"
    return thread_count(f"{where}: threads, in place of which --threads can be given", threads)


def stored_provenance(folder: Path) -> dict[str, Any]:
    """Return what a run's provenance.json says, nothing where it is missing; damage raises InputError."""
    path = Path(folder) / "provenance.json"
    if not path.exists():
        return {}
    stored = storage.read_json(path, "provenance")
    resumed = stored.get("resumed", [])
    if not isinstance(resumed, list) or not all(isinstance(one, dict) for one in resumed):
        raise InputError(f"{path}: resumed: expected a list of objects, got {shown(resumed)}")
    return stored


def processor() -> str:
    """Return what decides the last bits of a sum: the processor's kind and its vector instructions.

    Two machines of which this says the same give the same curves, digit for digit, with the same
    versions and threads.
    """
    said = {}
    if (facts := Path("/proc/cpuinfo")).exists():
        pairs = (line.partition(":") for line in facts.read_text().splitlines())
        said = {key.strip(): value.strip() for key, _, value in pairs}
    name = said.get("model name") or platform.processor() or platform.machine()
    kinds = [f"{key} {said[key]}" for key in ("cpu family", "model", "stepping") if key in said]
    return ", ".join([name, *kinds, torch.backends.cpu.get_cpu_capability()])


def repeats_digits(made: Mapping[str, Any]) -> bool:
    """Return whether this machine was seen to repeat digits that were made with PORTABLE.

    ``made`` is the provenance of what is to be repeated. The versions of torch and numpy must be the same,
    and both processors must be of the two models that were tried; of others nothing is known.
    """
    here = {name: metadata.version(name) for name in ("torch", "numpy")}
    processors = (made.get("processor", ""), processor())
    return (
        made.get("variables") == PORTABLE
        and here.items() <= made["versions"].items()
        and all(one.startswith("AMD") and any(kind in one for kind in ALIKE) for one in processors)
    )


def provenance(command: str | None = None) -> dict[str, Any]:
    """Return what made a run: versions, commit, machine, threads, and the command (by default this one)."""
    return {
        "versions": {name: metadata.version(name) for name in PACKAGES}
        | {"python": platform.python_version()},
        "commit": _commit(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "processor": processor(),
        "threads": torch.get_num_threads(),
        "variables": {name: os.environ[name] for name in PORTABLE if name in os.environ},
        "command": command or " ".join(["python", "-m", "emrld_lite", *sys.argv[1:]]),
    }


def _commit() -> str:
    """Return the commit of this code; "unknown" outside a clone, and on a machine without git."""
    command = ["git", "rev-parse", "HEAD"]
    try:
        git = subprocess.run(
            command, cwd=Path(__file__).parent, capture_output=True, text=True, check=False
        )
    except OSError:  # no git here
        return "unknown"
    return git.stdout.strip() or "unknown"


def resumption(
    stored: dict[str, Any], iteration: int, fresh_memory: bool = False
) -> dict[str, Any]:
    """Return a run's provenance with what is other than at its start, where it goes on.

    A provenance that was lost is begun anew, with the iteration from which it holds. ``fresh_memory``
    says that the learner's memory had been left out.
    """
    here = provenance()
    if not stored:
        return {**here, "from_iteration": iteration}
    latest = {**stored, **{k: v for one in stored.get("resumed", []) for k, v in one.items()}}
    other = {
        fact: here[fact] for fact in here if fact != "command" and here[fact] != latest.get(fact)
    }
    if fresh_memory:
        other["memory"] = "fresh"
    if not other:
        return stored
    return {
        **stored,
        "resumed": [*stored.get("resumed", []), {"from_iteration": iteration, **other}],
    }

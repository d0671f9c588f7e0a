"""A class on one server: ``python -m emrld_lite.classroom.crowd --students 20`` measures what each waits for.

Every student has a notebook kernel of their own. All import what notebook 06 imports, then all train for
a few iterations, at the same time. Memory is the proportional set size, in which shared pages count once.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from jupyter_client import BlockingKernelClient, KernelManager

from ..validation import InputError, positive_count

LIVE_RUN = 40  # iterations of notebook 06's training, in the median of twenty seeds
IMPORTS = """
import torch, ipywidgets
import matplotlib.pyplot as plt
from emrld_lite import policy, train
from emrld_lite.classroom import by_hand
from emrld_lite.classroom import checks as check
from emrld_lite.classroom.widgets import adaptation, learning_curve
from emrld_lite.config import TrainConfig
from emrld_lite.demonstrations import load_demonstrations
torch.set_num_threads(1)
"""
TRAINING = """
config = TrainConfig(algorithm="emrld-ws", demos="optimal", seed=0, iterations={iterations})
for _ in train.meta_train(config, load_demonstrations("optimal", "point2d")):
    pass
"""
LONGEST = 3600.0  # seconds that a cell may take


class Waits(NamedTuple):
    """What students wait for, one entry each."""

    imports: list[float]
    """Seconds until the imports are done."""
    iteration: list[float]
    """Seconds of one meta-iteration."""
    at_rest: list[float]
    """Memory after the imports, MB (10^6 bytes); empty where the system does not say."""
    training: list[float]
    """Memory during the training, MB."""


def megabytes(pid: int) -> float | None:
    """Return the proportional set size of a process, None where the system does not say."""
    try:
        said = Path(f"/proc/{pid}/smaps_rollup").read_text()
    except OSError:
        return None
    found = re.search(r"^Pss:\s+(\d+) kB", said, re.MULTILINE)
    return int(found[1]) * 1024 / 1e6 if found else None


def together(clients: list[BlockingKernelClient], code: str) -> list[float]:
    """Run a cell in every kernel at the same time; returns each one's seconds. An error raises InputError."""
    began = time.perf_counter()
    waiting = {client.execute(code): (place, client) for place, client in enumerate(clients)}
    seconds = [0.0] * len(clients)
    for message, (place, client) in waiting.items():
        reply = client.get_shell_msg(timeout=LONGEST)
        while reply["parent_header"].get("msg_id") != message:
            reply = client.get_shell_msg(timeout=LONGEST)
        if reply["content"]["status"] != "ok":
            raise InputError(f"a kernel stopped: {reply['content'].get('evalue', 'no message')}")
        seconds[place] = time.perf_counter() - began
    return seconds


def measure(students: int, iterations: int = 3) -> Waits:
    """Let so many students open notebook 06 and train at the same time."""
    positive_count("students", students)
    positive_count("iterations", iterations)
    with tempfile.TemporaryDirectory() as folder:
        return _measured([_manager(f"{folder}/{number}") for number in range(students)], iterations)


def _manager(place: str) -> KernelManager:
    """Return what starts a kernel: over files where there are some, since free ports are soon taken."""
    return KernelManager() if os.name == "nt" else KernelManager(transport="ipc", ip=place)


def _measured(managers: list[KernelManager], iterations: int) -> Waits:
    """Return what the students of some kernels wait for."""
    clients = []
    try:
        for manager in managers:
            manager.start_kernel()
            client = manager.blocking_client()
            client.start_channels()
            clients.append(client)
        for client in clients:
            client.wait_for_ready(timeout=LONGEST)
        imports = together(clients, IMPORTS)
        pids = [manager.provisioner.pid for manager in managers]
        at_rest = [size for pid in pids if (size := megabytes(pid)) is not None]
        whole = together(clients, TRAINING.format(iterations=iterations))
        training = [size for pid in pids if (size := megabytes(pid)) is not None]
    finally:
        for client in clients:
            client.stop_channels()
        for manager in managers:
            if manager.has_kernel:
                manager.shutdown_kernel(now=True)
    return Waits(imports, [seconds / iterations for seconds in whole], at_rest, training)


def report(students: int, waits: Waits) -> str:
    """Return the medians in a line."""
    pace = statistics.median(waits.iteration)
    memory = "unknown"
    if waits.at_rest and waits.training:
        sizes = (statistics.median(part) for part in (waits.at_rest, waits.training))
        memory = "{:.0f} MB at rest, {:.0f} MB after training".format(*sizes)
    return (
        f"{students} students: imports {statistics.median(waits.imports):.0f} s; memory of a kernel "
        f"{memory}; an iteration {pace:.1f} s, so a live run of {LIVE_RUN} takes "
        f"{pace * LIVE_RUN / 60.0:.0f} min"
    )


def main() -> None:
    """Measure one student, then the class."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--students", type=int, default=20)
    parser.add_argument("--iterations", type=int, default=3)
    options = parser.parse_args()
    for students in sorted({1, options.students}):
        print(report(students, measure(students, options.iterations)), flush=True)


if __name__ == "__main__":
    main()

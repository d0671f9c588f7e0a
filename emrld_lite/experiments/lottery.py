"""The lottery of seeds and processors: one training under several lots, and how long each took.

A lot is another machine as far as the digits go: sums are added up in another order, after a few
iterations the curves part, and only what holds under every lot may be claimed.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import storage
from ..config import TrainConfig
from ..validation import InputError, lookup
from .elsewhere import train_elsewhere
from .grid import options_of
from .machine import LOTS

TARGET = 70.0  # return of which the lottery asks how long it takes
STORED = storage.DATA / "lottery.csv"


class Draw(NamedTuple):
    """One training of the lottery, a row of its table."""

    env: str
    """Environment."""
    algorithm: str
    """Row of the comparison."""
    demos: str
    """Quality of the demonstrations."""
    options: str
    """What was asked for beside the defaults, as on the command line."""
    settings: str
    """The first digits of the hash of everything that decides the run but its seed."""
    lot: str
    """Which machine was played."""
    threads: int
    """CPU threads."""
    seed: int
    """Seed of the run."""
    target: float
    """Mean return after adaptation at which the training ends."""
    budget: int
    """Meta-iterations after which it gives up."""
    reached: int | None
    """Meta-iterations to the target, or None where the budget was used up."""
    best: float
    """Highest mean return after adaptation."""
    seconds: float
    """Seconds of training, beside whatever else the machine did."""


def settings_hash(config: TrainConfig) -> str:
    """Return the first digits of the hash of every setting but seed, budget and target.

    Only what differs from the default counts: a draw stays valid when a new switch, left off, is added.
    """
    chosen = asdict(replace(config, seed=0, iterations=1, stop_at_return=None))
    default = asdict(TrainConfig(seed=0, iterations=1))
    settings = {name: value for name, value in chosen.items() if value != default[name]}
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:8]


def play(config: TrainConfig, lot: str, threads: int, folder: Path) -> Draw:
    """Train ``config`` under a lot in a process of its own, or go on with its run in ``folder``.

    Raises InputError for an unknown lot, and for a training that failed, with its last line.
    """
    if config.stop_at_return is None:
        raise InputError("stop_at_return: expected the return that ends a draw, got None")
    variables = lookup("lot", lot, LOTS)
    try:
        curve = train_elsewhere(config, folder, threads, variables)
    except InputError as error:
        raise InputError(f"lot {lot}, seed {config.seed}: {error}") from error
    returns = [row.return_after for row in curve]
    return Draw(
        env=config.env,
        algorithm=config.algorithm,
        demos=config.demos,
        options=" ".join(options_of(replace(config, stop_at_return=None))),
        settings=settings_hash(config),
        lot=lot,
        threads=threads,
        seed=config.seed,
        target=config.stop_at_return,
        budget=config.iterations,
        reached=len(curve) if returns[-1] >= config.stop_at_return else None,
        best=round(max(returns), 2),
        seconds=round(curve[-1].seconds, 1),
    )


def lottery(
    config: TrainConfig,
    seeds: Sequence[int],
    lots: Sequence[str],
    threads: Sequence[int],
    out: Path,
    folder: Path,
    workers: int = 1,
) -> Iterator[Draw]:
    """Play every combination that the table ``out`` does not hold yet; yields each draw when it is done.

    A draw that gave up after a smaller budget than the present one goes on. The table is written
    anew after every draw, and the runs grow in ``folder``, so a lottery that was stopped goes on.
    Raises InputError for an unknown lot before any training.
    """
    for lot in lots:
        lookup("lot", lot, LOTS)
    known = load_draws(out) if out.exists() else []
    have = {_key(draw) for draw in known if _ended(draw, config.iterations)}
    with ThreadPoolExecutor(workers) as pool:
        waiting = []
        for seed in seeds:
            for lot in lots:
                for count in threads:
                    chosen = replace(config, seed=seed)
                    said = "_".join([settings_hash(chosen), lot, f"{count}t", f"seed{seed}"])
                    place = folder / f"{chosen.env}-{chosen.demos}-{chosen.algorithm}-{said}"
                    key = (settings_hash(chosen), lot, count, seed, chosen.stop_at_return)
                    if key not in have:
                        waiting.append(pool.submit(play, chosen, lot, count, place))
        try:
            for future in as_completed(waiting):
                draw = future.result()
                known = [other for other in known if _key(other) != _key(draw)] + [draw]
                write_draws(out, known)
                yield draw
        finally:
            pool.shutdown(cancel_futures=True)


def _key(draw: Draw) -> tuple[str, str, int, int, float]:
    return (draw.settings, draw.lot, draw.threads, draw.seed, draw.target)


def _ended(draw: Draw, budget: int) -> bool:
    """Return whether ``budget`` iterations would tell nothing more."""
    return draw.reached is not None or draw.budget >= budget


def write_draws(path: Path, draws: Sequence[Draw]) -> None:
    """Write the table of a lottery, sorted, an empty cell where the target was not reached."""
    rows = sorted(draws, key=lambda draw: (*map(str, draw[:7]), draw.seed))
    cells = [["" if value is None else value for value in draw] for draw in rows]
    storage.write_csv(path, Draw._fields, cells)


def load_draws(path: Path = STORED) -> list[Draw]:
    """Read the table of a lottery; a cell that is no number raises InputError with its line."""
    kinds = {"threads": int, "seed": int, "budget": int}
    kinds |= {"target": float, "best": float, "seconds": float}
    kinds["reached"] = lambda cell: int(cell) if cell else None
    draws = []
    for line, row in enumerate(storage.read_csv(path, "lottery", Draw._fields), start=2):
        try:
            draws.append(Draw(**{name: kinds.get(name, str)(cell) for name, cell in row.items()}))
        except (TypeError, ValueError) as error:
            raise InputError(f"{path}: line {line}: {error}") from error
    return draws


def grouped(draws: Sequence[Draw]) -> dict[tuple[str, str, int], list[Draw]]:
    """Return the draws by what was trained (in words), lot and threads, in the order of the table."""
    groups: dict[tuple[str, str, int], list[Draw]] = {}
    for draw in draws:
        name = f"{draw.env} {draw.demos} {draw.algorithm} {draw.options}".strip()
        groups.setdefault((name, draw.lot, draw.threads), []).append(draw)
    return dict(sorted(groups.items()))


def median_and_latest(draws: Sequence[Draw]) -> tuple[float, float]:
    """Return the median and the largest number of iterations to the target.

    A draw that did not reach it counts as later than all others, infinite.
    """
    waits = [np.inf if draw.reached is None else draw.reached for draw in draws]
    return float(np.quantile(waits, 0.5, method="inverted_cdf")), float(max(waits))


def summary(draws: Sequence[Draw]) -> str:
    """Return how the draws came out as a Markdown table, a line per training, lot and threads."""
    lines = [
        "| training | lot | threads | seeds | reached | median | latest | seconds |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for (name, lot, threads), group in grouped(draws).items():
        reached = sum(draw.reached is not None for draw in group)
        middle, latest = (
            "none" if np.isinf(wait) else f"{wait:.0f}" for wait in median_and_latest(group)
        )
        seconds = f"{np.median([draw.seconds for draw in group]):.0f}"
        cells = [name, lot, threads, len(group), reached, middle, latest, seconds]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)

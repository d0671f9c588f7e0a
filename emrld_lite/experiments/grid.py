"""A grid of runs in a TOML file: each block is the product of its lists, each run a folder by name."""

from __future__ import annotations

import itertools
import math
import shlex
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from string import Formatter
from typing import Any

from .. import storage
from ..config import TrainConfig
from ..trpo import TrustRegion
from ..validation import InputError, shown, text

NAME = "{env}-{demos}-{algorithm}-seed{seed}"  # of a run's folder, unless its block has another

MOST_RUNS = 10_000  # of one grid
ALWAYS_SAID = ("env", "algorithm", "demos", "seed", "iterations")


def load_grid(path: Path) -> dict[str, TrainConfig]:
    """Return every run of a grid by the name of its folder.

    The file has ``[[runs]]`` blocks. In each, an option of ``train`` is a value or a list of
    values, and the block stands for all their combinations; ``name`` is the folder's, with options
    in braces. Raises InputError, naming the block, for what cannot be run or is named twice.
    """
    document = storage.read_toml(path, "grid")
    blocks = document.get("runs")
    if set(document) != {"runs"} or not isinstance(blocks, list) or not blocks:
        raise InputError(
            f"{path}: expected [[runs]] blocks and nothing else, got {shown(list(document))}"
        )
    runs: dict[str, TrainConfig] = {}
    for number, block in enumerate(blocks, start=1):
        where = f"{path}: block {number}"
        for name, config in _expand(block, where, MOST_RUNS - len(runs)):
            if name in runs:
                raise InputError(f"{where}: a second run named {name!r}; give the block a `name`")
            runs[name] = config
    return runs


def _expand(block: dict[str, Any], where: str, most: int) -> Iterator[tuple[str, TrainConfig]]:
    """Yield the runs of one block, the product of its lists, of which there may be ``most``."""
    if not isinstance(block, dict) or not set(block) - {"name"}:
        raise InputError(f"{where}: expected options of train, at least one, got {shown(block)}")
    options = {key: value for key, value in block.items() if key != "name"}
    template = _template(block.get("name", NAME), where)
    allowed = {entry.name for entry in fields(TrainConfig)} - {"trust_region"}
    region_options = {entry.name for entry in fields(TrustRegion)}
    if unknown := sorted(set(options) - allowed - region_options):
        raise InputError(f"{where}: unknown options: {', '.join(unknown)}")
    lists = {key: value if isinstance(value, list) else [value] for key, value in options.items()}
    count = math.prod(len(values) for values in lists.values())
    if not 1 <= count <= most:
        raise InputError(
            f"{where}: expected 1 to {most} runs (a grid has {MOST_RUNS} at most), got {count:.7g}"
        )
    for values in itertools.product(*lists.values()):
        chosen = dict(zip(lists, values, strict=True))
        region = {key: chosen.pop(key) for key in list(chosen) if key in region_options}
        try:
            config = TrainConfig(**chosen, trust_region=TrustRegion(**region))
            name = template.format(**{**vars(config), **vars(config.trust_region)})
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
        too_long = len(name.encode()) > storage.LONGEST_NAME - len("..partial.lock")
        if name.startswith(".") or "/" in name or not name.isprintable() or too_long:
            raise InputError(f"{where}: name: expected a folder's name, got {shown(name)}")
        yield name, config


def _template(template: str, where: str) -> str:
    """Return the template of a block's names, if it has options in braces and nothing more in them."""
    known = {entry.name for kind in (TrainConfig, TrustRegion) for entry in fields(kind)}
    try:
        parts = list(Formatter().parse(text(f"{where}: name", template)))
    except ValueError as error:
        raise InputError(f"{where}: name: {shown(template)}: {error}") from None
    for _, option, form, conversion in parts:
        if option is not None and (option not in known or form or conversion):
            raise InputError(f"{where}: name: {shown(template)} has no option {option!r}")
    return template


def command_of(config: TrainConfig, out: str, threads: int = 1) -> str:
    """Return the ``train`` command that makes this run alone: who it is, and what is no default."""
    words = ["python", "-m", "emrld_lite", "train"]
    for option in ALWAYS_SAID:
        words += [f"--{option}", str(getattr(config, option))]
    return shlex.join([*words, *options_of(config), "--threads", str(threads), "--out", out])


def options_of(config: TrainConfig) -> list[str]:
    """Return the words of the command line that ask for what is no default."""
    words = []
    for one, default in [(config, TrainConfig()), (config.trust_region, TrustRegion())]:
        for entry in fields(one):
            value = getattr(one, entry.name)
            said = entry.name in ALWAYS_SAID or entry.name == "trust_region"
            if said or value == getattr(default, entry.name):
                continue
            option = entry.name.replace("_", "-")
            if isinstance(value, bool):
                words.append(f"--{option}" if value else f"--no-{option}")
            else:
                words += [f"--{option}", str(value)]
    return words

"""A grid of runs in a TOML file: each block is the product of its lists, each run a folder by name."""

from __future__ import annotations

import itertools
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

from .. import storage
from ..config import TrainConfig
from ..trpo import TrustRegion
from ..validation import InputError

NAME = "{env}-{demos}-{algorithm}-seed{seed}"  # of a run's folder, unless its block has another

ALWAYS_SAID = ("env", "algorithm", "demos", "seed", "iterations")


def load_grid(path: Path) -> dict[str, TrainConfig]:
    """Return every run of a grid by the name of its folder.

    The file has ``[[runs]]`` blocks. In each, an option of ``train`` is a value or a list of
    values, and the block stands for all their combinations; ``name`` is the folder's, with options
    in braces. Raises InputError, naming the block, for what cannot be run or is named twice.
    """
    text = storage.read_bytes(path, "grid").decode(errors="replace")
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not TOML: {error}") from error
    blocks = document.get("runs")
    if set(document) != {"runs"} or not isinstance(blocks, list):
        raise InputError(f"{path}: expected [[runs]] blocks and nothing else, got {list(document)}")
    runs: dict[str, TrainConfig] = {}
    for number, block in enumerate(blocks, start=1):
        where = f"{path}: block {number}"
        for name, config in _expand(block, where):
            if name in runs:
                raise InputError(f"{where}: a second run named {name!r}; give the block a `name`")
            runs[name] = config
    return runs


def _expand(block: dict[str, Any], where: str) -> list[tuple[str, TrainConfig]]:
    """Return the runs of one block, the product of its lists."""
    block = dict(block)
    template = block.pop("name", NAME)
    allowed = {entry.name for entry in fields(TrainConfig)} - {"trust_region"}
    region_options = {entry.name for entry in fields(TrustRegion)}
    unknown = sorted(set(block) - allowed - region_options)
    if unknown:
        raise InputError(f"{where}: unknown options: {', '.join(unknown)}")
    lists = {key: value if isinstance(value, list) else [value] for key, value in block.items()}
    found = []
    for values in itertools.product(*lists.values()):
        chosen = dict(zip(lists, values, strict=True))
        region = {key: chosen.pop(key) for key in list(chosen) if key in region_options}
        try:
            config = TrainConfig(**chosen, trust_region=TrustRegion(**region))
            name = template.format(**{**vars(config), **region})
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
        except (KeyError, IndexError, ValueError) as error:
            raise InputError(f"{where}: name: {template!r} has no option {error}") from None
        if not name or name.startswith(".") or "/" in name:
            raise InputError(f"{where}: name: expected a folder's name, got {name!r}")
        found.append((name, config))
    return found


def command_of(config: TrainConfig, out: str, threads: int = 1) -> str:
    """Return the ``train`` command that makes this run alone: who it is, and what is no default."""
    words = ["python", "-m", "emrld_lite", "train"]
    for option in ALWAYS_SAID:
        words += [f"--{option}", str(getattr(config, option))]
    return " ".join([*words, *options_of(config), "--threads", str(threads), "--out", out])


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

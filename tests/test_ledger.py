"""The ledger points at things that exist, and its numbers are those of the code."""

import ast
import importlib
import re
import tomllib
from pathlib import Path

import pytest

from emrld_lite.config import TrainConfig
from emrld_lite.tabular.proof import RULES

ROOT = Path(__file__).resolve().parent.parent
ROWS = tomllib.loads((ROOT / "data/paper_ledger.toml").read_text())["row"]
STATUSES = {"reproduced", "differs", "not reproduced"}


def resolve(dotted):
    """Import as much of a dotted name as is a module, and walk the rest."""
    parts = dotted.split(".")
    for end in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:end]))
        except ModuleNotFoundError:
            continue
        for name in parts[end:]:
            found = getattr(found, name)
        return found
    raise ModuleNotFoundError(dotted)


def has_tag(place):
    number, tag = place.split("#")
    (source,) = (ROOT / "notebooks").glob(f"{number}_*.py")
    tags = re.findall(r"^# %%.*tags=\[(.*)\]", source.read_text(), re.MULTILINE)
    return any(f'"{tag}"' in line for line in tags)


def has_test(node):
    path, name = node.split("::")
    tree = ast.parse((ROOT / path).read_text())
    return any(isinstance(part, ast.FunctionDef) and part.name == name for part in tree.body)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["id"])
def test_a_row_points_at_something(row):
    assert set(row) <= {"id", "paper", "status", "measured", "notebook", "package", "test"}
    assert row["status"] in STATUSES
    assert row["paper"]
    assert row["measured"]
    assert {"notebook", "package", "test"} & set(row)
    if "package" in row:
        resolve(row["package"])
    if "notebook" in row:
        assert has_tag(row["notebook"]), row["notebook"]
    if "test" in row:
        assert has_test(row["test"]), row["test"]


def test_ids_are_unique():
    assert len({row["id"] for row in ROWS}) == len(ROWS)


def test_every_line_of_the_proof_has_a_row():
    ids = {row["id"] for row in ROWS}
    assert {f"proof-{name.replace('_', '-')}" for name in RULES} <= ids


def test_a_row_that_points_nowhere_would_fail():
    assert not has_tag("01#no-such-tag")
    assert not has_test("tests/test_core.py::test_no_such_test")
    with pytest.raises(AttributeError):
        resolve("emrld_lite.adapt.no_such_function")


def test_defaults_are_table_1():
    config = TrainConfig()
    assert config.adapt_lr == 0.01
    assert config.episodes == 20
    assert config.gae_lambda == 1.0
    assert config.discount == 0.95
    for algorithm in ("emrld", "emrld-ws"):
        row = TrainConfig(algorithm=algorithm)
        assert [row.adaptation(quality).w_rl for quality in ("optimal", "suboptimal")] == [0.2, 1.0]
        assert [row.adaptation(quality).w_bc for quality in ("optimal", "suboptimal")] == [1.0, 1.0]
    assert TrainConfig(algorithm="meta-bc").meta_lr == 0.01
    maml = TrainConfig(algorithm="maml").adaptation("suboptimal")
    assert (maml.w_rl, maml.w_bc, maml.warm_start) == (1.0, 0.0, False)

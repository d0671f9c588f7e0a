"""Notebook outputs compared as numbers: nbval's cell class, extended.

The words around the numbers must stay the same. A number with a decimal point may move by one unit of
its last printed digit: 0.37 may become 0.38 on another processor. A number without one is exact. A cell
in which sums or a training make the digits vary says how far, in tags (which may hold no comma):

    tolerance:0.05 or tolerance:rel=0.05    5 % of the printed number
    tolerance:abs=0.02                      0.02; together with rel both are added
    tolerance:whole=3                       3, for numbers without a decimal point

``rel`` and ``abs`` are for numbers with a decimal point, and add up as in ``numpy.allclose``. Numbers
without one are counts and stay exact unless ``whole`` is given. A cell that trains live
has the tag ``statistical`` too: another processor trains another policy, so its tolerance is as wide as
that. NaN equals NaN and an infinity itself. HTML and exceptions are compared as nbval does, pictures
not at all.
"""

from __future__ import annotations

import copy
import os
import re
import unittest.mock
from collections import defaultdict
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import pytest
from nbformat import NotebookNode
from nbval.plugin import IPyNbCell, IPyNbFile

from emrld_lite.experiments.machine import LOTS

OTHER_LOT = "plain"  # the digits of another machine; only complete notebooks hold all assertions
NUMBER = re.compile(
    r" *(?<![\w.])(?P<number>[-+−]?"
    r"(?:(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?(?:[eE][-+]?\d+)?|nan|inf))(?!\w) *"
)  # a number, not the digits of a name; the blanks beside it only align it


class Tolerance(NamedTuple):
    """How far printed numbers may move beyond the last digit: ``relative`` is a share of the number."""

    relative: Decimal = Decimal(0)
    absolute: Decimal = Decimal(0)
    whole: Decimal = Decimal(0)


EXACT = Tolerance()


def tolerance_of(tags: list[str]) -> Tolerance:
    """Return the tolerance that a cell's tags state; ValueError on a tag that says nothing clear."""
    fields = {"rel": "relative", "abs": "absolute", "whole": "whole"}
    parts = {}
    for tag in tags:
        if not tag.startswith("tolerance"):
            continue
        found = re.fullmatch(r"tolerance:(?:(rel|abs|whole)=)?(\d+(?:\.\d+)?)", tag)
        field = fields[found[1] or "rel"] if found else None
        if field is None or field in parts:
            raise ValueError(f"{tag} is twice there, or not like tolerance:abs=0.02")
        parts[field] = Decimal(found[2])
    if "statistical" in tags and not parts:
        raise ValueError("statistical needs a tolerance:... beside it")
    return Tolerance(**parts)


def allowed(printed: str, tolerance: Tolerance) -> Decimal:
    """Return how far a finite number, as printed in the committed output, may move."""
    value = Decimal(printed)
    if "." not in printed:
        return tolerance.whole
    scientific_zero = value == 0 and "e" in printed.lower()  # 0.0e+00 is no rounded number
    last_digit = Decimal(0 if scientific_zero else 1).scaleb(value.as_tuple().exponent)
    return max(last_digit, tolerance.absolute + tolerance.relative * abs(value))


def numbers_and_words(text: str) -> tuple[list[str], list[str]]:
    """Return a text's numbers as they are printed, and what stands before, between and after them."""
    pieces = NUMBER.split(text)
    numbers = [number.replace(",", "").replace("−", "-") for number in pieces[1::2]]
    return numbers, pieces[0::2]


def differences(reference: str, test: str, tolerance: Tolerance = EXACT) -> list[str]:
    """Return how a new output differs from the committed one, a sentence each; none if it does not."""
    (old_numbers, old_words), (numbers, words) = map(numbers_and_words, (reference, test))
    if len(old_numbers) != len(numbers):
        return [f"{len(old_numbers)} numbers became {len(numbers)}"]
    wrong = [
        f"{old!r} became {new!r}" for old, new in zip(old_words, words, strict=True) if old != new
    ]
    for old, new in zip(old_numbers, numbers, strict=True):
        before, after = Decimal(old), Decimal(new)
        if before.is_finite() and after.is_finite():
            limit = allowed(old, tolerance)
            if abs(after - before) > limit:
                wrong.append(f"{old} became {new}, by more than {limit.normalize():f}")
        elif str(before) != str(after):
            wrong.append(f"{old} became {new}")
    return wrong


def texts(outputs: list[NotebookNode]) -> dict[str, list[tuple[NotebookNode, str]]]:
    """Return where texts stand in a cell's outputs: by stream or media type, the node and its key."""
    found = defaultdict(list)
    for output in outputs:
        if output.output_type == "stream":
            found[output.name].append((output, "text"))
        elif "text/plain" in output.get("data", {}):
            found["text/plain"].append((output.data, "text/plain"))
    return found


class NumericCell(IPyNbCell):
    """A notebook cell whose texts agree when their words do and their numbers nearly do."""

    def compare_outputs(
        self,
        test: list[NotebookNode],
        ref: list[NotebookNode],
        skip_compare: tuple[str, ...] | None = None,
    ) -> bool:
        """Return whether new outputs agree with the committed ones, as nbval's cell class does."""
        try:
            tolerance = tolerance_of(self.cell.metadata.get("tags", []))
        except ValueError as error:
            self.raise_cell_error(str(error))
        test, told = copy.deepcopy(test), []
        committed = texts(ref)
        for kind, places in texts(test).items():
            pairs = zip(places, committed.get(kind, []), strict=False)
            for (place, key), (node, node_key) in pairs:
                reference, new = node[node_key], place[key]
                wrong = differences(self.sanitize(reference), self.sanitize(new), tolerance)
                told += [f"{kind}: {sentence}" for sentence in wrong]
                place[key] = new if wrong else reference
        same = super().compare_outputs(test, ref, skip_compare)
        self.comparison_traceback[:0] = told
        return same


class NumericFile(IPyNbFile):
    """A notebook whose code cells are compared as numbers, run on one of the lottery's machines."""

    def setup(self) -> None:
        """Start the kernel on the machine asked for; a complete notebook's is another than this one."""
        student = self.path.parent.name == "lab"
        lot = self.config.getoption("lot") or ("own" if student else OTHER_LOT)
        with unittest.mock.patch.dict(os.environ, LOTS[lot]):
            super().setup()

    def collect(self) -> Iterator[NumericCell]:
        """Yield nbval's items, each as a numeric cell."""
        for item in super().collect():
            yield NumericCell.from_parent(
                self,
                name=item.name,
                cell_num=item.cell_num,
                cell=item.cell,
                options=item.options,
            )


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the machine to play in every notebook."""
    parser.addoption(
        "--lot",
        choices=LOTS,
        help=f"machine to play; by default {OTHER_LOT}, own in notebooks/lab",
    )


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> Iterator[None]:
    """Collect notebooks as numeric files wherever nbval would collect them."""
    found = yield
    return [
        NumericFile.from_parent(parent, path=file_path) if type(item) is IPyNbFile else item
        for item in found
    ]

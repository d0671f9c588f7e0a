"""The door speaks: whatever comes from outside is used or refused in one line, and never hangs.

``EMRLD_DOOR_CASES=2000 python -m pytest tests/test_door.py`` tries so many cases of each family in place
of the few that every test run tries.
"""

import os
import sys

import pytest

from . import door

CASES = int(os.environ.get("EMRLD_DOOR_CASES", "75"))

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="FIFOs, devices and forks are POSIX's"
)


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    folder = tmp_path_factory.mktemp("base")
    door.prepare(folder)
    return folder


@pytest.mark.parametrize("family", door.ATTACKS)
def test_broken_input_is_used_rightly_or_refused_in_one_line(family, base):
    ends = list(door.attack(CASES, base, (family,)))
    defects = [f"{family} {seed}: {end}" for _, seed, end in ends if end not in ("refused", "used")]
    assert not defects, "\n".join([f"{len(defects)} of {len(ends)} cases:", *defects])
    assert sum(end == "refused" for *_, end in ends) > CASES / 3, "attacks that attack"

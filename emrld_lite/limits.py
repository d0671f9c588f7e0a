"""What this machine has, cores and memory: the bound of every count that comes from outside."""

from __future__ import annotations

import os
from pathlib import Path

from .validation import InputError, positive_count

ASSUMED = 8 * 10**9  # bytes, where the system does not say what it has
MEMORY_FILES = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def cores() -> int:
    """Return how many cores the machine has."""
    return os.cpu_count() or 1


def thread_count(field: str, value: int) -> int:
    """Return a number of threads that the machine has cores for; another raises InputError."""
    return positive_count(f"{field} (this machine has {cores()} cores)", value, maximum=cores())


def memory() -> int:
    """Return how many bytes of memory a new program can have here: what is free, within the limits."""
    found = [_number(path) for path in MEMORY_FILES]
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        facts = dict(line.split(":", 1) for line in lines if ":" in line)
        found.append(1024 * int(facts["MemAvailable"].split()[0]))
    except (OSError, KeyError, ValueError):  # not Linux
        if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
            found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min((count for count in found if count), default=ASSUMED)


def _number(path: str) -> int | None:
    """Return the number in one of the system's files; None where there is none."""
    try:
        return int(Path(path).read_text())
    except (OSError, ValueError):  # no such limit here, or "max"
        return None


def check_memory(what: str, needed: float) -> None:
    """Raise InputError, saying what would fit, where ``what`` needs more bytes than are free."""
    if needed > (free := memory()):
        raise InputError(
            f"{what}: needs about {readable_bytes(needed)} of memory, and "
            f"{readable_bytes(free)} are free: about {free / needed:.1g} times as much would fit"
        )


def readable_bytes(count: float) -> str:
    """Return a number of bytes in MB or GB (10^6, 10^9 bytes)."""
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.0f} MB"


def readable_time(seconds: float) -> str:
    """Return a duration in the unit that suits it."""
    for unit, size in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * size:
            return f"{seconds / size:,.0f} {unit}"
    return f"{seconds:.0f} s"

"""Arrays in .npz archives: read by name, their declared sizes first, and never a pickle."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from . import storage
from .limits import check_memory
from .validation import InputError, shown

COPIES = 6  # of an array, while it is read, cast, cut and packed
Header = tuple[tuple[int, ...], bool, np.dtype]


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write named arrays as compressed .npz, the same bytes for the same arrays."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    storage.write_atomically(path, buffer.getvalue())


def read_arrays(path: Path, what: str, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Read the arrays called ``names`` of an .npz file, and no other.

    Names and declared sizes are checked before anything is inflated. A damaged, foreign or pickled
    file, one that lacks a name, or one larger than the memory raises InputError.
    """
    content = storage.read_bytes(path, what, storage.LONGEST_BINARY)
    with (
        storage.foreign_reader(path, f".npz {what} (truncated or foreign)"),
        zipfile.ZipFile(io.BytesIO(content)) as archive,
    ):
        members = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
        if missing := [name for name in names if name not in members]:
            held = ", ".join(sorted(members)[:20]) or "nothing"
            raise InputError(
                f"{path}: not a {what}: missing {', '.join(missing)}; it holds {shown(held)}"
            )
        check_memory(f"{path}: reading it", COPIES * sum(members[n].file_size for n in names))
        return {name: _read_array(archive, members[name], f"{path}: {name}") for name in names}


def _read_array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, where: str) -> np.ndarray:
    """Return one array of an archive, whose header must agree with the archive's own facts."""
    with archive.open(entry) as file:
        shape, _, dtype = _read_header(file, where)
        declared = math.prod(shape) * dtype.itemsize
        if dtype.hasobject:
            raise InputError(f"{where}: holds pickled objects, which are never loaded")
        if declared != entry.file_size - file.tell():
            raise InputError(
                f"{where}: expected {declared} bytes for shape {shown(shape)} and dtype {dtype}, got "
                f"{entry.file_size - file.tell()}"
            )
    with archive.open(entry) as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _read_header(file: io.BufferedIOBase, where: str) -> Header:
    """Return shape, order and dtype that an array in an archive declares."""
    readers = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    version = np.lib.format.read_magic(file)
    if version not in readers:
        raise InputError(f"{where}: expected version 1.0 or 2.0 of numpy's format, got {version}")
    return readers[version](file)

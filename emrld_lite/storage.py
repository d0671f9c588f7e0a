"""Files written whole or not at all, and never a pickle; what is read is checked before it is believed."""

from __future__ import annotations

import csv
import io
import json
import os
import stat
import tempfile
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import safetensors
import safetensors.torch
import torch

from .limits import readable_bytes
from .validation import InputError, shaped, shown

DATA = Path(__file__).resolve().parent.parent / "data"  # the workbook's own files
LONGEST_TEXT = 10**6  # bytes of a configuration, a grid or a provenance
LONGEST_TABLE = 10**8  # bytes of a .csv
LONGEST_BINARY = 2**32  # bytes of arrays or tensors
LONGEST_NAME = 200  # bytes, so that a temporary neighbour's name fits too


@contextmanager
def foreign_reader(path: Path, kind: str) -> Iterator[None]:
    """Turn whatever a foreign reader raises on a damaged file into InputError naming file and kind."""
    try:
        yield
    except InputError:
        raise
    except (
        Exception
    ) as error:  # numpy, zipfile, zlib, json, csv, toml: no list of theirs is complete
        reason = "nested too deep" if isinstance(error, RecursionError) else str(error)
        raise InputError(
            f"{path}: not a readable {kind}: {reason or type(error).__name__}"
        ) from error


def check_target(field: str, path: Path, folder: bool = False) -> Path:
    """Return a path to which a file, or a ``folder``, can be written; another raises InputError.

    Nothing is made or changed: what is missing of the path can be made later.
    """
    path, kind = Path(path), "folder" if folder else "file"
    if path == Path():
        raise InputError(f"{field}: expected the name of a {kind}, got {str(path)!r} or nothing")
    try:
        nearest = next(place for place in (path, *path.absolute().parents) if _exists(place))
        mode = nearest.stat().st_mode
    except (OSError, ValueError) as error:  # a name too long, with a NUL, or a loop of links
        raise InputError(f"{field}: cannot write {str(path)!r}: {error}") from error
    wanted = stat.S_ISDIR if folder or nearest != path else stat.S_ISREG
    if not wanted(mode):
        raise InputError(f"{field}: cannot write {path}: {nearest} is there and is no {kind}")
    if not os.access(nearest, os.W_OK) or len(os.fsencode(path.name)) > LONGEST_NAME:
        raise InputError(f"{field}: cannot write {path}: no permission, or too long a name")
    return path


def _exists(path: Path) -> bool:
    """Return whether something is at a path; unlike Path.exists, raises ValueError for a NUL in it."""
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    return True


def write_atomically(path: Path, content: bytes) -> None:
    """Write ``content`` to a temporary neighbour and rename it, so a reader sees old or new, never half.

    Raises OSError naming the file when the disk is full or the folder cannot be written; a previous
    version of the file is then still whole.
    """
    path = Path(path)
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        kept = "; its previous version is untouched" if path.is_file() else ""
        raise OSError(f"cannot write {path}: {error.strerror or error}{kept}") from error


def clean_up(folder: Path, names: Sequence[str]) -> None:
    """Remove the temporary files that a killed program left beside the files called ``names``."""
    for name in names:
        for stray in Path(folder).glob(f".{name}.*"):
            stray.unlink(missing_ok=True)


def read_bytes(path: Path, what: str, most: int = LONGEST_TEXT) -> bytes:
    """Return the bytes of a regular file of at most ``most`` bytes; any other raises InputError."""
    try:
        facts = Path(path).stat()
        if not stat.S_ISREG(facts.st_mode):
            raise InputError(f"{path}: expected a regular file as {what}, got another kind of file")
        if facts.st_size > most:
            raise InputError(
                f"{path}: expected a {what} of at most {readable_bytes(most)}, "
                f"got {readable_bytes(facts.st_size)}"
            )
        return Path(path).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such {what}") from None
    except InputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot read this {what}: {reason}") from error


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a mapping as indented JSON."""
    write_atomically(path, (json.dumps(content, indent=2) + "\n").encode())


def read_json(path: Path, what: str) -> dict[str, Any]:
    """Read a JSON object; anything else raises InputError."""
    content = read_bytes(path, what)
    with foreign_reader(path, f"{what} in JSON"):
        found = json.loads(content, object_pairs_hook=_each_once)
    if not isinstance(found, dict):
        raise InputError(f"{path}: expected a JSON object in this {what}, got {shown(found)}")
    return found


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return the pairs of a JSON object as a dict; a name that stands twice raises ValueError."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name stands twice in an object")
    return found


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Read a TOML document; anything else raises InputError."""
    content = read_bytes(path, what)
    with foreign_reader(path, f"{what} in TOML"):
        return tomllib.loads(content.decode())


def write_csv(path: Path, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Write a table with a header line."""
    write_atomically(path, csv_text(columns, rows).encode())


def csv_text(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Return a table with a header line as text."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()


def read_csv(
    path: Path, what: str, columns: Sequence[str], optional: Sequence[str] = ()
) -> list[dict[str, str]]:
    """Read a table whose header must be ``columns``, with or without ``optional`` ones among them.

    Anything else, also a row with more or fewer cells than the header, raises InputError.
    """
    content = read_bytes(path, what, LONGEST_TABLE)
    with foreign_reader(path, f"{what} in CSV"):
        header, *rows = list(csv.reader(io.StringIO(content.decode(), newline=""))) or [[]]
    needed = [name for name in columns if name not in optional]
    if header not in (list(columns), needed):
        raise InputError(f"{path}: expected columns {list(columns)}, got {shown(header)}")
    for line, row in enumerate(rows, start=2):
        if len(row) != len(header):
            raise InputError(f"{path}: line {line}: expected {len(header)} cells, got {len(row)}")
    return [dict(zip(header, row, strict=True)) for row in rows]


def write_tensors(
    path: Path, tensors: Mapping[str, torch.Tensor], metadata: Mapping[str, str]
) -> None:
    """Write named float32 tensors and string metadata as .safetensors.

    A tensor that could not be read back, because a number in it is not finite, raises InputError;
    a previous version of the file is then still whole.
    """
    check_finite(path, tensors)
    contiguous = {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}
    write_atomically(path, safetensors.torch.save(contiguous, metadata=dict(metadata)))


def check_finite(path: Path, tensors: Mapping[str, torch.Tensor]) -> None:
    """Raise InputError where a number in the tensors for a file is not finite."""
    for name, tensor in tensors.items():
        shaped(f"{path}: cannot be written: {name}", tensor, tuple(tensor.shape))


def read_tensors(path: Path, what: str) -> tuple[dict[str, torch.Tensor], dict[str, str]]:
    """Read float32 tensors and metadata of a .safetensors file; any other raises InputError."""
    read_bytes(path, what, LONGEST_BINARY)
    with (
        foreign_reader(path, f".safetensors {what}"),
        safetensors.safe_open(str(path), framework="pt") as file,
    ):
        names = list(file.keys())
        for name in names:
            if (dtype := file.get_slice(name).get_dtype()) != "F32":
                raise InputError(f"{path}: {name}: expected float32 numbers, got {dtype}")
        return {name: file.get_tensor(name) for name in names}, dict(file.metadata() or {})


def fitting(
    path: Path, tensors: Mapping[str, torch.Tensor], expected: Mapping[str, torch.Tensor]
) -> dict[str, torch.Tensor]:
    """Return the tensors of a file in the order of ``expected``.

    Raises InputError unless they are finite and of the names and shapes of ``expected``.
    """
    if set(tensors) != set(expected):
        raise InputError(
            f"{path}: expected tensors {sorted(expected)}, got {shown(sorted(tensors))}"
        )
    for name, value in expected.items():
        shaped(f"{path}: {name}", tensors[name], tuple(value.shape))
    return {name: tensors[name] for name in expected}

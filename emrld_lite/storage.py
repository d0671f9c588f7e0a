"""Files written whole or not at all, and never a pickle."""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import safetensors.torch
import torch

from .validation import InputError

DATA = Path(__file__).resolve().parent.parent / "data"  # the workbook's own files


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


def read_bytes(path: Path, what: str) -> bytes:
    """Return the bytes of a file; a missing or unreadable one raises InputError naming ``what``."""
    try:
        return Path(path).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such {what}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot read this {what}: {error.strerror or error}") from error


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a mapping as indented JSON."""
    write_atomically(path, (json.dumps(content, indent=2) + "\n").encode())


def read_json(path: Path, what: str) -> dict[str, Any]:
    """Read a JSON object; anything else raises InputError."""
    try:
        content = json.loads(read_bytes(path, what))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: this {what} is not valid JSON: {error}") from error
    if not isinstance(content, dict):
        raise InputError(f"{path}: expected a JSON object in this {what}")
    return content


def write_csv(path: Path, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Write a table with a header line."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    write_atomically(path, text.getvalue().encode())


def read_csv(
    path: Path, what: str, columns: Sequence[str], optional: Sequence[str] = ()
) -> list[dict[str, str]]:
    """Read a table whose header must be ``columns``, with or without ``optional`` ones among them.

    Anything else raises InputError.
    """
    text = read_bytes(path, what).decode(errors="replace")
    reader = csv.DictReader(io.StringIO(text))
    needed = [name for name in columns if name not in optional]
    if list(reader.fieldnames or ()) not in (list(columns), needed):
        raise InputError(f"{path}: expected columns {list(columns)}, got {reader.fieldnames}")
    return list(reader)


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write named arrays as compressed .npz, the same bytes for the same arrays."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    write_atomically(path, buffer.getvalue())


def read_arrays(path: Path, what: str) -> dict[str, np.ndarray]:
    """Read every array of an .npz file; a damaged, foreign or pickled one raises InputError."""
    content = read_bytes(path, what)
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except (zipfile.BadZipFile, ValueError, OSError, EOFError, KeyError, AttributeError) as error:
        raise InputError(
            f"{path}: not a readable .npz {what} (truncated, foreign or pickled): {error}"
        ) from error


def write_tensors(
    path: Path, tensors: Mapping[str, torch.Tensor], metadata: Mapping[str, str]
) -> None:
    """Write named tensors and string metadata as .safetensors."""
    contiguous = {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}
    write_atomically(path, safetensors.torch.save(contiguous, metadata=dict(metadata)))


def read_tensors(path: Path, what: str) -> tuple[dict[str, torch.Tensor], dict[str, str]]:
    """Read named tensors and metadata of a .safetensors file; a damaged one raises InputError."""
    read_bytes(path, what)
    try:
        with safetensors.safe_open(str(path), framework="pt") as file:
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            return tensors, dict(file.metadata() or {})
    except safetensors.SafetensorError as error:
        raise InputError(f"{path}: not a readable .safetensors {what}: {error}") from error

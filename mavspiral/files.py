"""Files that are whole or not there: written beside their place, then renamed."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

from mavspiral.errors import InputError

__all__ = ["try_folder", "write_bytes", "write_json", "write_text", "write_with"]


def try_folder(folder: Path) -> Path:
    """`folder`, after a file was written there and all was put back: tried before a flight, not after it.

    Raises:
        InputError: it cannot be made or written to.
    """
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    trial = folder / f".trial.{os.getpid()}"
    try:
        write_with(trial, lambda file: file.write(b""))
    except InputError as error:  # nobody has asked for that file
        raise InputError(str(error).replace(str(trial), str(folder))) from None
    trial.unlink()
    for place in missing:
        place.rmdir()
    return folder


def write_with(path: Path, write: Callable[[BinaryIO], object]) -> Path:
    """`path`, after `write` has filled it whole; nothing is left behind when it fails.

    Raises:
        InputError: the folder cannot be made or written to.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with beside.open("wb") as file:
            write(file)
        beside.replace(path)
    except OSError as error:
        raise InputError(
            f"{path}: cannot be written ({error.strerror}). Fix: choose another folder with --out"
        ) from None
    finally:
        with contextlib.suppress(OSError):
            beside.unlink()
    return path


def write_bytes(path: Path, content: bytes) -> Path:
    """`path`, holding `content`."""
    return write_with(path, lambda file: file.write(content))


def write_text(path: Path, content: str) -> Path:
    """`path`, holding `content` in UTF-8 with the line ends as they are."""
    return write_bytes(path, content.encode("utf-8"))


def write_json(path: Path, document: Any) -> Path:
    """`path`, holding `document` as real JSON: a NaN or an infinity is a ValueError."""
    return write_text(path, json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")

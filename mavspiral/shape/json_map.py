"""JSON documents, read once, whichever kind of map they turn out to be."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mavspiral.errors import InputError
from mavspiral.shape.site_map import judge_bytes

__all__ = ["read_json", "read_json_lines"]

MOST_MB = 100
CUT = "cut the building's neighbourhood out of the map"


def read_json(path: Path) -> Any:
    """The document in the file.

    Raises:
        InputError: it is no JSON, or larger than memory wants.
    """
    judge_bytes(path, MOST_MB, CUT)
    try:
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(
            f"{path}: not JSON ({str(error)[:120]}). Fix: export the map as GeoJSON or CityJSON"
        ) from None


def read_json_lines(path: Path) -> list[Any]:
    """The documents in the file, one a line.

    Raises:
        InputError: a line is no JSON (it is named), or the file is larger than memory wants.
    """
    judge_bytes(path, MOST_MB, CUT)
    documents: list[Any] = []
    try:
        lines = path.read_text(encoding="utf-8-sig").split("\n")
        documents.extend(json.loads(line) if line.strip() else None for line in lines)
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(
            f"{path}: line {len(documents) + 1} is not JSON ({str(error)[:120]}). "
            "Fix: export the map as CityJSONSeq, one feature a line"
        ) from None
    return [document for document in documents if document is not None]

"""A `.plan` from anywhere as plain JSON values, or one clear line why it is none."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NoReturn

from mavspiral.errors import InputError

__all__ = ["read_plan_json"]

SIZE_MAX_BYTES = 8 * 2**20
"""Ten thousand items are 6 MB as QGroundControl writes them; read, this is 200 MB at most."""

DIGITS_MAX = 20


def read_plan_json(path: Path) -> dict[str, Any]:
    """The file's root object. Every number in it is finite.

    Raises:
        InputError: it cannot be read, is too large, or is not a JSON object.
    """
    try:
        with path.open("rb") as file:
            content = file.read(SIZE_MAX_BYTES + 1)
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror}). Fix: give the path of a .plan, as `mavspiral plan` writes it"
        ) from None
    if len(content) > SIZE_MAX_BYTES:
        raise InputError(f"{path}: larger than {SIZE_MAX_BYTES >> 20} MiB, which no plan is")
    if content.startswith(b"QGC WPL"):
        raise InputError(
            f"{path}: no .plan but a mission of text lines (QGC WPL), which keeps neither fence nor rally points. "
            "Fix: open it in QGroundControl and save it as .plan"
        )
    try:
        document = json.loads(
            content.decode("utf-8-sig"),
            parse_constant=_no_number,
            parse_float=_finite,
            parse_int=_whole,
        )
    except json.JSONDecodeError as error:
        raise InputError(
            f"{path}: no JSON ({error.msg}, line {error.lineno}, column {error.colno}). "
            "Fix: save it again; a plan that was cut off cannot be mended"
        ) from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: no JSON but bytes that are no UTF-8. Fix: give a .plan, not a log or a map"
        ) from None
    except ValueError as error:
        raise InputError(f"{path}: no JSON ({str(error).splitlines()[0]})") from None
    except RecursionError:
        raise InputError(f"{path}: no plan (nested too deep)") from None
    if not isinstance(document, dict):
        raise InputError(f"{path}: no plan (a JSON {type(document).__name__}, wanted an object)")
    return document


def _no_number(word: str) -> NoReturn:
    raise ValueError(f"{word} is no JSON number; write null")


def _finite(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        raise ValueError(f"the number {digits[:DIGITS_MAX]} is too large")
    return value


def _whole(digits: str) -> int:
    if len(digits) > DIGITS_MAX:
        raise ValueError(f"the number {digits[:DIGITS_MAX]}… is too large")
    return int(digits)

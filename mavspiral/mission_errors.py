"""Pydantic's findings about a mission as one line that a pilot can act upon."""

from __future__ import annotations

import difflib
import json
from typing import Any

from pydantic import BaseModel, ValidationError

__all__ = ["describe"]

_WANTED = {
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be smaller than {lt}",
    "less_than_equal": "must be at most {le}",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": 'must be text in "quotes"',
    "string_too_short": "must not be empty",
    "string_pattern_mismatch": "must match {pattern}",
    "literal_error": "must be one of {expected}",
    "tuple_type": "must be a list",
    "model_type": "must be a table",
    "too_short": "must hold at least {min_length} entries",
    "too_long": "must hold at most {max_length} entries",
}


def describe(error: ValidationError, model: type[BaseModel]) -> str:
    """The first finding in words: key, value, what is wanted, a fix; and how many more there are."""
    # A misspelt key is reported twice, as unknown and as missing: the unknown one holds the cure.
    findings = sorted(
        error.errors(include_url=False), key=lambda finding: finding["type"] != "extra_forbidden"
    )
    line = _finding(findings[0], model)
    return line if len(findings) == 1 else f"{line} (and {len(findings) - 1} more)"


def _finding(finding: Any, model: type[BaseModel]) -> str:
    kind, location, context = finding["type"], finding["loc"], finding.get("ctx", {})
    key = _key(location)
    if kind == "value_error":
        return f"{key}: {context['error']}" if key else str(context["error"])
    if kind == "extra_forbidden":
        known = _keys_at(model, location[:-1])
        close = difflib.get_close_matches(str(location[-1]), known, n=1)
        fix = f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"
        return f"{key}: unknown key. Fix: {fix}"
    if kind == "missing":
        where = _key(location[:-1])
        if isinstance(location[-1], int):
            return f"{where}: has too few entries, entry {location[-1] + 1} is missing"
        return f"{where + ': ' if where else ''}{location[-1]} is missing. Fix: add {_example(str(location[-1]), model)}"
    wanted = _WANTED.get(kind, finding["msg"]).format(**context)
    return f"{key} = {_shown(finding['input'])}: {wanted}. Fix: e.g. {_example(_last_name(location), model)}"


def _key(location: tuple[str | int, ...]) -> str:
    names = [part for part in location if isinstance(part, str)]
    entry = "".join(f" (entry {part + 1})" for part in location if isinstance(part, int))
    if not names:
        return ""
    return (names[0] if len(names) == 1 else f"[{names[0]}] {'.'.join(names[1:])}") + entry


def _last_name(location: tuple[str | int, ...]) -> str:
    return next(part for part in reversed(location) if isinstance(part, str))


def _keys_at(model: type[BaseModel], location: tuple[str | int, ...]) -> list[str]:
    for part in location:
        field = next((f for n, f in model.model_fields.items() if part in (n, f.alias)), None)
        if field is None:
            continue
        inner = [field.annotation, *getattr(field.annotation, "__args__", ())]
        model = next((t for t in inner if isinstance(t, type) and issubclass(t, BaseModel)), model)
    return [field.alias or name for name, field in model.model_fields.items() if not field.exclude]


def _shown(value: object) -> str:
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else text[:57] + "…"


_EXAMPLES = {
    "schema": "schema = 1",
    "name": 'name = "torre"',
    "building": '[building] map = "maps/torre.geojson"',
    "map": 'map = "maps/torre.geojson"',
    "at": "at = [19.4339, -99.1406] (latitude, longitude)",
    "dtm": 'dtm = "maps/terrain.tif"',
    "units": 'units = "m" (of a mesh)',
    "up": 'up = "z" (of a mesh)',
    "heading_deg": "heading_deg = 30 (clockwise from north)",
    "crs": 'crs = "EPSG:32614" (of a map that does not name its own)',
    "camera": "[camera] focal_length_mm = 8.8 and sensor_mm = [13.2, 8.8]",
    "focal_length_mm": "focal_length_mm = 8.8",
    "sensor_mm": "sensor_mm = [13.2, 8.8] (width, height)",
    "image_px": "image_px = [5472, 3648] (width, height)",
    "inspection": "[inspection] standoff_m = 12.0",
    "standoff_m": "standoff_m = 12.0 (metres from the wall)",
    "overlap": "overlap = 0.25 (a share, not per cent)",
    "side_overlap": "side_overlap = 0.6 (a share, not per cent)",
    "mode": 'mode = "paper" (the default is "spiral")',
    "terms": "terms = 12 (harmonics of each ring, of the paper's recipe)",
    "home": "home = [19.4332, -99.1412] (latitude, longitude)",
    "autopilot": 'autopilot = "px4"',
    "gps": 'gps = "rtk"',
    "height_m": "height_m = [0, 18]",
}


def _example(key: str, model: type[BaseModel]) -> str:
    if key in _EXAMPLES:
        return _EXAMPLES[key]
    for table in model.model_fields.values():
        fields = getattr(table.annotation, "model_fields", {})
        if key in fields and fields[key].default not in (None, ...):
            return f"{key} = {json.dumps(fields[key].default, default=str)}, which is the default"
    return f"a {key} as the README's mission file shows"

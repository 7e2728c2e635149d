"""ArduPilot's parameters as one file, as its ground stations fetch them: @PARAM/param.pck.

Source: ArduPilot 4.6, AP_Filesystem_Param.cpp: a name is told by how much of its beginning the one before had too. Simpler: no row is
kept whole within a block.
"""

from __future__ import annotations

from collections.abc import Mapping
from struct import Struct

from sitl.copter_params import copter_defaults
from sitl.copter_types import copter_bits

__all__ = ["param_file"]

_NAME, _WITH_DEFAULTS = b"@PARAM/param.pck", b"withdefaults=1"
_MAGIC, _MAGIC_DEFAULTS = 0x671B, 0x671C
_HEAD, _ROW, _FLOAT = Struct("<HHH"), Struct("<BB"), Struct("<f")
_WHOLE = {8: (1, Struct("<b")), 16: (2, Struct("<h")), 32: (3, Struct("<i"))}
_FLOAT_TYPE, _HAS_DEFAULT = 4, 1 << 4
_MOST_COMMON = 15


def param_file(path: bytes, values: Mapping[str, float]) -> bytes | None:
    """What is in the file of that name; None when that is not the parameters'."""
    name, _, wishes = path.partition(b"?")
    if name != _NAME:
        return None
    defaults = copter_defaults() if _WITH_DEFAULTS in wishes.split(b"&") else None
    magic = _MAGIC if defaults is None else _MAGIC_DEFAULTS
    out = bytearray(_HEAD.pack(magic, len(values), len(values)))
    before = b""
    for text, value in values.items():
        encoded, common = text.encode(), 0
        most = min(_MOST_COMMON, len(encoded) - 1, len(before))
        while common < most and encoded[common] == before[common]:
            common += 1
        stated = defaults is not None and defaults[text] != value
        own = encoded[common:]
        bits = copter_bits().get(text)
        kind, packer = (_FLOAT_TYPE, _FLOAT) if bits is None else _WHOLE[bits]
        out += _ROW.pack(kind | _HAS_DEFAULT * stated, (len(own) - 1) << 4 | common) + own
        told = (value, defaults[text]) if stated and defaults is not None else (value,)
        out += b"".join(packer.pack(one if bits is None else int(one)) for one in told)
        before = encoded
    return bytes(out)

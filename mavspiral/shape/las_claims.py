"""What a LAS or LAZ file claims to hold, held against its size before its library allocates for it.

LAS 1.4 R15, tables 3 and 7; LAZ 1.4 R1 for the chunk table and the layers of point formats 6 to 10.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

from mavspiral.errors import InputError
from mavspiral.shape.site_map import need

__all__ = ["judge_chunks", "judge_header"]

LAZ_RATIO_MAX = 2000
"""LASzip makes real points 4 to 20 times smaller; constant ones some hundred times."""

LAYERS = {10: 9, 11: 1, 12: 2, 13: 1}
"""How many layers an item of each LASzip type has; type 14 (extra bytes) has one for each byte."""


def judge_header(path: Path) -> None:
    """Nothing, when the file can hold what its header claims.

    Raises:
        InputError: it cannot.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(375)
        if len(head) < 227 or head[:4] != b"LASF":
            raise InputError(f"{path}: not a LAS file ({size} bytes). Fix: export the cloud as LAS or LAZ")
        minor = head[25]
        header_size, offset, vlrs = struct.unpack_from("<HII", head, 94)
        point_format, point_size, count = struct.unpack_from("<BHI", head, 104)
        evlr_start, evlrs = 0, 0
        if minor >= 4 and len(head) == 375:
            evlr_start, evlrs, count = struct.unpack_from("<QIQ", head, 235)
        chunks = 0
        compressed = bool(point_format & 0xC0)
        if compressed and offset + 8 <= size:
            stream.seek(offset)
            table = struct.unpack("<q", stream.read(8))[0]
            if table == -1:
                stream.seek(size - 8)
                table = struct.unpack("<q", stream.read(8))[0]
            if 0 < table <= size - 8:
                stream.seek(table)
                _, chunks = struct.unpack("<II", stream.read(8))
    room = max(0, size - offset)
    claims = (
        ("header", header_size, offset),
        ("what comes before its points", offset, size),
        ("variable records", vlrs * 54 + header_size, offset),
        ("extended records", evlrs * 60 + (evlr_start if evlrs else 0), size),
        ("points", count * point_size, room * (LAZ_RATIO_MAX if compressed else 1)),
        ("compressed chunks", chunks, room),
    )
    for what, claimed, most in claims:
        if claimed > most:
            raise InputError(
                f"{path}: its header claims {claimed:,} bytes of {what}, there is room for {most:,}. Fix: it is torn; export it anew"
            )
    if count == 0 or point_size == 0:
        raise InputError(f"{path}: it holds no points. Fix: export the cloud anew")


def judge_chunks(path: Path, header: Any) -> None:
    """Nothing, when the file's compressed chunks can hold the layers that they claim.

    Raises:
        InputError: they cannot.
    """
    found = header.vlrs.get("LasZipVlr")
    if not header.are_points_compressed or not found:
        return
    lazrs = need("lazrs", "cloud", path)
    record = bytes(found[0].record_data)
    (items,) = struct.unpack_from("<H", record, 32)
    kinds = [struct.unpack_from("<HH", record, 34 + 6 * i) for i in range(items)]
    layers = sum(size if kind == 14 else LAYERS.get(kind, 0) for kind, size in kinds)
    with path.open("rb") as stream:
        start = header.offset_to_point_data
        stream.seek(start)
        table = lazrs.read_chunk_table(stream, lazrs.LazVlr(record))
        place, end = start + 8, path.stat().st_size
        for number, (_, size) in enumerate(table, start=1):
            # A chunk of layers begins with one raw point and a count, then says how long each layer is.
            stream.seek(place + header.point_format.size + 4)
            claim = stream.read(4 * layers)
            claimed = sum(struct.unpack(f"<{layers}I", claim)) if len(claim) == 4 * layers else end
            if size > end - place or (layers and claimed > size):
                raise InputError(
                    f"{path}: its chunk {number} claims {max(claimed, size):,} bytes, there is room for "
                    f"{min(size, end - place):,}. Fix: it is torn; export it anew"
                )
            place += size

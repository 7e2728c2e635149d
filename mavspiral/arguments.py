"""What more than one verb takes on the command line, and the words of it that are neither numbers nor paths."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mavspiral.errors import InputError

if TYPE_CHECKING:
    from mavspiral.flight.autopilots import Autopilot
    from mavspiral.live import Place

__all__ = [
    "Connect",
    "Json",
    "MissionFile",
    "OfAutopilot",
    "Out",
    "Signing",
    "System",
    "autopilot_named",
    "place_named",
]


MissionFile = Annotated[
    Path, typer.Argument(help="The mission file (TOML).", metavar="MISSION", show_default=False)
]


def _named(folder: str) -> Path:
    if not folder.strip():
        raise typer.BadParameter("it names no folder, . is this one")
    return Path(folder)


Out = Annotated[
    Path | None,
    typer.Option(
        "--out", parser=_named, metavar="PATH", help="The folder for the files; by default out/NAME."
    ),
]
OfAutopilot = Annotated[
    str | None,
    typer.Option(
        "--autopilot",
        metavar="NAME",
        help="px4 or ardupilot; by default the mission's, in `fly` the vehicle's own.",
    ),
]
Connect = Annotated[
    str,
    typer.Option(
        "--connect", metavar="URL", help="The vehicle, as MAVSDK or pymavlink spell it: udpin://0.0.0.0:14540"
    ),
]
System = Annotated[
    int | None,
    typer.Option(
        "--system", metavar="N", help="Which MAVLink system, where there are several.", min=1, max=255
    ),
]
Signing = Annotated[
    Path | None,
    typer.Option("--signing", metavar="KEYFILE", help="A key file: sign all, and refuse what is not signed."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]


def autopilot_named(name: str | None) -> Autopilot | None:
    """What --autopilot says; None leaves it to the mission or the vehicle.

    Raises:
        InputError: there is none of that name.
    """
    from mavspiral.flight.autopilots import PROFILES

    if name is None:
        return None
    for known in PROFILES:
        if name == known:
            return known
    raise InputError(f"--autopilot {name!r} is not known. Fix: one of {', '.join(PROFILES)}")


def place_named(text: str) -> Place:
    """What --align says: home, or latitude and longitude in degrees.

    Raises:
        InputError: it is neither.
    """
    if text == "home":
        return "home"
    try:
        lat_deg, lon_deg = map(float, text.split(","))
        if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0):
            raise ValueError(text)
    except ValueError:
        raise InputError(f"--align {text!r} is no place. Fix: LAT,LON in degrees, or home") from None
    return lat_deg, lon_deg

"""The options of `python -m sitl`: each read, or told in one line what is wrong with it."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from sitl.faults import Fault, parse_fault
from sitl.link.signing import parse_key
from sitl.signals import GeoPoint

__all__ = ["joined", "parser_of_options"]

_KIOSK_HOME = "23.96028,32.8675,188.5,40"
_LOWEST_M, _HIGHEST_M = -1000.0, 20_000.0
_STRONGEST_MPS = 100.0
_SEED_DIGITS = 18
_BELOW_ZERO = re.compile(r"-[\d.]")


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"sitl: {message}\n")


def parser_of_options(description: str) -> argparse.ArgumentParser:
    """What reads them; it exits with 2 at the first that is wrong."""
    parser = _Parser(prog="python -m sitl", description=description)
    add = parser.add_argument
    add(
        "--autopilot",
        choices=["px4", "ardupilot"],
        default="px4",
        help="whose behaviour on the link (default: px4)",
    )
    add("--airframe", default="x500", help="which body (default: x500)")
    add("--home", type=_home, default=_home(_KIOSK_HOME), metavar="LAT,LON,ALT_AMSL_M,HEADING_DEG",
        help=f"where it stands (default: {_KIOSK_HOME})")  # fmt: skip
    add("--wind", type=_wind, default=(0.0, 0.0, 0.0), metavar="MPS[,FROM_DEG]",
        help="steady wind and where it blows from (default: none; from the west)")  # fmt: skip
    add("--gust", action="store_true", help="Dryden turbulence on top of the wind")
    add("--speedup", type=_positive, default=1.0, metavar="X", help="times real time (default: 1)")
    add("--seed", type=_seed, default=0, metavar="N", help="of the senses' noise (default: 0)")
    add("--instance", type=_instance, default=0, metavar="N", help="added to the ports; the system is N + 1")
    add("--bind", default="127.0.0.1", metavar="ADDR", help="listen there (default: this machine only)")
    add("--gps", choices=["rtk", "standard"], default="rtk", help="how good the fixes are (default: rtk)")
    add("--fault", type=_fault, action="append", default=[], metavar="SPEC",
        help="NAME[=VALUE]@START[+DURATION], such as gps_loss@60s+20s; repeatable")  # fmt: skip
    add("--signing", type=_key, metavar="KEYFILE", help="sign all, and refuse what is not signed")
    add("--camera", action="store_true", help="a PX4 carries a camera on a gimbal that answers MAVLink")
    add("--tlog", type=_log_path, metavar="FILE", help="write down all that passes on the links")
    return parser


def joined(arguments: Sequence[str]) -> list[str]:
    """The same arguments with "--home -35.4,149.2,584,0" as one, "--home=-35.4,…": else the value passes for another option."""
    together: list[str] = []
    for argument in arguments:
        if _BELOW_ZERO.match(argument) and together and together[-1].startswith("--"):
            together[-1] += f"={argument}"
        else:
            together.append(argument)
    return together


def _numbers(text: str, counts: tuple[int, ...], form: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
        raise argparse.ArgumentTypeError(f"{text!r}: wanted {form}")
    return numbers


def _home(text: str) -> tuple[GeoPoint, float]:
    lat_deg, lon_deg, alt_amsl_m, heading_deg = _numbers(text, (4,), "lat,lon,alt_amsl_m,heading_deg")
    if abs(lat_deg) > 89.0 or abs(lon_deg) > 180.0:
        raise argparse.ArgumentTypeError(
            f"{text!r}: latitude is within ±89 and longitude within ±180 degrees"
        )
    if not _LOWEST_M <= alt_amsl_m <= _HIGHEST_M:
        raise argparse.ArgumentTypeError(
            f"{text!r}: altitude is within {_LOWEST_M:.0f} and {_HIGHEST_M:.0f} m above sea level"
        )
    return GeoPoint(lat_deg, lon_deg, alt_amsl_m), math.radians(heading_deg)


def _wind(text: str) -> tuple[float, float, float]:
    speed_mps, from_deg, *_ = [*_numbers(text, (1, 2), "MPS or MPS,FROM_DEG"), 270.0]
    if abs(speed_mps) > _STRONGEST_MPS:
        raise argparse.ArgumentTypeError(f"{text!r}: wind is at most {_STRONGEST_MPS:.0f} m/s")
    from_rad = math.radians(from_deg)
    return -speed_mps * math.cos(from_rad), -speed_mps * math.sin(from_rad), 0.0


def _log_path(text: str) -> Path:
    path = Path(text)
    try:
        path.open("wb").close()
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be written: {error.strerror}") from None
    return path


def _key(text: str) -> bytes:
    try:
        return parse_key(Path(text).read_bytes())
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r}: {error}") from None


def _positive(text: str) -> float:
    (number,) = _numbers(text, (1,), "a number above zero")
    if number <= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}: wanted a number above zero")
    return number


def _seed(text: str) -> int:
    if not text.isdecimal() or len(text) > _SEED_DIGITS:
        raise argparse.ArgumentTypeError(
            f"{text!r}: wanted an integer from 0, of at most {_SEED_DIGITS} digits"
        )
    return int(text)


def _instance(text: str) -> int:
    if not text.isdecimal() or len(text) > 3 or int(text) > 253:
        raise argparse.ArgumentTypeError(f"{text!r}: wanted an integer from 0 to 253")
    return int(text)


def _fault(text: str) -> Fault:
    try:
        return parse_fault(text)
    except (ValueError, OverflowError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None

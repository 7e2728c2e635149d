"""`python -m sitl`: the bundled vehicle on the ports of PX4's or ArduPilot's SITL."""

from __future__ import annotations

import argparse
import contextlib
import math
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from sitl.airframe import load_airframe
from sitl.compiling import compiled_beside
from sitl.faults import Fault, parse_fault
from sitl.link.endpoint import (
    ARDUPILOT_TCP_PORTS,
    GCS_PORTS,
    OFFBOARD_PORTS,
    Endpoint,
    PortTakenError,
    ardupilot_links,
    px4_links,
    run,
    signing_timestamp,
    wait_for_client,
)
from sitl.link.signing import Signing, parse_key
from sitl.link.tlog import TlogWriter
from sitl.params import Params
from sitl.signals import GeoPoint
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

__all__ = ["main"]

_KIOSK_HOME = "23.96028,32.8675,188.5,40"
_WARM_UP_US = 3_000_000
_READY_BY_US = {"px4": 15_000_000, "ardupilot": 60_000_000}
"""Past these and the faults' ends something is wrong: healthy they are ready after 4 s and 41 s."""
_LOWEST_M, _HIGHEST_M = -1000.0, 20_000.0
_STRONGEST_MPS = 100.0
_SEED_DIGITS = 18


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"sitl: {message}\n")


def main(argv: list[str] | None = None) -> int:
    """Run the vehicle until Ctrl-C or SIGTERM. Returns the exit code: 2 when a port is taken or an option is wrong."""
    parser = _options()
    options = parser.parse_args(argv)
    if options.camera and options.autopilot == "ardupilot":
        parser.error(
            "--camera is a PX4's component; an ArduPilot has its camera itself, always: leave it out"
        )
    with contextlib.suppress(ValueError):  # not in the main thread: then it is the caller who ends us
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    home, heading_ned_rad = options.home
    try:
        airframe = load_airframe(options.airframe)
        params = Params(airframe.params)
    except (ValueError, KeyError, TypeError) as error:
        print(f"sitl: {error.args[0] if error.args else error}", file=sys.stderr)
        return 2
    vehicle = VehicleConfig(
        airframe=airframe,
        params=params,
        home=home,
        heading_ned_rad=heading_ned_rad,
        seed=options.seed,
        gps=options.gps,
        wind_ned_mps=options.wind,
        gusts=options.gust,
        faults=tuple(options.fault),
    )
    config = SimulatorConfig(
        vehicle,
        options.autopilot,
        options.instance,
        loss_scale=max(1.0, options.speedup),
        camera=options.camera,
        signing=None if options.signing is None else Signing(options.signing, signing_timestamp()),
    )
    try:
        _warm_up(config)
    except KeyboardInterrupt:
        print("sitl: stopped", flush=True)
        return 0
    try:
        links: tuple[Endpoint, ...]
        if options.autopilot == "px4":
            links = px4_links(options.bind, options.instance)
        else:
            links = ardupilot_links(options.bind, options.instance)
    except PortTakenError as error:
        print(f"sitl: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"sitl: cannot listen on {options.bind}: {error.strerror}", file=sys.stderr)
        return 2
    simulator = Simulator(config)
    exchange = simulator.exchange if options.tlog is None else _logged(simulator, options.tlog)
    print(
        f"sitl: {options.autopilot} {options.airframe}, system {options.instance + 1}, "
        f"{_where(options.autopilot, options.instance)}",
        flush=True,
    )
    ready = waits = False
    late_us = _READY_BY_US[options.autopilot] + max((f.end_us or 0 for f in options.fault), default=0)

    def tell() -> bool:
        nonlocal ready, waits
        flight = simulator.report.flight
        if not (ready or waits) and simulator.time_us > late_us:
            waits = True
            what = _awaited(simulator)
            print(f"[{1e-6 * simulator.time_us:8.2f} s] not ready to arm: it waits for {what}", flush=True)
        if not ready and flight.ready and flight.knows_place:
            ready = True
            print(f"[{1e-6 * simulator.time_us:8.2f} s] ready to arm", flush=True)
        for event in simulator.take_events():
            print(f"[{1e-6 * event.time_us:8.2f} s] {event.kind}: {event.text}", flush=True)
        return True

    try:
        if options.autopilot == "ardupilot":
            wait_for_client(links, options.instance)
        run(exchange, links, speedup=options.speedup, after_frame=tell)
    except KeyboardInterrupt:
        print("sitl: stopped", flush=True)
    finally:
        for link in links:
            link.close()
        if options.signing is not None:
            print(
                f"sitl: {simulator.refused} frames refused: unsigned, wrongly signed or replayed", flush=True
            )
    return 0


def _awaited(simulator: Simulator) -> str:
    """What keeps it from being ready."""
    report = simulator.report
    if report.instruments.gps is None:
        return "a GPS fix"
    estimate = report.estimate
    sound = {
        "attitude": estimate.attitude_ok,
        "position": estimate.position_ok,
        "velocity": estimate.velocity_ok,
        "height": estimate.height_ok,
    }
    missing = [name for name, ok in sound.items() if not ok]
    return f"a sound {' and '.join(missing)}" if missing else "its pre-arm checks"


def _warm_up(config: SimulatorConfig) -> None:
    """Live with a vehicle that is thrown away: numba compiles while nobody on the air waits for it."""
    with compiled_beside() as compiling:
        if compiling:
            print("sitl: compiling, this once; it may take a minute", flush=True)
    Simulator(config).exchange(_WARM_UP_US, (b"", b""))


Exchange = Callable[[int, tuple[bytes, ...]], tuple[bytes, ...]]


def _logged(simulator: Simulator, path: Path) -> Exchange:
    """The simulator's `exchange`, which also writes to a .tlog whatever passes."""
    log = TlogWriter(path.open("wb", buffering=0))

    def exchange(now_us: int, received: tuple[bytes, ...]) -> tuple[bytes, ...]:
        sent = simulator.exchange(now_us, received)
        log.write(simulator.time_us, *received, *sent)
        return sent

    return exchange


def _where(autopilot: str, instance: int) -> str:
    """On which ports it is found."""
    if autopilot == "px4":
        return f"UDP {_ports(OFFBOARD_PORTS, instance)} and {_ports(GCS_PORTS, instance)}"
    tcp = ", ".join(str(port + 10 * instance) for port in ARDUPILOT_TCP_PORTS)
    return f"TCP {tcp} and UDP →{GCS_PORTS[1] + 10 * instance}; boots when somebody comes to the first or listens on the last"


def _ports(ports: tuple[int, int], instance: int) -> str:
    local, remote = ports
    return f"{local + instance}→{remote + instance}"


def _options() -> argparse.ArgumentParser:
    parser = _Parser(prog="python -m sitl", description=__doc__)
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


if __name__ == "__main__":
    sys.exit(main())

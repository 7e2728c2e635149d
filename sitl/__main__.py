"""`python -m sitl`: the bundled vehicle on the ports of PX4's or ArduPilot's SITL."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from sitl.airframe import Airframe, load_airframe
from sitl.arguments import joined, parser_of_options
from sitl.compiling import compiled_beside
from sitl.link.endpoint import (
    ARDUPILOT_TCP_PORTS,
    GCS_PORTS,
    INSTANCE_STEP,
    OFFBOARD_PORTS,
    Endpoint,
    PortTakenError,
    ardupilot_links,
    px4_links,
)
from sitl.link.realtime import run, signing_timestamp, wait_for_client
from sitl.link.signing import Signing
from sitl.link.tlog import TlogWriter
from sitl.params import Params
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

__all__ = ["main"]

_WARM_UP_US = 3_000_000
_READY_BY_US = {"px4": 15_000_000, "ardupilot": 60_000_000}
"""Past these and the faults' ends something is wrong: healthy they are ready after 1.2 s and 41 s."""


def main(argv: list[str] | None = None) -> int:
    """Run the vehicle until Ctrl-C or SIGTERM. Returns the exit code: 2 when a port is taken or an option is wrong."""
    parser = parser_of_options(__doc__)
    options = parser.parse_args(joined(sys.argv[1:] if argv is None else argv))
    if options.camera and options.autopilot == "ardupilot":
        parser.error(
            "--camera is a PX4's component; an ArduPilot has its camera itself, always: leave it out"
        )
    with contextlib.suppress(ValueError):  # not in the main thread: then it is the caller who ends us
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        airframe = load_airframe(options.airframe)
        params = Params(airframe.params)
    except (ValueError, KeyError, TypeError) as error:
        print(f"sitl: {error.args[0] if error.args else error}", file=sys.stderr)
        return 2
    config = _config_of(options, airframe, params)
    links_of = px4_links if options.autopilot == "px4" else ardupilot_links
    try:
        for link in links_of(options.bind, options.instance):  # a taken port is said before anything compiles
            link.close()
        _warm_up(config)
        links: tuple[Endpoint, ...] = links_of(options.bind, options.instance)
    except KeyboardInterrupt:
        _print("sitl: stopped")
        return 0
    except PortTakenError as error:
        print(f"sitl: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"sitl: cannot listen on {options.bind}: {error.strerror}", file=sys.stderr)
        return 2
    simulator = Simulator(config)
    exchange = simulator.exchange if options.tlog is None else _logged(simulator, options.tlog)
    _print(
        f"sitl: {options.autopilot} {options.airframe}, system {options.instance + 1}, "
        f"{_where(options.autopilot, options.instance)}"
    )
    late_us = _READY_BY_US[options.autopilot] + max((f.end_us or 0 for f in options.fault), default=0)
    try:
        if options.autopilot == "ardupilot":
            wait_for_client(links, options.instance)
        run(exchange, links, speedup=options.speedup, after_frame=_teller(simulator, late_us))
    except KeyboardInterrupt:
        _print("sitl: stopped")
    finally:
        for link in links:
            link.close()
        if options.signing is not None:
            _print(f"sitl: {simulator.refused} frames refused: unsigned, wrongly signed or replayed")
    return 0


def _config_of(options: argparse.Namespace, airframe: Airframe, params: Params) -> SimulatorConfig:
    home, heading_ned_rad = options.home
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
    return SimulatorConfig(
        vehicle,
        options.autopilot,
        options.instance,
        loss_scale=max(1.0, options.speedup),
        camera=options.camera,
        signing=None if options.signing is None else Signing(options.signing, signing_timestamp()),
    )


def _teller(simulator: Simulator, late_us: int) -> Callable[[], bool]:
    """What prints after each frame what has happened: its events, and once that it is ready, or what it waits for since `late_us`."""
    ready = waits = False

    def tell() -> bool:
        nonlocal ready, waits
        flight = simulator.report.flight
        if not (ready or waits) and simulator.time_us > late_us:
            waits = True
            _print_at(simulator.time_us, f"not ready to arm: it waits for {_awaited(simulator)}")
        if not ready and flight.ready and flight.knows_place:
            ready = True
            _print_at(simulator.time_us, "ready to arm")
        for event in simulator.take_events():
            _print_at(event.time_us, f"{event.kind}: {event.text}")
        return True

    return tell


def _print_at(time_us: int, text: str) -> None:
    _print(f"[{1e-6 * time_us:8.2f} s] {text}")


def _print(text: str) -> None:
    """Print it at once. Who has stopped reading, as `| head` has, does not bring the vehicle down."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


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
            _print("sitl: compiling, this once; it may take a minute")
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
    tcp = ", ".join(str(port + INSTANCE_STEP * instance) for port in ARDUPILOT_TCP_PORTS)
    return f"TCP {tcp} and UDP →{GCS_PORTS[1] + INSTANCE_STEP * instance}; boots when somebody comes to the first or listens on the last"


def _ports(ports: tuple[int, int], instance: int) -> str:
    local, remote = ports
    return f"{local + instance}→{remote + instance}"


if __name__ == "__main__":
    sys.exit(main())

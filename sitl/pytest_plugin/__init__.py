"""pytest fixtures: a vehicle to test one's own MAVLink code against, and missions flown closed loop.

`sitl_vehicle` is a running vehicle on free ports, ready to arm, as PX4 over UDP or as ArduPilot over TCP.
`closed_loop` flies a mission file in lockstep. Options (`--sitl-seed` and so on) set what holds for all tests,
`@pytest.mark.sitl(seed=3, wind_mps=5)` for one. Of a failed test log and figure are kept, and the report says where.
Importing this costs nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from sitl.pytest_plugin.process import SitlOptions, SitlVehicle, start_vehicle

if TYPE_CHECKING:
    from mavspiral import Flight

__all__ = ["SitlOptions", "SitlVehicle", "closed_loop", "sitl_vehicle"]

_KEEPERS = pytest.StashKey[list[Callable[[Path], list[str]]]]()
_FIELDS = tuple(field.name for field in fields(SitlOptions))
_FLOWN = ("dialect", "seed", "wind_mps", "gusts", "faults", "airframe")
"""What a flight in lockstep has of them."""
_KEPT_IN = "sitl-failures"


def pytest_addoption(parser: pytest.Parser) -> None:
    """What holds for all tests that no marker says otherwise of."""
    group = parser.getgroup("sitl", "the bundled vehicle (sitl_vehicle, closed_loop)")
    group.addoption("--sitl-dialect", metavar="NAME", help="px4 or ardupilot (px4; a mission's own)")
    group.addoption("--sitl-seed", type=int, metavar="N", help="of the senses' noise (0)")
    group.addoption("--sitl-wind", type=float, metavar="MPS", help="steady wind (0)")
    group.addoption("--sitl-gusts", action="store_true", default=None, help="turbulence on top of it")
    group.addoption("--sitl-fault", action="append", metavar="SPEC", help="as gps_loss@60s+20s; repeatable")
    group.addoption("--sitl-airframe", metavar="NAME", help="which body (x500; a mission's own)")
    group.addoption("--sitl-speedup", type=float, metavar="X", help="times real time, over UDP (1)")
    group.addoption(
        "--sitl-camera", action="store_true", default=None, help="a PX4 carries a camera on a gimbal"
    )
    group.addoption("--sitl-keep", metavar="DIR", help=f"where failed tests leave their logs ({_KEPT_IN})")


def pytest_configure(config: pytest.Config) -> None:
    """Say that the marker exists."""
    config.addinivalue_line("markers", f"sitl({', '.join(_FIELDS)}): what this test's vehicle is like")


@pytest.fixture
def sitl_options(request: pytest.FixtureRequest) -> SitlOptions:
    """What the command line and this test's marker ask for."""
    option = request.config.getoption
    asked: dict[str, Any] = {
        "dialect": option("--sitl-dialect"),
        "seed": option("--sitl-seed"),
        "wind_mps": option("--sitl-wind"),
        "gusts": option("--sitl-gusts"),
        "faults": tuple(option("--sitl-fault") or ()) or None,
        "airframe": option("--sitl-airframe"),
        "speedup": option("--sitl-speedup"),
        "camera": option("--sitl-camera"),
    }
    asked = {name: value for name, value in asked.items() if value is not None}
    for marker in reversed(list(request.node.iter_markers("sitl"))):
        unknown = sorted(set(marker.kwargs) - set(_FIELDS))
        if marker.args or unknown:
            wrong = [*map(repr, marker.args), *unknown]
            raise pytest.UsageError(f"@pytest.mark.sitl({', '.join(wrong)}): it takes {', '.join(_FIELDS)}")
        asked |= marker.kwargs
    try:
        return SitlOptions(**asked)
    except ValueError as error:
        raise pytest.UsageError(f"sitl: {error}") from None


@pytest.fixture
def sitl_vehicle(
    request: pytest.FixtureRequest, sitl_options: SitlOptions, tmp_path: Path
) -> Iterator[SitlVehicle]:
    """A vehicle over UDP or TCP, ready to arm: `sitl_vehicle.url` is where MAVSDK finds it."""
    from sitl.pytest_plugin.evidence import keep_vehicle

    try:
        vehicle = start_vehicle(sitl_options, tmp_path / "vehicle.tlog")
    except RuntimeError as error:
        raise pytest.fail.Exception(f"sitl_vehicle: {error}", pytrace=False) from None
    _keepers(request).append(lambda folder: keep_vehicle(vehicle, folder))
    try:
        yield vehicle
    finally:
        vehicle.stop()


@pytest.fixture
def closed_loop(request: pytest.FixtureRequest, sitl_options: SitlOptions) -> Callable[..., Flight]:
    """Flies a mission file in lockstep and measures the flight.

    As in `flight = closed_loop("hut.toml", seed=3)`; then `flight.passed`, `flight.failures` and `flight.summary()`
    say what came of it. A keyword (dialect, seed, wind_mps, gusts, faults, airframe) goes before the marker's and
    the command line's; the camera is the mission's.
    """

    def fly(mission: Any, **changes: Any) -> Flight:
        __tracebackhide__ = True  # what is wrong with a wish is the test's own
        from mavspiral import MavspiralError
        from sitl.pytest_plugin.evidence import keep_flight

        try:
            flight, name = _flown(mission, sitl_options, changes)
        except MavspiralError as error:
            raise error.with_traceback(None) from None
        keepers = _keepers(request)
        name = f"{name}-{len(keepers)}"
        keepers.append(lambda folder: keep_flight(flight, folder / name))
        return flight

    return fly


def _flown(mission: Any, options: SitlOptions, changes: dict[str, Any]) -> tuple[Flight, str]:
    """The flight, and the mission's name.

    Raises:
        InputError: a keyword, a value or a mission that makes no flight.
        LimitError: the mission's plan does not hold.
    """
    from mavspiral import InputError, Mission, load_mission, simulate

    unknown = sorted(set(changes) - set(_FLOWN))
    if unknown:
        raise InputError(f"closed_loop({', '.join(unknown)}): it takes {', '.join(_FLOWN)}")
    try:
        options = replace(options, **changes)
    except ValueError as error:
        raise InputError(f"closed_loop: {error}") from None
    complaint = options.complaint()
    if complaint is not None:
        raise InputError(f"closed_loop: {complaint}")
    brief = mission if isinstance(mission, Mission) else load_mission(Path(mission))
    if options.airframe is not None:
        body = brief.vehicle.model_copy(update={"airframe": options.airframe})
        brief = brief.model_copy(update={"vehicle": body})
    flight = simulate(
        brief,
        seed=options.seed,
        wind_mps=options.wind_mps,
        gusts=options.gusts,
        faults=tuple(options.faults),
        autopilot=options.dialect,
    )
    return flight, brief.name


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Of a failed test, keep what its vehicles and flights left, and say where."""
    report = yield
    if report.failed:
        keepers = item.stash.get(_KEEPERS, [])
        lines = [line for keep in keepers for line in _kept(keep, _folder(item))]
        keepers.clear()
        if lines:
            report.sections.append(("sitl kept", "\n".join(lines)))
    return report


def _kept(keep: Callable[[Path], list[str]], folder: Path) -> list[str]:
    try:
        return keep(folder)
    except Exception as error:  # the test's own failure is what matters; this one is told beside it
        return [f"could not be kept in {folder}: {error!r}"]


def _keepers(request: pytest.FixtureRequest) -> list[Callable[[Path], list[str]]]:
    return request.node.stash.setdefault(_KEEPERS, [])  # type: ignore[no-any-return]  # `node` is Any


def _folder(item: pytest.Item) -> Path:
    kept_in = item.config.getoption("--sitl-keep") or item.config.rootpath / _KEPT_IN
    return Path(kept_in).absolute() / re.sub(r"[^\w.-]+", "-", item.nodeid).strip("-")

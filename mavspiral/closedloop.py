"""The whole chain in one process: planner, streamer and vehicle exchange MAVLink bytes on one simulated clock.

The session that flies here is the one that flies real vehicles, and it meets the vehicle only through bytes.
The only file of mavspiral that imports sitl.
"""

from __future__ import annotations

import io
import math
import time
from array import array
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mavspiral.errors import InputError, LimitError
from mavspiral.flight.auto_flight import AutoFlight
from mavspiral.flight.autopilots import PROFILES, Autopilot
from mavspiral.flight.flight_log import Event, TlogWriter
from mavspiral.flight.outcome import Outcome, SessionConfig
from mavspiral.flight.plan_upload import MissionLists
from mavspiral.flight.session import Session
from mavspiral.frames import GeoPoint
from mavspiral.handover import inspection_documents, inspection_missions
from mavspiral.inspection import Inspection
from mavspiral.logbook.flown import Flight, one_after_the_other
from mavspiral.logbook.measuring import Seen, measured
from mavspiral.mission import Mission
from mavspiral.motion.trajectory import Trajectory
from mavspiral.planner import OnStage, plan, to_nobody
from mavspiral.tour.sorties import Sortie
from mavspiral.uploads import mission_lists
from sitl.airframe import load_airframe
from sitl.compiling import compiled_beside
from sitl.faults import Fault, parse_fault
from sitl.params import Params
from sitl.rotation import to_yaw
from sitl.signals import GeoPoint as VehiclePoint
from sitl.signals import TruthState
from sitl.simulator import Simulator, SimulatorConfig
from sitl.vehicle import VehicleConfig

__all__ = ["simulate"]

TLOG_EPOCH_US = 1_577_836_800_000_000
"""Simulated flights are logged as if they began on 2020-01-01, so that equal flights give equal files."""

HEADING_NED_RAD = math.radians(40.0)
START_UP_US = 1_000_000
"""Wall time counts from here on: before it, numba loads or compiles."""

WITNESS_US = 20_000
"""The truth is written down as often as the session writes its log, and at the same moments."""

ALONE_US = 300_000_000
"""For so long at most a vehicle that we no longer fly is watched: a Return from 190 m takes 200 s."""

ABOVE_HOME_M = 1.0
SEEDS_APART = 1_000_003
"""From sortie to sortie: another vehicle, as it were, with senses of its own."""

Via = Literal["stream", "mission"]
"""How the vehicle is told where to fly."""

PATIENCE: dict[Via, float] = {"stream": 3.0, "mission": 6.0}
"""A flight may take this many times its planned duration; an autopilot that follows waypoints takes longer."""


def simulate(
    mission: Mission | Inspection,
    *,
    seed: int = 0,
    wind_mps: float = 0.0,
    gusts: bool = False,
    faults: tuple[str, ...] = (),
    via: Via = "stream",
    autopilot: Autopilot | None = None,
    set_failsafes: bool = False,
    on_stage: OnStage = to_nobody,
) -> Flight:
    """The mission (or its plan) flown from take-off to landing by the bundled vehicle; same seed, same bits.

    Streamed setpoint by setpoint, or `via` the exported mission, which the vehicle is given and flies in AUTO.
    Where one battery does not last, or one mission not do, every sortie is flown, each by a vehicle that was just switched
    on; faults strike the first.
    `autopilot` is whose behaviour it shows, else the mission's. The vehicle stands at the mission's home; its EKF's
    origin is neither that place nor the plan's origin. `set_failsafes` sets the vehicle's parameters for a lost link and a
    safe Return before a streamed flight, as `fly` does. `on_stage` is told how far the planning is.

    Raises:
        InputError: a fault that nobody knows.
        LimitError: the plan does not keep its own limits, or stretches of it have no mission that fits.
    """
    with compiled_beside():
        inspection = plan(mission, on_stage) if isinstance(mission, Mission) else mission
    if autopilot is not None:
        inspection = inspection.flown_by(autopilot)
    flights: list[Flight] = []
    for number, order in enumerate(_orders(inspection, via)):
        config = _config(inspection, seed + number * SEEDS_APART, wind_mps, gusts, () if number else faults)
        begins_s = sum(flight.sim_s for flight in flights)
        flights.append(_flown(inspection, order, config, seed, round(1e6 * begins_s), set_failsafes))
        if not flights[-1].outcome.ok:
            break
    return flights[0] if len(flights) == 1 else one_after_the_other(flights)


@dataclass(frozen=True, slots=True, eq=False)
class _Order:
    """A sortie to be streamed, or flown in AUTO: by those lists, which were made of that route."""

    sortie: Sortie
    auto: tuple[MissionLists, Trajectory] | None = None


def _orders(inspection: Inspection, via: Via) -> tuple[_Order, ...]:
    if via == "stream":
        return tuple(map(_Order, inspection.sorties()))
    name = inspection.mission.name
    handover = inspection_missions(inspection)
    if handover.refusals:
        raise LimitError(f"{name}: {'; '.join(handover.refusals)}")
    documents = inspection_documents(inspection, handover)
    return tuple(
        _Order(handed.sortie, (mission_lists(document), handed.route))
        for handed, document in zip(handover.sorties, documents, strict=True)
    )


def _flown(
    inspection: Inspection,
    order: _Order,
    config: SimulatorConfig,
    seed: int,
    begins_us: int,
    set_failsafes: bool,
) -> Flight:
    """One sortie, by a vehicle that was just switched on; its packets are dated from `begins_us` on."""
    simulator = Simulator(config)
    tape = io.BytesIO()
    tap = TlogWriter(tape.write, TLOG_EPOCH_US + begins_us).write
    session = _session(inspection, order, tap, set_failsafes)
    witness = _Witness(simulator)
    patience = PATIENCE["mission" if order.auto else "stream"]
    limit_us = round(1e6 * (patience * inspection.trajectory.duration_s + 300.0))
    now_us, to_vehicle = 0, b""
    begin_s = time.perf_counter()
    while session.outcome is None and now_us < limit_us:
        if now_us <= START_UP_US:
            begin_s = time.perf_counter()
        (to_us,) = simulator.exchange(now_us, (to_vehicle,))
        step = session.step(now_us, to_us)
        if step.afterwards is not None:
            step.afterwards()
        if now_us % WITNESS_US == 0:
            witness.note()
        to_vehicle = step.send
        now_us = step.next_due_us
    outcome = session.outcome or Outcome(False, session.state, f"not over after {now_us / 1e6:.0f} s", 1)
    ended_us = now_us
    now_us, mode = _lives_on(simulator, witness, now_us, to_vehicle)
    wall_s = time.perf_counter() - begin_s
    trajectory = session.trajectory if isinstance(session, Session) else order.auto and order.auto[1]
    if trajectory is None:
        raise LimitError(f"{inspection.mission.name}: the flight never began: {outcome.reason}")
    flight = measured(
        inspection,
        order.sortie,
        trajectory,
        session,
        outcome,
        witness.seen(),
        tlog=tape.getvalue(),
        seed=seed,
        sim_s=now_us / 1e6,
        wall_s=wall_s,
        rtf=(now_us / 1e6 - START_UP_US / 1e6) / wall_s,
    )
    return flight if now_us == ended_us else _with_its_end(flight, simulator, ended_us, mode)


def _lives_on(simulator: Simulator, witness: _Witness, now_us: int, to_vehicle: bytes) -> tuple[int, str]:
    """When a vehicle that was still armed as the session ended disarmed, or was given up, and in which mode.

    We send it nothing more.
    """
    until_us, mode = now_us + ALONE_US, ""
    while (status := simulator.report.flight).armed and now_us < until_us:
        mode = status.mode.name
        simulator.step(now_us, to_vehicle)
        if now_us % WITNESS_US == 0:
            witness.note()
        to_vehicle = b""
        now_us = (now_us // WITNESS_US + 1) * WITNESS_US
    return now_us, mode


def _with_its_end(flight: Flight, simulator: Simulator, ended_us: int, mode: str) -> Flight:
    """The flight, and in its events how the vehicle fared alone from `ended_us` on, by truth."""
    alone_m = flight.clearance_m[flight.clearance_t_s * 1e6 >= ended_us]
    took_s, armed = flight.sim_s - ended_us / 1e6, simulator.report.flight.armed
    away_m = float(np.hypot(*simulator.truth.position_ned_m[:2]))
    end = "is still armed after" if armed else "has disarmed after"
    words = (
        f"left alone the vehicle {end} {took_s:.0f} s, in {mode}, {away_m:.1f} m from home; "
        f"until then it was {alone_m.min():.2f} m from anything solid at least"
    )
    event = Event(round(flight.sim_s * 1e6), "warning", words)
    return replace(flight, log=replace(flight.log, events=(*flight.log.events, event)))


def _session(
    inspection: Inspection, order: _Order, tap: Callable[[int, bytes], None], set_failsafes: bool
) -> Session | AutoFlight:
    """Who flies the vehicle: we by a stream, or it by itself with the exported mission."""
    profile = PROFILES[inspection.mission.vehicle.autopilot]
    if order.auto is not None:
        return AutoFlight(order.auto[0], profile, tap=tap)
    return Session(
        lambda home_enu_m: inspection.route_from(home_enu_m, order.sortie),
        inspection.site.heights.frame,
        SessionConfig(safe_height_enu_m=inspection.safe_height_enu_m, set_failsafes=set_failsafes),
        way_home=inspection.way_home,
        profiles=(profile,),
        shots=inspection.shot_orders(order.sortie),
        tap=tap,
    )


def _config(
    inspection: Inspection, seed: int, wind_mps: float, gusts: bool, faults: tuple[str, ...]
) -> SimulatorConfig:
    mission = inspection.mission
    lowest_m = float(inspection.clearance.position_enu_m[:, 2].min())
    if lowest_m < inspection.home_enu_m[2] + ABOVE_HOME_M:
        raise InputError(
            f"[vehicle] home lies {inspection.home_enu_m[2]:.1f} m above ground and the flight goes down to {lowest_m:.1f} m: "
            "the bundled vehicle's ground is level at its home, so it cannot be simulated from a roof or a hill. "
            "Fix: a home at the building's foot"
        )
    try:
        orders: tuple[Fault, ...] = tuple(parse_fault(spec) for spec in faults)
    except ValueError as error:
        raise InputError(f"--{error}") from None
    airframe = load_airframe(mission.vehicle.airframe)
    home = inspection.site.heights.frame.geo_point(inspection.home_enu_m)
    return SimulatorConfig(
        vehicle=VehicleConfig(
            airframe=airframe,
            params=Params(airframe.params),
            home=VehiclePoint(home.lat_deg, home.lon_deg, home.alt_amsl_m),
            heading_ned_rad=HEADING_NED_RAD,
            seed=seed,
            gps=mission.vehicle.gps,
            wind_ned_mps=(0.0, wind_mps, 0.0),
            gusts=gusts,
            faults=orders,
        ),
        autopilot=mission.vehicle.autopilot,
    )


class _Witness:
    """Writes down the truth, and what the vehicle believes: neither reaches the session.

    As bare numbers: of a hundred thousand small objects Python's garbage collector would look after each.
    """

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._time_us: list[int] = []
        self._truths, self._beliefs = array("d"), array("d")

    def note(self) -> None:
        """Take the present state."""
        truth, belief = self._simulator.truth, self._simulator.estimate
        self._time_us.append(truth.time_us)
        self._truths.frombytes(truth.numbers.tobytes())
        self._beliefs.frombytes(belief.numbers.tobytes())

    def seen(self) -> Seen:
        """All that was noted; the vehicle must have found itself by now."""
        report, noted_n = self._simulator.report, len(self._time_us)
        truth = TruthState(0, np.frombuffer(self._truths).reshape(noted_n, -1))
        belief = report.estimate._replace(numbers=np.frombuffer(self._beliefs).reshape(noted_n, -1))
        origin = report.origin
        assert origin is not None, "a flight without an EKF origin"
        return Seen(
            time_us=np.array(self._time_us),
            position_ned_m=truth.position_ned_m,
            velocity_ned_mps=truth.velocity_ned_mps,
            yaw_ned_rad=np.array([to_yaw(tuple(q)) for q in truth.q_ned_frd.tolist()]),
            believed_ned_m=belief.position_ned_m,
            variance_ned_m2=belief.position_variance_m2,
            believed_origin=GeoPoint(origin.lat_deg, origin.lon_deg, origin.alt_amsl_m),
            battery_used=1.0 - report.instruments.battery.remaining,
        )

"""A `.plan` as the lists that go over the link: mission, fence, rally points; and on to a vehicle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mavspiral.errors import InputError
from mavspiral.export.check.findings import Findings
from mavspiral.export.check.loading import PlanParts, judge_loading
from mavspiral.export.check.simple_item import PlanItem
from mavspiral.flight.flight_log import Event
from mavspiral.flight.mission_messages import MissionItem, MissionKind
from mavspiral.flight.outcome import Outcome, Step
from mavspiral.flight.plan_upload import MissionLists
from mavspiral.flight.realtime import drive, signer_now
from mavspiral.flight.transports import open_transport
from mavspiral.flight.upload import AUTOPILOTS, Upload

__all__ = ["Uploaded", "mission_lists", "upload"]

GLOBAL, MISSION, RELATIVE = 0, 2, 3
WAYPOINT = 16
POLYGON_INSIDE, POLYGON_OUTSIDE, CIRCLE_INSIDE, CIRCLE_OUTSIDE, RALLY = 5001, 5002, 5003, 5004, 5100
ARDUPILOT = 3


@dataclass(frozen=True, slots=True)
class Uploaded:
    """What became of an upload: how many items of each list went up, and what came back otherwise."""

    outcome: Outcome
    items: int
    fence: int
    rally: int
    differences: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """The keys of `upload --json`."""
        return {
            "ok": self.outcome.ok,
            "items": self.items,
            "fence": self.fence,
            "rally": self.rally,
            "differences": list(self.differences) or ([] if self.outcome.ok else [self.outcome.reason]),
        }


def upload(
    document: dict[str, Any],
    url: str,
    *,
    signing_key: bytes | None = None,
    system_id: int | None = None,
    on_event: Callable[[Event], None] = lambda _event: None,
) -> Uploaded:
    """The plan on its way to the vehicle at `url`, read back and compared item by item.

    Args:
        document: a `.plan`.
        url: the vehicle's.
        signing_key: 32 bytes (`read_key`), with which both ends sign, and what is not signed is refused.
        system_id: of the vehicle; None for the first that is heard.
        on_event: is told how far it is, every few seconds.

    Raises:
        InputError: the plan cannot be loaded, or the URL cannot be read.
        LinkError: nobody listens at a TCP address.
    """
    lists = mission_lists(document)
    firmware = document["mission"]["firmwareType"]
    signer = None if signing_key is None else signer_now(signing_key)
    machine = Upload(
        lists, int(firmware) if firmware in AUTOPILOTS else None, signer=signer, system_id=system_id
    )
    transport = open_transport(url, system_id)

    def tell(_machine: Upload, step: Step) -> None:
        for event in step.events:
            on_event(event)

    try:
        outcome = drive(machine, transport, tell)
    finally:
        transport.close()
    items, fence, rally = (len(lists[kind]) for kind in MissionKind)
    return Uploaded(outcome, items, fence, rally, machine.differences)


def mission_lists(document: dict[str, Any]) -> MissionLists:
    """A `.plan`, anybody's, as what goes over the link: mission, fence and rally points. ArduPilot's begins with home.

    Raises:
        InputError: it cannot be loaded, or holds patterns that only QGroundControl makes items of.
    """
    findings = Findings()
    parts = judge_loading(document, findings)
    if findings.errors:
        raise InputError(f"the plan cannot be loaded: {findings.errors[0]}. `mavspiral check` tells all")
    if parts.hollow:
        raise InputError(
            f"{', '.join(parts.hollow)}: a pattern that keeps no items in the file, or old ones. Fix: upload the plan with "
            "QGroundControl"
        )
    mission = [_placed(item) for item in parts.items]
    if parts.firmware == ARDUPILOT and parts.home is not None:
        lat, lon, alt = parts.home
        home = (WAYPOINT, GLOBAL, (0.0, 0.0, 0.0, 0.0), lat, lon, 0.0 if math.isnan(alt) else alt)
        mission.insert(0, home)
    return {
        MissionKind.MISSION: _numbered(mission, MissionKind.MISSION),
        MissionKind.FENCE: _numbered(_fence(parts), MissionKind.FENCE),
        MissionKind.RALLY: _numbered(
            [(RALLY, RELATIVE, (0.0,) * 4, lat, lon, alt) for lat, lon, alt in parts.rally], MissionKind.RALLY
        ),
    }


_Bare = tuple[int, int, tuple[float, ...], float, float, float]


def _placed(item: PlanItem) -> _Bare:
    x, y, z = (0.0 if math.isnan(value) else value for value in item.params[4:])
    return item.command, item.frame, item.params[:4], x, y, z


def _fence(parts: PlanParts) -> list[_Bare]:
    corners: list[_Bare] = []
    for inside, polygon in parts.polygons:
        command = POLYGON_INSIDE if inside else POLYGON_OUTSIDE
        corners += [
            (command, GLOBAL, (float(len(polygon)), 0.0, 0.0, 0.0), lat, lon, 0.0) for lat, lon in polygon
        ]
    for inside, (lat, lon), radius_m in parts.circles:
        command = CIRCLE_INSIDE if inside else CIRCLE_OUTSIDE
        corners.append((command, GLOBAL, (radius_m, 0.0, 0.0, 0.0), lat, lon, 0.0))
    return corners


def _numbered(items: list[_Bare], kind: MissionKind) -> tuple[MissionItem, ...]:
    numbered = []
    for seq, (command, frame, params, x, y, z) in enumerate(items):
        scale = 1.0 if frame == MISSION else 1e7
        p1, p2, p3, p4 = params
        numbered.append(
            MissionItem(
                seq, command, frame, (p1, p2, p3, p4), round(x * scale), round(y * scale), z, True, kind
            )
        )
    return tuple(numbered)

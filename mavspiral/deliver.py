"""The files of a plan and of a flight, each written whole or not at all."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mavspiral.errors import InputError
from mavspiral.export.geo import trajectory_kml
from mavspiral.export.geojson import flight_geojson
from mavspiral.export.geotags import geo_txt, geotags_csv, photo_name
from mavspiral.export.tables import photos_csv, trajectory_csv
from mavspiral.export.waypoints import waypoints_text
from mavspiral.files import write_bytes, write_json, write_text
from mavspiral.handover import Handover, inspection_documents, inspection_missions, mission_warnings
from mavspiral.inspection import Inspection
from mavspiral.motion.trajectory import belongs
from mavspiral.show.figures import FlownPath, Profile, write_figure
from mavspiral.show.report import report_html
from mavspiral.show.rows import flight_rows, plan_rows
from mavspiral.show.skin import Skin

if TYPE_CHECKING:
    from mavspiral.logbook.flown import Flight
    from mavspiral.logbook.live_flight import LiveFlight

__all__ = ["write_flight", "write_live", "write_plan"]


def write_plan(inspection: Inspection, folder: Path, summary: dict[str, Any]) -> dict[str, str]:
    """The plan's files by kind: plan, waypoints, csv, photos, kml, geojson, png and json (the summary).

    `summary` is told how many missions there are, and what it costs to fly them.
    """
    mission, frame, trajectory = inspection.mission, inspection.site.heights.frame, inspection.trajectory
    handover = inspection_missions(inspection)
    summary["missions"] = len(handover.sorties)
    summary["warnings"] = [*summary["warnings"], *mission_warnings(handover, mission.vehicle.max_items)]
    base = folder / mission.name
    files = _write_missions(inspection, handover, base) | {
        "csv": write_text(base.with_name(f"{mission.name}.csv"), trajectory_csv(trajectory, frame)),
        "photos": write_text(
            base.with_name(f"{mission.name}.photos.csv"),
            photos_csv(inspection.shots, frame, mission.camera.first_photo),
        ),
        "kml": write_text(
            base.with_name(f"{mission.name}.kml"), trajectory_kml(trajectory, frame, mission.name)
        ),
        "geojson": write_json(
            base.with_name(f"{mission.name}.geojson"),
            flight_geojson(trajectory, inspection.shots, frame, mission.name),
        ),
        "png": write_figure(
            base.with_name(f"{mission.name}.png"),
            title=f"{mission.name}: planned",
            site=inspection.site,
            trajectory=trajectory,
            profiles=_plan_profiles(inspection),
            inspection_s=trajectory.spans_s("inspection"),
            facts=tuple((name, value) for name, value, _ in plan_rows(summary)),
            skin=Skin(inspection.site, inspection.coverage, mission.inspection.roof),
        ),
    }
    names = {kind: str(path) for kind, path in files.items()}
    names["json"] = str(base.with_name(f"{mission.name}.json"))
    write_json(Path(names["json"]), {**summary, "files": names})
    return names


def _write_missions(inspection: Inspection, handover: Handover, base: Path) -> dict[str, Path]:
    """NAME.plan and NAME.waypoints; NAME.1.plan and so on where there are several, none where none fits."""
    files = {}
    documents = inspection_documents(inspection, handover)
    for number, (items, document) in enumerate(zip(handover.missions, documents, strict=True), start=1):
        stem, kind = (base.name, "") if len(documents) == 1 else (f"{base.name}.{number}", f"_{number}")
        files[f"plan{kind}"] = write_json(base.with_name(f"{stem}.plan"), document)
        files[f"waypoints{kind}"] = write_text(base.with_name(f"{stem}.waypoints"), waypoints_text(items))
    return files


def write_flight(flight: Flight, folder: Path, summary: dict[str, Any]) -> dict[str, str]:
    """The plan's files, and the flight's: tlog, npz, png, html and json."""
    inspection = flight.inspection
    name = inspection.mission.name
    names = write_plan(inspection, folder, inspection.summary())
    picture = (
        _flight_picture(flight, folder / f"{name}.flight.png", summary) if flight.left_the_ground else None
    )
    flight.log.save(folder / f"{name}.flight.npz")
    page = report_html(
        title=name,
        subtitle=f"simulated flight, seed {flight.seed}, {summary['autopilot']}; all distances by truth",
        passed=flight.passed,
        failures=flight.failures,
        warnings=inspection.warnings,
        figures=flight_rows(summary, inspection.mission),
        events=((e.t_us / 1e6, e.severity, e.text) for e in flight.log.events),
        picture=picture or Path(names["png"]),
    )
    names |= {
        "tlog": str(write_bytes(folder / f"{name}.tlog", flight.tlog)),
        "npz": str(folder / f"{name}.flight.npz"),
        "html": str(write_text(folder / f"{name}.html", page)),
        "simulate_json": str(folder / f"{name}.simulate.json"),
    }
    if picture is not None:
        names["flight_png"] = str(picture)
    write_json(Path(names["simulate_json"]), {**summary, "files": names})
    return names


def _flight_picture(flight: Flight, path: Path, summary: dict[str, Any]) -> Path:
    inspection, log = flight.inspection, flight.log
    assert log.truth_position_enu_m is not None
    return write_figure(
        path,
        title=f"{inspection.mission.name}: planned and flown",
        site=inspection.site,
        trajectory=inspection.trajectory,
        profiles=_flight_profiles(flight),
        facts=tuple((name, value) for name, value, _ in flight_rows(summary, inspection.mission)),
        skin=Skin(inspection.site, flight.coverage, inspection.mission.inspection.roof),
        flown=FlownPath(log.t_us / 1e6, log.truth_position_enu_m, "truth"),
        inspection_s=_inspection_s(flight),
    )


def write_live(flight: LiveFlight, folder: Path, summary: dict[str, Any]) -> dict[str, str]:
    """The files of a real flight by kind: what grew as it flew, npz (when it came off the ground), geotags, geo_txt and json.

    Each earlier flight that it went on from gets its log too, from the journal, as NAME.1.flight.npz and so on. What cannot be
    written, as on a full disk, is not among them but among the summary's warnings: its figures are all the more wanted then.
    """
    name = flight.inspection.mission.name
    first_photo = flight.inspection.mission.camera.first_photo
    frame = flight.inspection.site.heights.frame
    writers: dict[str, tuple[str, Callable[[Path], object]]] = {}
    if flight.log is not None:
        writers["npz"] = f"{name}.flight.npz", flight.log.save
    if flight.shots is not None and flight.photo_numbers:
        photos = tuple(photo_name(first_photo, n) if n >= 0 else None for n in flight.photo_numbers)
        for kind, ending, table in (("geotags", "geotags.csv", geotags_csv), ("geo_txt", "geo.txt", geo_txt)):
            text = table(flight.shots, photos, frame)
            writers[kind] = f"{name}.{ending}", partial(write_text, content=text)
    for number, log in enumerate(flight.earlier, start=1):
        writers[f"npz_{number}"] = f"{name}.{number}.flight.npz", log.save
    names = {**flight.files, "fly_json": str(folder / f"{name}.fly.json")}
    warnings = summary["warnings"]
    for kind, (file, write) in writers.items():
        names |= _written(kind, folder / file, write, warnings)
    document = {**summary, "files": names}
    if not _written(
        "fly_json", folder / f"{name}.fly.json", partial(write_json, document=document), warnings
    ):
        del names["fly_json"]
    return names


def _written(kind: str, path: Path, write: Callable[[Path], object], warnings: list[str]) -> dict[str, str]:
    """The file by its kind; nothing but a warning if it could not be written."""
    try:
        write(path)
    except InputError as error:
        warnings.append(str(error))
        return {}
    return {kind: str(path)}


def _inspection_s(flight: Flight) -> tuple[tuple[float, float], ...]:
    """When each inspecting leg that was reached began and ended."""
    log = flight.log
    rows = [log.t_us[log.on_leg(leg)] / 1e6 for leg in log.legs if belongs(leg, "inspection")]
    return tuple((float(t_s[0]), float(t_s[-1])) for t_s in rows if len(t_s))


def _plan_profiles(inspection: Inspection) -> tuple[Profile, ...]:
    states = inspection.trajectory.sampled(0.1)
    figures, clearance = inspection.certificate, inspection.clearance

    def norm(vectors: np.ndarray) -> np.ndarray:
        lengths: np.ndarray = np.sqrt((vectors**2).sum(axis=1))
        return lengths

    return (
        Profile("speed, m/s", states.t_s, norm(states.velocity_enu_mps), figures["speed"].allowed),
        Profile(
            "acceleration, m/s²",
            states.t_s,
            norm(states.acceleration_enu_mps2),
            figures["acceleration"].allowed,
        ),
        Profile("jerk, m/s³", states.t_s, norm(states.jerk_enu_mps3), figures["jerk"].allowed),
        Profile(
            "clearance, m",
            clearance.t_s,
            clearance.distance_m,
            inspection.clearance_required_m,
            words="at least",
        ),
    )


def _flight_profiles(flight: Flight) -> tuple[Profile, ...]:
    log = flight.log
    assert log.truth_position_enu_m is not None
    t_s = log.t_us / 1e6
    error_m = np.sqrt(((log.truth_position_enu_m - log.reference_position_enu_m) ** 2).sum(axis=1))
    believed_m = np.sqrt(((log.truth_position_enu_m - log.estimate_position_enu_m) ** 2).sum(axis=1))
    accept = flight.inspection.mission.accept
    return (
        Profile(
            "tracking error by truth, m",
            t_s,
            error_m,
            accept.tracking_p95_m,
            words="95 % at most",
            inspecting=True,
        ),
        Profile("estimate against truth, m", t_s, believed_m),
        Profile("height above the building's ground, m", t_s, log.truth_position_enu_m[:, 2]),
        Profile(
            "clearance, m",
            flight.clearance_t_s,
            flight.clearance_m,
            accept.clearance_min_m,
            words="at least",
        ),
    )

"""The figures of a summary in words, for the terminal and for the report."""

from __future__ import annotations

from typing import Any

from mavspiral.brief import budget_of
from mavspiral.mission import Mission

__all__ = ["flight_rows", "live_rows", "plan_rows"]


def plan_rows(s: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Name, value and limit of each figure of a plan's summary."""
    series = [count for count in s["harmonics"] if count]  # what is flown to and fro or straight has none
    return [
        ("turns that climb", f"{s['rings']}", ""),
        *([("harmonics", ", ".join(map(str, series)), "")] if series else []),
        (
            "length of the spiral" if s["parts"] == 1 else f"length of the {s['parts']} passes",
            f"{s['length_m']:.0f} m",
            "",
        ),
        ("duration", f"{s['duration_s']:.0f} s", ""),
        ("speed, at most", f"{s['speed_max_mps']:.2f} m/s", ""),
        ("acceleration, at most", f"{s['acceleration_max_mps2']:.2f} m/s²", ""),
        ("jerk, at most", f"{s['jerk_max_mps3']:.2f} m/s³", ""),
        ("yaw rate, at most", f"{s['yaw_rate_max_dps']:.1f} °/s", ""),
        ("blur, at most", f"{s['blur_max_px']:.2f} px", ""),
        ("clearance, at least", f"{s['clearance_min_m']:.2f} m", f"≥ {s['clearance_required_m']:.2f} m"),
        _budget(s["clearance_budget"]),
        ("photos", f"{s['photos']}", ""),
        ("walls seen", _share(s["coverage"]["walls"]), ""),
        *_of_seeable(s, "walls"),
        *_roof(s),
        *_of_seeable(s, "roof"),
        ("pixel on the wall, 95 %", _with_unit(s["coverage"]["gsd_p95_mm"], "mm"), ""),
        ("incidence, 95 %", _with_unit(s["coverage"]["incidence_p95_deg"], "°"), ""),
        ("planning", f"{1e-3 * s['planning_ms']['total']:.2f} s", ""),
    ]


def flight_rows(s: dict[str, Any], mission: Mission) -> list[tuple[str, str, str]]:
    """Name, value and what [accept] asks of each figure of a flight's summary."""
    accept = mission.accept

    def asked(value: float | None, sign: str, unit: str) -> str:
        return "" if value is None else f"{sign} {value:g} {unit}"

    return [
        ("flight", f"{s['sim_s']:.1f} s", asked(accept.duration_max_s, "≤", "s")),
        ("real-time factor", f"{s['rtf']:.0f} ×", ""),
        ("tracking, RMS", _metres(s["tracking"]["rms_m"]), ""),
        ("tracking, 95 %", _metres(s["tracking"]["p95_m"]), asked(accept.tracking_p95_m, "≤", "m")),
        ("tracking, worst", _metres(s["tracking"]["max_m"]), asked(accept.tracking_max_m, "≤", "m")),
        ("estimator, RMS", _metres(s["estimator"]["rms_m"]), ""),
        ("clearance, least", _metres(s["clearance_min_m"]), asked(accept.clearance_min_m, "≥", "m")),
        _budget(budget_of(mission).summary(mission.limits.clearance_m)),
        (
            "walls seen",
            _share(s["coverage"]["walls"]),
            "" if accept.coverage is None else f"≥ {_share(accept.coverage)}",
        ),
        *_of_seeable(s, "walls"),
        *_roof(
            s,
            "" if accept.coverage is None or not mission.inspection.roof else f"≥ {_share(accept.coverage)}",
        ),
        *_of_seeable(s, "roof"),
        ("battery used", f"{s['battery_used_pct']:.0f} %", ""),
        *_setpoints(s),
    ]


def live_rows(s: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Name and value of each figure of a real flight's summary, by the vehicle's own estimate; none if it stayed on the ground."""
    if s["clearance_min_m"] is None:
        return []
    return [
        ("flight", f"{s['duration_s']:.1f} s", ""),
        ("tracking, 95 %", _metres(s["tracking"]["p95_m"]), ""),
        ("tracking, worst", _metres(s["tracking"]["max_m"]), ""),
        ("clearance, least", _metres(s["clearance_min_m"]), ""),
        ("walls seen", _share(s["coverage"]["walls"]), ""),
        ("inspected", f"{s['inspected']['done_s']:.0f} of {s['inspected']['of_s']:.0f} s", ""),
        ("setpoints", f"{s['setpoints']['sent']} at {s['setpoints']['rate_hz']:.1f} Hz", ""),
        ("shots", f"{s['shots']['taken']} taken, {len(s['shots']['missed'])} missed", ""),
        ("worst gap", f"{s['setpoints']['worst_gap_s']:.3f} s", ""),
        *([] if s["refused"] is None else [("frames refused", f"{s['refused']}", "")]),
    ]


def _budget(b: dict[str, float]) -> tuple[str, str, str]:
    """What is required of the clearance: the larger of what was asked for and the sum of what may go wrong."""
    terms = (
        f"vehicle {b['vehicle_radius_m']:.2f} m + 3·√(map {b['map_sigma_m']:.2f}² + "
        f"navigation {b['navigation_sigma_m']:.2f}² + tracking {b['tracking_sigma_m']:.2f}²)"
    )
    why = f"the larger of {b['asked_m']:.2f} m asked for and {b['total_m']:.2f} m = {terms}"
    return "clearance required", f"{b['required_m']:.2f} m", why


def _setpoints(s: dict[str, Any]) -> list[tuple[str, str, str]]:
    """What was streamed; a mission in AUTO needs nothing."""
    if s["via"] == "mission":
        return [("flown by", "the vehicle itself, in AUTO", "")]
    return [("setpoints", f"{s['setpoints']['sent']} at {s['setpoints']['rate_hz']:.1f} Hz", "")]


def _roof(s: dict[str, Any], asked: str = "") -> list[tuple[str, str, str]]:
    """The roofs' row, if they were asked for and some of them is seen."""
    seen, wanted = s["coverage"]["roof"], s["coverage"]["roof_seeable"] is not None
    return [("roofs seen", _share(seen), asked)] if seen and wanted else []


def _of_seeable(s: dict[str, Any], kind: str) -> list[tuple[str, str, str]]:
    """The row of what is seen of what any safe pose could see, where that is known and not all."""
    share = s["coverage"][f"{kind}_of_seeable"]
    if share is None:
        return []
    of = f"of {_share(s['coverage'][f'{kind}_seeable'])} that a safe pose could see"
    return [(f"{'walls' if kind == 'walls' else 'roofs'} seen, of the seeable", _share(share), of)]


def _share(value: float | None) -> str:
    return "not measured" if value is None else f"{100 * value:.1f} %"


def _with_unit(value: float | None, unit: str) -> str:
    return "not measured" if value is None else f"{value:.1f} {unit}"


def _metres(value: float | None) -> str:
    return "not measured" if value is None else f"{value:.3f} m"

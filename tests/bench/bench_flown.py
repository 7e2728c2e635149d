"""What the stream is asked for, flown by the bundled vehicle in both dialects: `python tests/bench/bench_flown.py [NAME …]`.

By truth, RTK. Rows: the torre in a calm and in gusts of 8 m/s at 6 m; the kiosk with 30 % of the packets lost each way and
200 ms of delay, and with the link cut for 20 s in mid-inspection, resumed by the user until nothing is left; 20 uploads of 500
items with 30 % of the frames lost each way, at once and 200 ms late. Without NAME all of upload, calm, gusts, loss, cut. How punctual setpoints are:
`bench_schedule.py`; the stream beside AUTO: `stream_vs_mission.py`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "mavspiral"), str(ROOT / "tests" / "flight")]

from lockstep import flown, resumed_until_nothing_is_left, together  # noqa: E402
from lossy_air import Air  # noqa: E402

from mavspiral import load_mission, plan  # noqa: E402
from mavspiral.closedloop import simulate  # noqa: E402
from mavspiral.flight.autopilots import Autopilot  # noqa: E402
from mavspiral.flight.mission_messages import MissionItem, MissionKind  # noqa: E402
from mavspiral.flight.outcome import State  # noqa: E402
from mavspiral.flight.upload import Upload  # noqa: E402
from mavspiral.frames import wrap_rad  # noqa: E402
from mavspiral.inspection import Inspection  # noqa: E402
from mavspiral.logbook.flown import Flight  # noqa: E402
from mavspiral.survey.solids import Solids  # noqa: E402
from sitl.airframe import load_airframe  # noqa: E402
from sitl.params import Params  # noqa: E402
from sitl.signals import GeoPoint as VehiclePoint  # noqa: E402
from sitl.simulator import Simulator, SimulatorConfig  # noqa: E402
from sitl.vehicle import VehicleConfig  # noqa: E402

DIALECTS: tuple[Autopilot, ...] = ("px4", "ardupilot")
UPLOADS_N = 20
ASKED_P95_M = {"px4": 0.3, "ardupilot": 0.45}


def planned(name: str) -> Inspection:
    return plan(load_mission(ROOT / "missions" / f"{name}.toml"))


def heading_p95_deg(flight: Flight) -> float:
    """The true heading off the reference's, over the inspection."""
    log = flight.log
    on = log.on_leg("inspection")
    off = wrap_rad(log.truth_yaw_enu_rad[on] - log.reference_yaw_enu_rad[on])
    return float(np.degrees(np.quantile(np.abs(off), 0.95)))


def row(what: str, measured: str, asked: str, holds: bool) -> None:
    print(f"{what:44}{measured:>12}   {asked:24}{'' if holds else 'DOES NOT HOLD'}", flush=True)


def calm_and_gusts(dialect: Autopilot, torre: Inspection, *, gusts: bool) -> None:
    torre = torre.flown_by(dialect)
    calm = simulate(torre, seed=1)
    least_m = torre.mission.limits.clearance_m
    p95_m, heading_deg = calm.tracking_p95_m, heading_p95_deg(calm)
    asked_m = ASKED_P95_M[dialect]
    row(f"{dialect} torre calm, truth p95", f"{p95_m:.3f} m", f"≤ {asked_m:g} m", p95_m <= asked_m)
    row(f"{dialect} torre calm, heading p95", f"{heading_deg:.2f}°", "≤ 2°", heading_deg <= 2.0)
    row(f"{dialect} torre calm, clearance", f"{calm.clearance_min_m:.2f} m", f"≥ {least_m:g} m", calm.clearance_min_m >= least_m)  # fmt: skip
    if gusts:
        windy = simulate(torre, seed=1, wind_mps=8.0, gusts=True)
        lost = calm.coverage.walls - windy.coverage.walls
        kept = windy.clearance_min_m >= least_m and windy.outcome.ok
        row(
            f"{dialect} torre 8 m/s gusty, clearance",
            f"{windy.clearance_min_m:.2f} m",
            f"≥ {least_m:g} m",
            kept,
        )
        row(
            f"{dialect} torre 8 m/s gusty, walls lost",
            f"{100 * lost:.2f} %",
            "≤ 1 % of the calm's",
            lost <= 0.01,
        )


def loss(dialect: Autopilot, kiosk: Inspection) -> None:
    kiosk, least_m = kiosk.flown_by(dialect), kiosk.mission.limits.clearance_m
    session, truth_enu_m = flown(kiosk, seed=1, loss=0.3, delay_us=200_000)
    nearest_m = float(Solids.of_map(kiosk.site.heights).distance_m(truth_enu_m).min())
    ok = session.outcome is not None and session.outcome.ok
    ended = "completed" if ok else f"{session.outcome}"
    row(f"{dialect} kiosk 30 % lost, 200 ms late", ended, "completes", ok)
    row(f"{dialect} kiosk 30 % lost, 200 ms late, clearance", f"{nearest_m:.2f} m", f"≥ {least_m:g} m", nearest_m >= least_m)  # fmt: skip


def cut(dialect: Autopilot, kiosk: Inspection) -> None:
    kiosk, least_m = kiosk.flown_by(dialect), kiosk.mission.limits.clearance_m
    begun: list[int] = []

    def cuts(now_us: int, session: object, air: tuple) -> None:
        if session.state is State.STREAM and session.path_t_s > 30.0 and not begun:
            begun.append(now_us)
        for way in air:
            way.cut = bool(begun) and now_us < begun[0] + 20_000_000

    sessions, truths, shots = resumed_until_nothing_is_left(kiosk, seed=1, each=cuts, set_failsafes=True)
    seen = kiosk.coverage_from(together(tuple(shots))).walls
    solids = Solids.of_map(kiosk.site.heights)
    nearest_m = min(float(solids.distance_m(truth).min()) for truth in truths)
    print(f"    {dialect}, link cut for 20 s: {'; '.join(s.outcome.reason for s in sessions if s.outcome)}")
    row(f"{dialect} kiosk link cut, {len(sessions)} flights, walls", f"{100 * seen:.2f} %", "as planned", seen >= kiosk.coverage.walls - 1e-9)  # fmt: skip
    row(
        f"{dialect} kiosk link cut, clearance", f"{nearest_m:.2f} m", f"≥ {least_m:g} m", nearest_m >= least_m
    )


def upload(dialect: Autopilot) -> None:
    """500 items: home, a take-off, a line of waypoints and no return, through the machine that `mavspiral upload` drives."""
    line = [
        MissionItem(
            seq, 16, 3, (0.0,) * 4, 474_000_000 + 7 * seq, 85_500_000, 30.0, True, MissionKind.MISSION
        )
        for seq in range(500)
    ]
    line[:2] = line[0]._replace(frame=0), line[1]._replace(command=22)
    for delay_us in (0, 200_000):
        took_s = [uploaded_s(dialect, line, seed, delay_us) for seed in range(UPLOADS_N)]
        done_s = [one for one in took_s if one is not None]
        least, middle, most = np.quantile(done_s, (0.0, 0.5, 1.0)) if done_s else (np.nan,) * 3
        row(
            f"{dialect} 500 items up and back, 30 % lost, {delay_us // 1000} ms",
            f"{len(done_s)} of {UPLOADS_N}",
            f"all equal ({least:.0f} to {most:.0f}, median {middle:.0f} s)",
            len(done_s) == UPLOADS_N,
        )


def uploaded_s(dialect: Autopilot, items: list[MissionItem], seed: int, delay_us: int) -> float | None:
    """How long it took, in simulated seconds, until they had come back equal; None if they did not."""
    airframe = load_airframe("x500")
    place = VehiclePoint(47.4, 8.55, 500.0)
    simulator = Simulator(SimulatorConfig(VehicleConfig(airframe, Params(airframe.params), place), dialect))
    machine = Upload({MissionKind.MISSION: items}, None)
    up, down = Air(0.3, seed, delay_us), Air(0.3, seed + UPLOADS_N, delay_us)
    now_us, to_vehicle, begin_us = 0, b"", 5_000_000
    while machine.outcome is None and now_us < 3_600_000_000:
        heard = down.carry(now_us, simulator.step(now_us, up.carry(now_us, to_vehicle)).send)
        to_vehicle = machine.step(now_us, heard).send if now_us >= begin_us else b""
        now_us += 20_000
    if machine.outcome is None or not machine.outcome.ok or machine.differences:
        print(f"    seed {seed}: {machine.outcome}")
        return None
    return (now_us - begin_us) / 1e6


def main() -> None:
    wanted = set(sys.argv[1:]) or {"upload", "calm", "gusts", "loss", "cut"}
    if wanted - {"upload"}:
        kiosk = planned("kiosk")
        torre = planned("torre") if wanted & {"calm", "gusts"} else kiosk
    for dialect in DIALECTS:
        if "upload" in wanted:
            upload(dialect)
        if "loss" in wanted:
            loss(dialect, kiosk)
        if "cut" in wanted:
            cut(dialect, kiosk)
        if wanted & {"calm", "gusts"}:
            calm_and_gusts(dialect, torre, gusts="gusts" in wanted)


if __name__ == "__main__":
    main()

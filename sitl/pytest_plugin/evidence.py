"""What is kept of a failed test: the vehicle's log, its words, and a picture of where it was."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from sitl.pytest_plugin.process import SitlVehicle

__all__ = ["keep_flight", "keep_vehicle"]


def keep_vehicle(vehicle: SitlVehicle, folder: Path) -> list[str]:
    """Copies the .tlog, writes what the vehicle printed and draws its way; what was kept, a line each."""
    folder.mkdir(parents=True, exist_ok=True)
    tlog, words = folder / "vehicle.tlog", folder / "vehicle.txt"
    shutil.copyfile(vehicle.tlog, tlog)
    words.write_text("\n".join(vehicle.lines) + "\n", encoding="utf-8")
    kept = [f"tlog: {tlog}", f"printed: {words}"]
    if vehicle.process.poll():
        kept.append(f"process: it had ended by itself, with exit code {vehicle.process.returncode}")
    picture = _draw(tlog, folder / "vehicle.png")
    return [*kept, f"figure: {picture}" if picture else "figure: none, it never told where it was"]


def keep_flight(flight: Any, folder: Path) -> list[str]:
    """Writes all files of a closed-loop flight; what was kept, a line each."""
    from mavspiral.deliver import write_flight

    folder.mkdir(parents=True, exist_ok=True)
    files = write_flight(flight, folder, flight.summary())
    figure = files.get("flight_png") or files["png"]
    return [f"tlog: {files['tlog']}", f"figure: {figure}", f"report: {files['html']}"]


def _draw(tlog: Path, path: Path) -> Path | None:
    """The way over ground and the height, as the vehicle told them; None when it told nothing."""
    from matplotlib.figure import Figure

    track = _track(tlog)
    if not track:
        return None
    t_s, north_m, east_m, down_m = zip(*track, strict=True)
    figure = Figure(figsize=(10.0, 4.5), layout="constrained")
    plan, height = figure.subplots(1, 2)
    plan.plot(east_m, north_m)
    plan.set(xlabel="east, m", ylabel="north, m", title="way over ground, as estimated", aspect="equal")
    height.plot(t_s, [-down for down in down_m])
    height.set(xlabel="simulated time, s", ylabel="height above the EKF's origin, m", title="height")
    figure.savefig(path, dpi=100)
    return path


def _track(tlog: Path) -> list[tuple[float, float, float, float]]:
    """Time in seconds, north, east and down of each LOCAL_POSITION_NED."""
    from sitl.link.codec import Codec
    from sitl.link.messages import message_type
    from sitl.link.tlog import logged_frames

    codec, kind = Codec(0, 0), message_type("LOCAL_POSITION_NED")
    told = (item.message for frame in logged_frames(tlog.read_bytes()) for item in codec.decode(frame))
    return [(m.time_boot_ms * 1e-3, m.x, m.y, m.z) for m in told if isinstance(m, kind)]

"""What is known of an airframe before it flies: one TOML file, read and judged here."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from sitl.kernels import FloatArray

__all__ = [
    "RECEIVERS",
    "Airframe",
    "Battery",
    "Body",
    "Ground",
    "Receiver",
    "Rotors",
    "Senses",
    "load_airframe",
]


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The rigid body."""

    mass_kg: float
    inertia_kgm2: FloatArray
    drag_area_m2: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Rotors:
    """Four equal rotors in PX4's order; `spin` is +1 for one that turns counter-clockwise seen from above."""

    position_frd_m: FloatArray
    radius_m: float
    spin: FloatArray
    thrust_n_per_radps2: float
    torque_per_thrust_m: float
    drag_n_per_radps_mps: float
    time_constant_up_s: float
    time_constant_down_s: float
    speed_max_radps: float
    idle: float


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """How it stands: the feet's places under the centre of mass, how far they give way, their friction."""

    leg_height_m: float
    feet_frd_m: FloatArray
    sink_m: float
    friction: float


@dataclass(frozen=True, slots=True)
class Battery:
    """The pack and what drains it."""

    cells: int
    capacity_ah: float
    cell_full_v: float
    cell_empty_v: float
    resistance_ohm: float
    motor_efficiency: float
    avionics_w: float


@dataclass(frozen=True, slots=True)
class Senses:
    """The sensors' data sheets. The body errs by them, the estimator knows them."""

    gyro_noise_radps_rthz: float
    accel_noise_mps2_rthz: float
    gyro_walk_radps2_rthz: float
    accel_walk_mps3_rthz: float
    gyro_bias_radps: float
    accel_bias_mps2: float
    gyro_scale: float
    accel_scale: float
    baro_noise_m: float
    baro_drift_m: float
    baro_wash_m: float
    baro_speed_share: float
    mag_noise_gauss: float


@dataclass(frozen=True, slots=True, eq=False)
class Airframe:
    """A quadrotor. `params` are its departures from PX4's defaults."""

    name: str
    body: Body
    rotors: Rotors
    ground: Ground
    battery: Battery
    senses: Senses
    params: dict[str, float | int]


class Receiver(NamedTuple):
    """A GNSS receiver's sheet: 1 σ of its white, its wandering (Gauss–Markov) and its speed error."""

    white_h_m: float
    white_v_m: float
    wander_h_m: float
    wander_v_m: float
    wander_time_s: float
    speed_mps: float
    fix_type: int
    satellites: int

    @property
    def sigma(self) -> tuple[float, float, float]:
        """What it reports: 1 σ of position, horizontally and vertically, and of speed."""
        return (
            math.hypot(self.white_h_m, self.wander_h_m),
            math.hypot(self.white_v_m, self.wander_v_m),
            self.speed_mps,
        )


RECEIVERS: Final = {
    # u-blox ZED-F9P, fixed ambiguities: 0.01 m + 1 ppm horizontally, 0.05 m/s; vertical 1.5 to 2 times.
    "rtk": Receiver(0.012, 0.02, 0.008, 0.015, 60.0, 0.03, fix_type=6, satellites=24),
    # u-blox M9N under open sky: 1.5 m CEP over a day, of which most wanders.
    "standard": Receiver(0.3, 0.45, 0.7, 1.05, 120.0, 0.1, fix_type=3, satellites=16),
}


def load_airframe(name: str | Path) -> Airframe:
    """The airframe of a TOML file, or a bundled one by its name.

    Raises:
        ValueError: no such airframe or file, an unknown or missing key, or a value of the wrong kind; it is named.
    """
    path = Path(name)
    if path.suffix == ".toml":
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise ValueError(f"airframe {str(name)!r} cannot be read: {error.strerror}") from None
    else:
        folder = resources.files("sitl") / "airframes"
        files = (entry.name for entry in folder.iterdir())
        known = sorted(file.removesuffix(".toml") for file in files if file.endswith(".toml"))
        if str(name) not in known:
            raise ValueError(f"no airframe {str(name)!r}; bundled: {', '.join(known)}; or give a .toml file")
        text = (folder / f"{name}.toml").read_text(encoding="utf-8")
    return _airframe(tomllib.loads(text))


_SECTIONS = {"body": Body, "ground": Ground, "battery": Battery, "senses": Senses}
_SPINS = {"ccw": 1.0, "cw": -1.0}


def _airframe(table: dict[str, Any]) -> Airframe:
    known = {"schema", "name", "rotors", "params", *_SECTIONS}
    if table.get("schema") != 1:
        raise ValueError(f"airframe: schema must be 1, got {table.get('schema')!r}")
    _demand_keys("airframe", table, known)
    for section in ("rotors", "params"):
        if not isinstance(table[section], dict):
            raise ValueError(f"[{section}]: wanted a table, got {table[section]!r}")
    rotors = dict(table["rotors"])
    turning = rotors.pop("turning", None)
    if not isinstance(turning, list) or len(turning) != 4 or not set(turning) <= set(_SPINS):
        raise ValueError(f"[rotors] turning: wanted four of {', '.join(_SPINS)}, got {turning!r}")
    rotors["spin"] = [_SPINS[way] for way in turning]
    return Airframe(
        name=str(table["name"]),
        rotors=_section("rotors", Rotors, rotors),
        params=dict(table["params"]),
        **{name: _section(name, kind, table[name]) for name, kind in _SECTIONS.items()},
    )


_SHAPES = {
    "inertia_kgm2": (3,),
    "drag_area_m2": (3,),
    "position_frd_m": (4, 3),
    "spin": (4,),
    "feet_frd_m": (4, 2),
}


def _section(name: str, kind: type, table: dict[str, Any]) -> Any:
    if not isinstance(table, dict):
        raise ValueError(f"[{name}]: wanted a table, got {table!r}")
    _demand_keys(f"[{name}]", table, set(kind.__dataclass_fields__))  # type: ignore[attr-defined]  # one of `_SECTIONS`
    values: dict[str, object] = {}
    for key, value in table.items():
        shape = _SHAPES.get(key, ())
        try:
            array = np.array(value, dtype=np.float64)
            fits = array.shape == shape and bool(np.isfinite(array).all())
        except ValueError:
            fits = False
        if not fits:
            raise ValueError(f"[{name}] {key}: wanted finite numbers of shape {shape}, got {value!r}")
        array.setflags(write=False)
        values[key] = array if shape else float(array)
    return kind(**values)


def _demand_keys(where: str, table: dict[str, Any], known: set[str]) -> None:
    for word, keys in (("unknown", set(table) - known), ("missing", known - set(table))):
        if keys:
            names, all_names = ", ".join(sorted(keys)), ", ".join(sorted(known))
            raise ValueError(f"{where}: {word} key {names}; known: {all_names}")

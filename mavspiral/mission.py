"""The mission file: TOML in, one frozen value out. All user input is judged here.

Units are in the keys. Everything inside mavspiral is SI; `brief` converts.
Heights are metres above `ground_amsl_m`, places are [latitude, longitude] in degrees.
"""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from mavspiral.errors import InputError
from mavspiral.mission_errors import describe

__all__ = [
    "Accept",
    "Building",
    "Camera",
    "Inspection",
    "Keepout",
    "Limits",
    "Mission",
    "Quality",
    "Vehicle",
    "load_mission",
]

Lat = Annotated[float, Field(ge=-90, le=90)]
Lon = Annotated[float, Field(ge=-180, le=180)]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Building(_Table):
    """What stands there: the map, and which building of it."""

    map: Annotated[str, Field(min_length=1)]
    at: tuple[Lat, Lon] | None = None
    id: str | None = None
    cell_m: Annotated[float, Field(ge=0.02, le=10)] = 0.25
    ground_amsl_m: Annotated[float, Field(ge=-500, le=6000)] = 0.0
    map_error_m: Annotated[float, Field(ge=0, le=20)] = 0.5
    dtm: Annotated[str, Field(min_length=1)] | None = None
    units: Literal["m", "mm", "ft"] | None = None
    up: Literal["z", "y"] | None = None
    heading_deg: Annotated[float, Field(ge=-360, le=360)] | None = None
    crs: Annotated[str, Field(pattern=r"^[A-Za-z]{2,10}:[0-9]{1,9}$")] | None = None


class Camera(_Table):
    """The camera and how its shots are commanded."""

    focal_length_mm: Annotated[float, Field(gt=0, le=1000)]
    sensor_mm: tuple[Annotated[float, Field(gt=0, le=200)], Annotated[float, Field(gt=0, le=200)]]
    image_px: tuple[Annotated[int, Field(gt=0, le=100_000)], Annotated[int, Field(gt=0, le=100_000)]] = (
        5472,
        3648,
    )
    exposure_s: Annotated[float, Field(gt=0, le=1)] = 0.001
    min_interval_s: Annotated[float, Field(gt=0, le=60)] = 1.0
    gimbal: bool = False
    trigger: Literal["camera", "digicam", "distance", "none"] = "camera"
    first_photo: str = "DSC00001.JPG"

    @field_validator("first_photo")
    @classmethod
    def _counts(cls, name: str) -> str:
        if not re.fullmatch(r"[A-Za-z0-9_-]{0,50}[0-9][A-Za-z_-]{0,9}\.[A-Za-z0-9]{1,8}", name):
            raise ValueError(
                f'"{name}" is no picture\'s name that can be counted on: letters, digits, _ and - with a number at the '
                'end, and an extension, at most 64 characters. Fix: the first one on the card, e.g. "DSC00001.JPG" or "DJI_0001.JPG"'
            )
        return name


class Inspection(_Table):
    """What the flight shall see, and from how far."""

    standoff_m: Annotated[float, Field(gt=0, le=200)]
    overlap: Annotated[float, Field(ge=0, lt=0.95)] = 0.25
    side_overlap: Annotated[float, Field(ge=0, lt=0.95)] = 0.6
    roof: bool = False
    courtyards: bool = False
    mode: Literal["spiral", "paper"] = "spiral"
    terms: Annotated[int, Field(ge=1, le=49)] | None = None
    bottom_m: NotNegative | None = None
    top_m: Positive | None = None


class Quality(_Table):
    """When a wall cell counts as seen."""

    gsd_max_mm: Positive = 5.0
    incidence_max_deg: Annotated[float, Field(gt=0, lt=90)] = 60.0
    views_min: Annotated[int, Field(ge=1, le=100)] = 1
    blur_max_px: Positive = 1.0


class Limits(_Table):
    """What the vehicle must never exceed: norms, but for climb and descent."""

    speed_mps: Annotated[float, Field(ge=0.1, le=30)] = 5.0
    climb_mps: Annotated[float, Field(ge=0.1, le=15)] = 2.0
    descent_mps: Annotated[float, Field(ge=0.1, le=10)] = 1.5
    acceleration_mps2: Annotated[float, Field(ge=0.1, le=15)] = 2.0
    jerk_mps3: Annotated[float, Field(ge=0.1, le=100)] = 4.0
    yaw_rate_dps: Annotated[float, Field(ge=1, le=360)] = 45.0
    clearance_m: Annotated[float, Field(gt=0, le=200)] = 4.0
    ceiling_m: Annotated[float, Field(gt=0, le=2000)] = 120.0


class Keepout(_Table):
    """A volume that the flight keeps its clearance from: a circle or a polygon, solid from the ground to height_m[1]."""

    circle: tuple[Lat, Lon, Positive] | None = None
    polygon: Annotated[tuple[tuple[Lat, Lon], ...], Field(min_length=3)] | None = None
    height_m: tuple[NotNegative, Positive]
    name: Annotated[str, Field(pattern=r"^[^\x00-\x1f\x7f\"]{1,64}$")] | None = None

    @model_validator(mode="after")
    def _one_shape(self) -> Keepout:
        if (self.circle is None) == (self.polygon is None):
            raise ValueError("give either circle = [lat, lon, radius_m] or polygon = [[lat, lon], …]")
        if self.height_m[0] >= self.height_m[1]:
            raise ValueError(f"height_m = {list(self.height_m)} must rise: [from, to]")
        return self


class Vehicle(_Table):
    """Who flies it, and from where."""

    autopilot: Literal["px4", "ardupilot"] = "px4"
    airframe: Literal["7inch", "camera", "x500"] = "x500"
    home: tuple[Lat, Lon] | None = None
    home_height_m: Annotated[float, Field(ge=-100, le=1000)] = 0.0
    gps: Literal["rtk", "standard"] = "rtk"
    radius_m: Annotated[float, Field(gt=0, le=5)] = 0.4
    endurance_s: Positive = 1500.0
    max_items: Annotated[int, Field(ge=20, le=10_000)] = 500


class Accept(_Table):
    """What `simulate` must show to exit 0; what is absent is not asked."""

    tracking_p95_m: Positive | None = None
    tracking_max_m: Positive | None = None
    clearance_min_m: Positive | None = None
    coverage: Annotated[float, Field(gt=0, le=1)] | None = None
    duration_max_s: Positive | None = None


class Mission(_Table):
    """One inspection of one building."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    building: Building
    camera: Camera
    inspection: Inspection
    quality: Quality = Quality()
    limits: Limits = Limits()
    keepout: tuple[Keepout, ...] = ()
    vehicle: Vehicle = Vehicle()
    accept: Accept = Accept()
    path: Annotated[Path, Field(exclude=True)] = Path()

    @model_validator(mode="after")
    def _consistent(self) -> Mission:
        standoff_m, clearance_m = self.inspection.standoff_m, self.limits.clearance_m
        if standoff_m < clearance_m:
            raise ValueError(
                f"[inspection] standoff_m = {standoff_m:g} is smaller than [limits] clearance_m = {clearance_m:g}. "
                f"Fix: standoff_m ≥ {clearance_m:g}, or a smaller clearance"
            )
        if self.inspection.terms is not None and self.inspection.mode != "paper":
            raise ValueError(
                f'[inspection] terms = {self.inspection.terms} is for mode = "paper" alone; the spiral takes as many '
                "as its corners need. Fix: leave it out"
            )
        bottom_m, top_m = self.inspection.bottom_m, self.inspection.top_m
        if bottom_m is not None and top_m is not None and bottom_m > top_m:
            raise ValueError(
                f"[inspection] bottom_m = {bottom_m:g} is above top_m = {top_m:g}. Fix: swap them"
            )
        return self

    @property
    def map_path(self) -> Path:
        """The map, relative to the mission file."""
        return self._beside(self.building.map)

    @property
    def dtm_path(self) -> Path | None:
        """The terrain model, relative to the mission file."""
        return None if self.building.dtm is None else self._beside(self.building.dtm)

    def _beside(self, name: str) -> Path:
        """A file relative to the mission file; where that is a link and nothing is beside it, to what it points to."""
        near = self.path.parent / name
        if near.exists():
            return near
        real = self.path.resolve().parent / name
        return real if real.exists() else near

    @property
    def notices(self) -> tuple[str, ...]:
        """What the mission asks for that this version does not do, in words."""
        asked = []
        if "cell_m" in self.building.model_fields_set and self.building.map.lower().endswith(".npz"):
            asked.append(
                f"[building] cell_m = {self.building.cell_m:g} means nothing to a .npz map, which has cells of its own"
            )
        if self.inspection.roof and not self.camera.gimbal:
            asked.append(
                "[inspection] roof = true: a camera that cannot look down shows no roof, only the walls are flown. "
                "Fix: [camera] gimbal = true, if it hangs on one"
            )
        return tuple(asked)


def load_mission(path: str | Path) -> Mission:
    """The mission in a TOML file.

    Raises:
        InputError: it cannot be read, or a key is unknown, missing or impossible; one line that names the key,
            the value, the limit and a fix.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(
            f"{path}: no such mission file. Fix: give the path of a mission, e.g. missions/torre.toml"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}). Fix: a mission is a UTF-8 TOML file") from None
    try:
        document = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(
            f'{path}: not TOML: {error}. Fix: text stands in "quotes", tables in [brackets]'
        ) from None
    try:
        # Strict JSON mode: lists may fill tuples, but text never passes for a number.
        mission = Mission.model_validate_json(json.dumps(document, default=str))
    except ValidationError as error:
        raise InputError(f"{path}: {describe(error, Mission)}") from None
    return mission.model_copy(update={"path": path})

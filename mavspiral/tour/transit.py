"""The ways from home, from pass to pass and back: straight lines that keep the clearance in space, as low as that allows."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.curve.line import LinePath
from mavspiral.errors import InputError
from mavspiral.frames import LocalFrame
from mavspiral.motion.limits import Limits
from mavspiral.motion.timing import fastest_law
from mavspiral.motion.trajectory import Leg
from mavspiral.motion.turn import TurnGaze
from mavspiral.shape.heightmap import HeightMap
from mavspiral.survey.solids import Solids
from mavspiral.tour.no_way import NoWay

__all__ = [
    "JOINABLE_M",
    "MARGIN_M",
    "ON_A_ROOF_M",
    "REACTION_S",
    "STOPPING_MARGIN_M",
    "Look",
    "Ways",
    "judge_home",
    "safe_way",
    "stopping_pace",
    "transit_legs",
]

STEP_M = 2.0
MARGIN_M = 0.5
"""Ways are this much farther from everything than must be, for what flying leaves of a plan."""
JOINABLE_M = 0.1
"""What a way is to join keeps so much more than the way does."""

GROUND_M = 0.5
"""Nobody goes across lower than this above the map's ground. From a home that nobody named, 3 m below it, a way begins at 1 m."""

SHORTEST_M = 0.05
NOTHING_M = 1e-7
TURNING_M = 1.0
REACTION_S = 1.0
"""PX4 notices after COM_OF_LOSS_T = 1 s that setpoints have ceased, and flies on until then."""
STOPPING_MARGIN_M = 0.3
"""What a vehicle that goes straight on and brakes leaves between its hull and a wall."""
BEYOND_SAMPLES = 32
SLOWEST_MPS = 0.5
SEARCHED_M = 100.0
ON_A_ROOF_M = 0.5
"""What is lower is ground that a home stands on; and a roof's height is known no better."""
LOW_HOME_M = 3.0
"""A home that is higher is meant to be on something."""
HOME_SPARE_M = 0.1
"""So far around a home that is too near to something another is looked for, with so much more than its ways keep."""


class Look(NamedTuple):
    """Where nose and camera point."""

    yaw_enu_rad: float
    gimbal_pitch_rad: float = 0.0

    @classmethod
    def at(cls, leg: Leg, u_rad: float) -> Look:
        """Where they point on a leg."""
        return cls(float(leg.gaze(u_rad)), float(leg.gimbal_pitch(u_rad)))


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """What every way through a site keeps: `clearance_m` from all that stands there, and below the ceiling.

    A vehicle of `radius_m` whose setpoints cease comes to rest before it touches anything. `named` says what is
    nearest to a place and the straight way from it over a sweep, `smaller` what to set for so small a required clearance.
    """

    solids: Solids
    frame: LocalFrame
    top_m: float
    limits: Limits
    clearance_m: float
    ceiling_m: float
    radius_m: float
    named: Callable[[FloatArray, FloatArray], str]
    smaller: Callable[[float], str]

    def legs(
        self,
        start_enu_m: FloatArray,
        end_enu_m: FloatArray,
        name: str,
        looks: tuple[Look, Look],
        between: tuple[str, str] = ("home", "the spiral"),
    ) -> tuple[Leg, ...]:
        """The legs of the shortest safe way, and nose and camera turned from the first look to the second.

        Raises:
            LimitError: there is no such way; `between` says what its two ends are.
        """
        way = safe_way(
            self.solids,
            self.frame,
            start_enu_m,
            end_enu_m,
            clearance_m=self.clearance_m,
            ceiling_m=self.ceiling_m,
            top_m=self.top_m,
            between=between,
            named=self.named,
            smaller=self.smaller,
        )
        return transit_legs(way, name, *looks, self.limits, solids=self.solids, radius_m=self.radius_m)


def safe_way(
    solids: Solids,
    frame: LocalFrame,
    start_enu_m: FloatArray,
    end_enu_m: FloatArray,
    *,
    clearance_m: float,
    ceiling_m: float,
    top_m: float,
    between: tuple[str, str],
    named: Callable[[FloatArray, FloatArray], str],
    smaller: Callable[[float], str],
) -> FloatArray:
    """The corners `(k, 3)` of the lowest way that keeps the clearance everywhere.

    First the straight line, unless an end of it lies below the map's ground: nothing tells where the slope rises between
    them. Then up, across and down again, higher and higher until nothing stands higher.
    `named` tells in words what is nearest to a straight way, from its beginning over its sweep, `smaller` what to set for a
    smaller clearance.

    Raises:
        LimitError: no such way below the ceiling; the best one's nearest approach is named, and what would do.
    """
    lowest_m = float(max(start_enu_m[2], end_enu_m[2]))
    highest_m = min(ceiling_m, max(lowest_m, top_m + clearance_m + MARGIN_M))
    heights_m = np.append(np.arange(lowest_m, highest_m, STEP_M), highest_m)
    straight = np.array([start_enu_m, end_enu_m])
    beside_a_slope = min(start_enu_m[2], end_enu_m[2]) < GROUND_M
    over = (
        np.array([start_enu_m, [*start_enu_m[:2], height_m], [*end_enu_m[:2], height_m], end_enu_m])
        for height_m in heights_m
    )
    best_m, best_at, best_sweep = -1.0, start_enu_m, end_enu_m - start_enu_m
    for way in itertools.chain([] if beside_a_slope else [straight], over):
        sweeps = np.diff(way, axis=0)
        distance_m = solids.distance_m(way[:-1], sweeps)
        nearest = int(np.argmin(distance_m))
        if distance_m[nearest] >= clearance_m + MARGIN_M - 1e-9:  # the highest way keeps exactly that
            return way
        if distance_m[nearest] > best_m:
            best_m, best_at, best_sweep = float(distance_m[nearest]), way[nearest], sweeps[nearest]
    none = NoWay(solids, frame, straight, between, clearance_m + MARGIN_M, ceiling_m, top_m, named, smaller)
    raise none.refusal(best_m, best_at, best_sweep, margin_m=MARGIN_M, joinable_m=JOINABLE_M)


def transit_legs(
    way_enu_m: FloatArray,
    name: str,
    before: Look,
    after: Look,
    limits: Limits,
    *,
    solids: Solids,
    radius_m: float,
) -> tuple[Leg, ...]:
    """One leg from rest to rest for each side of the way, numbered from 1; nose and camera turn on the longest.

    A way of no length that has to turn goes up and down again by `TURNING_M`. A leg that ends before a wall is
    flown so slowly that a vehicle of `radius_m` whose setpoints cease comes to rest before it.
    """
    if before != after and not _sides(way_enu_m):
        above_m = way_enu_m[0] + np.array([0.0, 0.0, TURNING_M])
        way_enu_m = np.array([way_enu_m[0], above_m, way_enu_m[-1]])
    sides = _sides(way_enu_m)
    longest = int(np.argmax([np.linalg.norm(b - a) for a, b in sides])) if sides else 0
    legs = []
    for number, (start, end) in enumerate(sides):
        here, there = (before if number <= longest else after), (before if number < longest else after)
        path = LinePath(start, end)
        gaze = TurnGaze(here.yaw_enu_rad, there.yaw_enu_rad)
        pitch = TurnGaze(here.gimbal_pitch_rad, there.gimbal_pitch_rad)
        pace = stopping_pace(solids, start, end, limits, radius_m)
        legs.append(
            Leg(f"{name}-{number + 1}", path, gaze, fastest_law(path, gaze, pace, pitch=pitch), pitch)
        )
    return tuple(legs)


def stopping_pace(
    solids: Solids, start_m: FloatArray, end_m: FloatArray, limits: Limits, radius_m: float
) -> Limits:
    """The limits with a speed, `SLOWEST_MPS` at the least, at which flying on for `REACTION_S` beyond the end touches nothing."""
    ahead = (end_m - start_m) / np.linalg.norm(end_m - start_m)
    beyond_m = np.linspace(0.0, limits.speed_mps * REACTION_S, BEYOND_SAMPLES)
    near_m = solids.distance_m(end_m + beyond_m[:, None] * ahead) < radius_m + STOPPING_MARGIN_M
    if not near_m.any():
        return limits
    slow_mps = max(SLOWEST_MPS, float(beyond_m[max(0, int(np.argmax(near_m)) - 1)]) / REACTION_S)
    return replace(limits, speed_mps=min(slow_mps, limits.speed_mps))


def _sides(way_enu_m: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """The sides of a way, without the corners that are hardly any way from the one before or from the end."""
    corners = [way_enu_m[0]]
    for corner in way_enu_m[1:-1]:
        if min(np.linalg.norm(corner - corners[-1]), np.linalg.norm(corner - way_enu_m[-1])) > SHORTEST_M:
            corners.append(corner)
    return [
        (a, b) for a, b in itertools.pairwise([*corners, way_enu_m[-1]]) if np.linalg.norm(b - a) > NOTHING_M
    ]


def judge_home(heights: HeightMap, ways: Ways, home_enu_m: FloatArray, above_home_m: FloatArray) -> None:
    """Refuses a home in a wall, or so near to one that the take-off, or the way on from above home, has no clearance.

    Raises:
        InputError: with the place and what would do.
    """
    place, nowhere = heights.frame.geo_point(home_enu_m), np.zeros(3)
    where = f"[vehicle] home = [{place.lat_deg:.6f}, {place.lon_deg:.6f}]"
    standing_m = float(heights.sample(home_enu_m))
    if standing_m > max(ON_A_ROOF_M, home_enu_m[2] + ON_A_ROOF_M):
        named = ways.named(home_enu_m, nowhere)
        is_kept_out = "keepout" in named
        fixes = [] if is_kept_out else [f"home_height_m = {standing_m:.1f} to start from on top of it"]
        if is_kept_out or home_enu_m[2] < LOW_HOME_M:
            fixes.insert(0, _free_place(heights.frame, ways, home_enu_m))
        raise InputError(
            f"{where}, {_height_words(home_enu_m[2])}, is inside "
            f"{named if is_kept_out else f'something {standing_m:.1f} m high'}. Fix: {', or '.join(fixes)}"
        )
    if standing_m > ON_A_ROOF_M:
        return
    for up, at_m, keeps_m in (
        ("", home_enu_m, ways.clearance_m),
        (" above it", above_home_m, ways.clearance_m + MARGIN_M),
    ):
        if (distance_m := float(ways.solids.distance_m(at_m[None, :])[0])) < keeps_m - 1e-9:
            raise InputError(
                f"{where} is {distance_m:.2f} m from {ways.named(at_m, nowhere)}, {keeps_m:.2f} m of clearance are required{up}. "
                f"Fix: {_free_place(heights.frame, ways, home_enu_m)}"
            )


def _height_words(up_m: float) -> str:
    side = "below the building's" if up_m < -0.05 else "above"
    return f"{abs(up_m):.1f} m {side} ground"


def _free_place(frame: LocalFrame, ways: Ways, home_enu_m: FloatArray) -> str:
    """In words: the nearest place at that height that keeps the clearance; where there is none, what there is."""
    away_m, azimuth = np.meshgrid(np.arange(0.5, SEARCHED_M, 0.5), np.radians(np.arange(0.0, 360.0, 5.0)))
    around_m = np.stack([away_m * np.sin(azimuth), away_m * np.cos(azimuth), 0.0 * away_m], axis=-1)
    places = home_enu_m + around_m.reshape(-1, 3)
    free_m = ways.solids.distance_m(places)
    fits = np.flatnonzero(free_m >= ways.clearance_m + MARGIN_M + HOME_SPARE_M)
    if not fits.size:
        best = int(np.argmax(free_m))
        place, would_do = frame.geo_point(places[best]), ways.smaller(free_m[best] - MARGIN_M - HOME_SPARE_M)
        return f"another map or home: no place within {SEARCHED_M:g} m has more than {free_m[best]:.1f} m" + (
            f", as [{place.lat_deg:.6f}, {place.lon_deg:.6f}]; or go there with {would_do}"
            if would_do
            else ""
        )
    nearest = places[fits[np.argmin(away_m.ravel()[fits])]]
    place, moved_m = frame.geo_point(nearest), float(np.hypot(*(nearest - home_enu_m)[:2]))
    return f"home = [{place.lat_deg:.6f}, {place.lon_deg:.6f}], {moved_m:.1f} m away, is the nearest place that has it"

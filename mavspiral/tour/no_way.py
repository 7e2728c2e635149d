"""Why there is no way between two places, in words, and what would do: one of them is too near to something, or the ceiling too low."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.errors import LimitError
from mavspiral.frames import LocalFrame
from mavspiral.survey.solids import Solids

__all__ = ["NoWay"]

STEP_M = 0.5
"""Of the ceiling that would do."""


@dataclass(frozen=True, slots=True, eq=False)
class NoWay:
    """That none of the ways from one of `ends_enu_m` `(2, 3)`, which are called `between`, to the other keeps `keeps_m` below the ceiling.

    What is 2.5D is no nearer from higher up: where both ends keep it, there is a way as soon as the ceiling is high enough.
    """

    solids: Solids
    frame: LocalFrame
    ends_enu_m: FloatArray
    between: tuple[str, str]
    keeps_m: float
    ceiling_m: float
    top_m: float
    named: Callable[[FloatArray, FloatArray], str]
    smaller: Callable[[float], str]

    def refusal(
        self,
        best_m: float,
        best_at_enu_m: FloatArray,
        best_sweep_m: FloatArray,
        *,
        margin_m: float,
        joinable_m: float,
    ) -> LimitError:
        """What is told: `best_m` is what the best of them keeps, on the straight way from `best_at_enu_m`.

        `margin_m` is how much of `keeps_m` is for flying; a curve whose end a way is to join keeps `joinable_m` more than the way.
        """
        words = (
            f"no way between {' and '.join(self.between)} keeps {self.keeps_m:.1f} m of clearance ({margin_m:g} m of it for "
            "what flying leaves of a plan)"
        )
        ends_m = self.solids.distance_m(self.ends_enu_m)
        near = int(np.argmin(ends_m))
        if ends_m[near] < self.keeps_m - 1e-9:
            return LimitError(
                f"{words}: {self._end_too_near(near, float(ends_m[near]), margin_m=margin_m, joinable_m=joinable_m)}"
            )
        words += f" below the ceiling of {self.ceiling_m:.0f} m"
        higher = int(np.argmax(self.ends_enu_m[:, 2]))
        would_do = f"[limits] ceiling_m ≥ {math.ceil(self._crossing_m())}"
        if (up_m := self.ends_enu_m[higher, 2]) > self.ceiling_m:
            return LimitError(
                f"{words}: {self._called(higher)} is {up_m:.1f} m above ground there. "
                f"Fix: {would_do}, or a lower top_m, and above a roof [inspection] roof = false"
            )
        aside = ", or another [vehicle] home" if "home" in self.between else ""
        return LimitError(
            f"{words}: the best comes within {best_m:.1f} m of {self.named(best_at_enu_m, best_sweep_m)}, after "
            f"{self._where(best_at_enu_m, '.0f')}. Fix: {would_do}{aside}"
        )

    def _crossing_m(self) -> float:
        """About the lowest height above the ceiling at which one crosses from above one end to above the other."""
        lowest_m = max(self.ceiling_m, float(self.ends_enu_m[:, 2].max()))
        heights_m = np.arange(lowest_m, max(lowest_m, self.top_m + self.keeps_m) + STEP_M, STEP_M)
        above = np.column_stack([np.tile(self.ends_enu_m[0, :2], (len(heights_m), 1)), heights_m])
        across = np.array([*(self.ends_enu_m[1] - self.ends_enu_m[0])[:2], 0.0])
        free = self.solids.distance_m(above, np.tile(across, (len(heights_m), 1))) >= self.keeps_m
        return float(heights_m[int(np.argmax(free))])

    def _end_too_near(self, which: int, nearest_m: float, *, margin_m: float, joinable_m: float) -> str:
        thing = self.named(self.ends_enu_m[which], np.zeros(3))
        short_m = math.ceil(10.0 * (self.keeps_m + joinable_m - nearest_m) - 1e-6) / 10.0
        if self.between[which] == "home":
            end, fix = "the climb above home ends", "another [vehicle] home"
        else:
            end = f"{self._called(which)} {'begins' if which else 'ends'}"
            fix = "another standoff_m"
            if thing.startswith("the building"):
                fix = f"a standoff_m larger by {short_m:.1f} m"
        would_do = self.smaller(nearest_m - margin_m - joinable_m)
        return (
            f"{end} {nearest_m:.2f} m from {thing}, at {self._where(self.ends_enu_m[which], '.1f')}. "
            f"Fix: {fix}{f', or {would_do}' if would_do else ''}"
        )

    def _called(self, which: int) -> str:
        name = self.between[which]
        return name if name in ("home", "the spiral") else f"the pass of {name}"

    def _where(self, place_enu_m: FloatArray, up: str) -> str:
        place = self.frame.geo_point(place_enu_m)
        return f"lat {place.lat_deg:.6f}, lon {place.lon_deg:.6f}, {place_enu_m[2]:{up}} m above ground"

"""What the camera sees of a wall, and how fast it may pass."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Camera"]


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera. Pairs are across and up the image.

    Raises:
        ValueError: a length, a pixel count or a time is not positive.
    """

    focal_length_m: float
    sensor_m: tuple[float, float]
    image_px: tuple[int, int]
    exposure_s: float
    min_interval_s: float
    gimbal: bool

    def __post_init__(self) -> None:
        """Checks the fields."""
        sizes = (self.focal_length_m, *self.sensor_m, *self.image_px, self.exposure_s, self.min_interval_s)
        if not all(size > 0 for size in sizes):
            raise ValueError(f"{self}: wanted positive lengths, pixels and times")

    def footprint_m(self, distance_m: float) -> tuple[float, float]:
        """Width and height of the piece of a wall, `distance_m` straight ahead, that one shot shows."""
        width_m, height_m = self.sensor_m
        return distance_m / self.focal_length_m * width_m, distance_m / self.focal_length_m * height_m

    def gsd_m(self, distance_m: float) -> float:
        """The side of a pixel on a wall `distance_m` straight ahead, of the coarser of the two axes."""
        return max(m / px for m, px in zip(self.footprint_m(distance_m), self.image_px, strict=True))

    def rise_m(self, standoff_m: float, overlap: float) -> float:
        """The climb from turn to turn at which shots overlap by `overlap`: Δh of the paper's eq. 2."""
        return self.footprint_m(standoff_m)[1] * (1 - overlap)

    def shot_spacing_m(self, standoff_m: float, side_overlap: float) -> float:
        """The way along a turn at which shots overlap by `side_overlap`."""
        return self.footprint_m(standoff_m)[0] * (1 - side_overlap)

    def speed_limit_mps(self, standoff_m: float, side_overlap: float, blur_max_px: float) -> float:
        """The fastest pass at which no shot smears by more than `blur_max_px` and the shutter keeps up."""
        sharp_mps = blur_max_px / self.blur_px(standoff_m, 1.0)
        return min(sharp_mps, self.shot_spacing_m(standoff_m, side_overlap) / self.min_interval_s)

    def blur_px(self, distance_m: float, speed_mps: float) -> float:
        """By how many pixels, of the finer axis, a wall so far away smears that passes at that speed."""
        pixel_m = min(m / px for m, px in zip(self.footprint_m(distance_m), self.image_px, strict=True))
        return speed_mps * self.exposure_s / pixel_m

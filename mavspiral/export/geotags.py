"""Where each picture was taken, by its name on the card, as programs of photogrammetry read it.

Heading and pitch are those of Pix4D and Metashape alike: yaw clockwise from north, of the top of the image when it
looks down; pitch 0 straight down, 90 level.
"""

from __future__ import annotations

import re

import numpy as np

from mavspiral.arrays import FloatArray
from mavspiral.frames import LocalFrame, yaw_enu_to_ned
from mavspiral.survey.shots import Shots

__all__ = ["geo_txt", "geotags_csv", "photo_name", "pitch_nadir_deg"]

_COLUMNS = "#Label,Latitude,Longitude,Altitude,Yaw,Pitch,Roll"
_COUNTER = re.compile(r"[0-9]+(?=[^0-9]*\.[^.]*$)")


def photo_name(first_photo: str, number: int) -> str:
    """The name of the picture that comes `number` after `first_photo`: its last digits before the extension count on."""
    return _COUNTER.sub(lambda digits: str(int(digits[0]) + number).zfill(len(digits[0])), first_photo)


def pitch_nadir_deg(pitch_rad: FloatArray) -> FloatArray:
    """Pitch from straight down, 90 is level, of one from level, up is positive."""
    from_down_deg: FloatArray = 90.0 + np.degrees(pitch_rad)
    return from_down_deg


def geotags_csv(shots: Shots, names: tuple[str | None, ...], frame: LocalFrame) -> str:
    """One row for each shot that has a name: WGS-84, metres above mean sea level, degrees.

    Pix4D takes such rows as they stand, in this order, and a first line with a # as a comment (support.pix4d.com
    360056389172). To Metashape's import they are columns 1 to 7, `nyxzabc`.
    """
    lat, lon, alt = frame.to_geodetic(shots.position_enu_m)
    yaw_ned_deg = np.round(np.degrees(yaw_enu_to_ned(shots.yaw_enu_rad)), 2) % 360.0
    pitch_deg = pitch_nadir_deg(shots.pitch_rad)
    rows = [_COLUMNS]
    rows += [
        f"{name},{lat[i]:.8f},{lon[i]:.8f},{alt[i]:.3f},{yaw_ned_deg[i]:.2f},{pitch_deg[i] + 0.0:.2f},0.00"
        for i, name in enumerate(names)
        if name is not None
    ]
    return "\n".join(rows) + "\n"


def geo_txt(shots: Shots, names: tuple[str | None, ...], frame: LocalFrame) -> str:
    """OpenDroneMap's geo.txt: the reference system, then name, longitude, latitude, height of each that has a name.

    Without angles: ODM uses them for radiometric calibration alone (docs, geo.rst), and its versions have read
    those columns as yaw, pitch, roll and as omega, phi, kappa.
    """
    lat, lon, alt = frame.to_geodetic(shots.position_enu_m)
    rows = ["EPSG:4326"]
    rows += [
        f"{name} {lon[i]:.8f} {lat[i]:.8f} {alt[i]:.3f}" for i, name in enumerate(names) if name is not None
    ]
    return "\n".join(rows) + "\n"

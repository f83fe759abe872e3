"""What the robot sees and hears at one moment, and how REST and the live stream tell it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from app.messages import LoudNoise

Point = tuple[float, float, float]
Direction = tuple[float, float]


@dataclass(frozen=True, slots=True)
class SeenFace:
    """A face in one image of ``image`` px. ``direction`` is azimuth and elevation (rad) in the axes of B, seen from its
    camera as that was at ``stamp``; ``panorama`` the same, seen from the panorama's. ``p_OF`` is its place and
    ``towards_O`` the heading (rad in O) in which it has the robot; None before the pose at ``stamp`` is known.
    """

    track: int
    camera: str
    stamp: float
    direction: Direction
    panorama: Direction | None
    range_m: float
    range_sigma_m: float
    p_OF: Point | None
    towards_O: float | None
    score: float
    box: tuple[float, float, float, float]
    image: tuple[int, int]


@dataclass(frozen=True, slots=True)
class SeenCode:
    """A QR code read in one image of ``camera``: its four ``corners`` (px), ``image`` that picture's size (px)."""

    text: str
    camera: str
    stamp: float
    corners: tuple[tuple[float, float], ...]
    image: tuple[int, int]


@dataclass(frozen=True, slots=True)
class HeardSound:
    """A sound at ``stamp``. ``direction`` as of a face, seen from the microphones' middle, which is at ``p_OA``;
    ``v_O`` is that direction as a unit vector in the axes of O. ``p_OS`` is where it is, None without a distance.
    """

    track: int
    stamp: float
    direction: Direction
    panorama: Direction | None
    power: float
    level_db: float
    active: bool
    last_active: float
    speech: float
    range_m: float
    range_sigma_m: float
    p_OA: Point | None
    v_O: Point | None
    p_OS: Point | None


@dataclass(frozen=True, slots=True)
class Perceived:
    """All of it at ``stamp``: faces by track and camera, sounds by track, noises of the last 2 s, codes by text."""

    stamp: float
    faces: tuple[SeenFace, ...] = ()
    sounds: tuple[HeardSound, ...] = ()
    noises: tuple[LoudNoise, ...] = ()
    codes: tuple[SeenCode, ...] = ()


def perceived_json(perceived: Perceived) -> dict[str, Any]:
    """What is perceived, as it is told over REST and the live stream."""
    return {
        "stamp": perceived.stamp,
        "faces": [_face_json(face) for face in perceived.faces],
        "sounds": [_sound_json(sound) for sound in perceived.sounds],
        "noises": [
            {"stamp": noise.stamp, "ratio": round(noise.ratio, 2), "level_db": round(noise.level_db, 2)}
            for noise in perceived.noises
        ],
        "codes": [
            {
                "text": code.text,
                "camera": code.camera,
                "stamp": code.stamp,
                "corners": [[round(value, 1) for value in corner] for corner in code.corners],
                "image": list(code.image),
            }
            for code in perceived.codes
        ],
    }


def _face_json(face: SeenFace) -> dict[str, Any]:
    return {
        "track": face.track,
        "camera": face.camera,
        "stamp": face.stamp,
        **_seen_json(face.direction, face.panorama, face.range_m, face.range_sigma_m, face.p_OF),
        "score": round(face.score, 3),
        "box": [round(value, 1) for value in face.box],
        "image": list(face.image),
    }


def _sound_json(sound: HeardSound) -> dict[str, Any]:
    return {
        "track": sound.track,
        "stamp": sound.stamp,
        **_seen_json(sound.direction, sound.panorama, sound.range_m, sound.range_sigma_m, sound.p_OS),
        "power": round(sound.power, 3),
        "level_db": round(sound.level_db, 2),
        "active": sound.active,
        "last_active": sound.last_active,
        "speech": _rounded(sound.speech),
    }


def _seen_json(
    direction: Direction, panorama: Direction | None, range_m: float, sigma_m: float, p_O: Point | None
) -> dict[str, Any]:
    azimuth, elevation = direction
    x, y, z = p_O or (None, None, None)
    return {
        "azimuth": _rounded(azimuth),
        "elevation": _rounded(elevation),
        "panorama": None if panorama is None else [round(angle, 4) for angle in panorama],
        "range_m": _rounded(range_m),
        "range_sigma_m": _rounded(sigma_m),
        "x": _rounded(x),
        "y": _rounded(y),
        "z": _rounded(z),
    }


def _rounded(value: float | None) -> float | None:
    """To a tenth of a millimetre; null for what is not known."""
    return None if value is None or not math.isfinite(value) else round(value, 4)

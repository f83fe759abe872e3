"""What the mock robot sees and hears of people: two faces, a voice, a radio behind, a clap now and then, and a tone."""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

if TYPE_CHECKING:
    from mock_robot import Mock

RATE = 48_000
FRAME = 960


def perceived(mock: Mock) -> dict[str, Any]:
    """The live stream's message."""
    now = mock.now()
    message: dict[str, Any] = {"type": "perceived", "stamp": now, "faces": [], "sounds": [], "noises": [], "codes": []}
    if mock.mode.get("alone"):
        return message
    clap = now - now % 6
    if now - clap < 2:
        message["noises"] = [{"stamp": clap, "ratio": 34.0, "level_db": -21.0}]
    sway = 0.05 * math.sin(now)
    message["faces"] = [
        _face(now, 1, 0.24 + sway, 0.28, 1.83, [200 - 700 * sway, 120, 60, 74]),
        _face(now, 2, -0.31, 0.2, 3.4, [470, 190, 34, 42]),
    ]
    message["sounds"] = [
        _sound(now, 7, 0.25 + sway, 0.2, -30 + 8 * math.sin(3 * now), 0.97, now),
        _sound(now, 8, 2.96, -0.1, -48, 0.05, now),
        _sound(now, 9, -1.2, 0.0, -38, None, now - now % 4),
    ]
    return message


def _place(now: float, track: int, azimuth: float, elevation: float, range_m: float | None) -> dict[str, Any]:
    known = {"range_m": range_m, "range_sigma_m": None if range_m is None else 0.1 * range_m}
    angles = {"azimuth": azimuth, "elevation": elevation, "panorama": [azimuth, elevation]}
    return {"track": track, "stamp": now, **angles, **known, "x": None, "y": None, "z": None}


def _face(now: float, track: int, azimuth: float, elevation: float, range_m: float, box: list[float]) -> dict[str, Any]:
    seen = {"camera": "kinect_optical_frame", "towards_O": None, "score": 0.93, "box": box, "image": [640, 480]}
    return _place(now, track, azimuth, elevation, range_m) | seen


def _sound(
    now: float, track: int, azimuth: float, elevation: float, level_db: float, speech: float | None, last: float
) -> dict[str, Any]:
    heard = {"power": 0.6, "level_db": level_db, "active": last >= now - 0.3, "last_active": last, "speech": speech}
    place = _place(now, track, azimuth, elevation, 1.9 if speech and speech > 0.5 else None)
    return place | {"p_OA": None, "v_O": None} | heard


def panorama(mock: Mock, seq: int) -> bytes:
    """A frame of kind 2: a room of stripes, a mark every 30 degrees."""
    image = np.full((384, 640, 3), (70, 64, 54), np.uint8)
    image[:110] = (110, 104, 98)
    image[230:] = (60, 74, 84)
    for degrees in range(-90, 91, 30):
        x = round(640 * (0.5 - degrees / 180))
        cv2.rectangle(image, (x - 24, 120), (x + 24, 226), (96, 118, 132), -1)
    jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 70])[1].tobytes()
    return struct.pack("<B3xIdHH4x", 2, seq, mock.now(), 640, 384) + jpeg


def sound(stamp: float, seq: int) -> bytes:
    """A frame of kind 16: 20 ms of a tone that swells."""
    at = (np.arange(FRAME) + seq * FRAME) / RATE
    wave = np.sin(2 * np.pi * 330 * at) * (0.08 + 0.07 * np.sin(2 * np.pi * 0.7 * at))
    return struct.pack("<B3xIdHHI", 16, seq, stamp, FRAME, 1, RATE) + (32767 * wave).astype("<i2").tobytes()

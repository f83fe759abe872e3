"""Percepts of people, for tests of how the console reports them."""

from __future__ import annotations

import math

import numpy as np

from app.base.geometry import Pose3
from app.messages import EncodedImage, Face, Faces, QRCode, QRCodes, SoundSource, SoundSources

PANORAMA = "panorama_optical_frame"
#: The panoramic camera looks ahead from 1.2 m over the ground.
X_BC = Pose3(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.array([0.1, 0.0, 1.2]))
P_BA = (0.0, 0.0, 0.5)


def faces(
    stamp: float, *places: tuple[float, float, float], frame: str = PANORAMA, first: int = 1, X_BC: Pose3 = X_BC
) -> Faces:
    """Faces at ``places`` (m in B; one 2 m ahead unless said), with tracks from ``first`` on."""
    return Faces(
        stamp,
        frame,
        1024,
        768,
        X_BC,
        tuple(
            Face(track, 0.9, (400.0, 300.0, 40.0, 50.0), np.zeros((5, 2), np.float32), p, np.eye(3) * 0.01, 2.0, 0.1)
            for track, p in enumerate(places or ((2.0, 0.0, 1.2),), first)
        ),
    )


def sound_source(
    track: int = 1, azimuth: float = 0.0, *, active: bool = True, speech: float = 0.9, range_m: float = 2.0
) -> SoundSource:
    """A sound in the array's plane."""
    direction = (math.cos(azimuth), math.sin(azimuth), 0.0)
    return SoundSource(track, direction, 0.5, -30.0, active, speech, range_m, 0.2)


def sound_sources(stamp: float, *sources: SoundSource) -> SoundSources:
    """Sounds heard; one ahead unless said."""
    return SoundSources(stamp, P_BA, sources or (sound_source(),))


def codes(stamp: float, *texts: str, frame: str = PANORAMA) -> QRCodes:
    """Codes read in one image ("stop 1" unless said), all in the same place of it."""
    corners = np.array([[1, 2], [11, 2], [11, 12], [1, 12]], np.float32)
    return QRCodes(stamp, frame, 1024, 768, X_BC, tuple(QRCode(text, corners, None) for text in texts or ("stop 1",)))


def no_codes(stamp: float) -> QRCodes:
    """An image without any."""
    return QRCodes(stamp, PANORAMA, 1024, 768, X_BC, ())


def panorama(stamp: float, jpeg: bytes = b"\xff\xd8 a panorama", X_BC: Pose3 = X_BC) -> EncodedImage:
    """What people see of the panoramic camera."""
    return EncodedImage(stamp, PANORAMA, jpeg, 640, 320, X_BC)

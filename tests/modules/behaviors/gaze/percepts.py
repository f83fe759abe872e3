"""Faces, codes and sounds for the tests of behaviors that look at them."""

from __future__ import annotations

import math

import numpy as np

from app.base.geometry import Pose3
from app.messages import Face, Faces, QRCode, QRCodes, SoundSource, SoundSources, read_only

Point = tuple[float, float, float]


def faces(stamp: float, seen: dict[int, Point]) -> Faces:
    marks, spread = read_only(np.zeros((5, 2), np.float32)), read_only(np.eye(3))
    found = tuple(
        Face(track, 0.9, (0, 0, 9, 9), marks, p_BF=at, covariance=spread, range_m=2.0, range_sigma_m=0.1)
        for track, at in seen.items()
    )
    return Faces(stamp, "kinect", width=640, height=480, X_BC=Pose3.identity(), faces=found)


def codes(stamp: float, seen: dict[str, Point | None]) -> QRCodes:
    corners = read_only(np.zeros((4, 2), np.float32))
    found = tuple(QRCode(text, corners, at) for text, at in seen.items())
    return QRCodes(stamp, "kinect", width=640, height=480, X_BC=Pose3.identity(), codes=found)


def sounds(stamp: float, *heard: SoundSource) -> SoundSources:
    return SoundSources(stamp, (0.0, 0.0, 1.0), heard)


def source(track: int, bearing: float, level_db: float, speech: float = 0.9, active: bool = True) -> SoundSource:
    direction = (math.cos(bearing), math.sin(bearing), 0.0)
    return SoundSource(
        track, direction, 0.5, level_db, active=active, speech=speech, range_m=math.nan, range_sigma_m=math.nan
    )

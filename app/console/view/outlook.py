"""Where the body will be in the next two seconds at the present command, and whether it meets anything: pure."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.console.view.floor import ribbon
from app.messages import Twist

HORIZON_S = 2.0
#: Outlines are drawn at these times, contact is looked for at the finer steps.
_DRAWN_S = (0.5, 1.0, 1.5, 2.0)
_STEP_S = 0.1
#: What moves more slowly is at rest.
_STANDS_MPS, _STANDS_RADPS = 0.02, 0.03
#: Points inside of the body as it is now are the body's own, or noise.
CLEAR, MEETS, SOON = (80, 220, 140), (245, 185, 60), (240, 60, 50)
SOON_S = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Outlook:
    """``vertices`` (V, 3), m in ``base_link``, and ``faces`` (F, 3) of the outlines; ``contact_s`` until the body meets
    something, None if it does not."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    contact_s: float | None

    @property
    def color(self) -> tuple[int, int, int]:
        if self.contact_s is None:
            return CLEAR
        return SOON if self.contact_s <= SOON_S else MEETS


def ahead(twist: Twist, after_s: float) -> Pose2:
    """``X_BA``: where ``base_link`` is after ``after_s`` of ``twist``."""
    turn = twist.angular_radps * after_s
    way = complex(twist.linear_mps, twist.lateral_mps) * after_s
    # The chord of an arc of this length.
    chord = way if abs(turn) < 1e-9 else way * (cmath.exp(1j * turn) - 1) / (1j * turn)
    return Pose2(chord.real, chord.imag, turn)


def stands(twist: Twist) -> bool:
    """Whether ``twist`` is too slow for an outlook."""
    fast = abs(complex(twist.linear_mps, twist.lateral_mps)) > _STANDS_MPS or abs(twist.angular_radps) > _STANDS_RADPS
    return not fast


def outlook(footprint: NDArray[np.float64], twist: Twist, points: NDArray[np.float64]) -> Outlook | None:
    """The outlook of a body with a convex, counter-clockwise ``footprint`` (N, 2) among ``points`` (P, 2), all in m in
    ``base_link``; None for a body at rest, or one that has no footprint."""
    if len(footprint) < 3 or stands(twist):
        return None
    outside = points[~inside(footprint, points)]
    steps = np.arange(_STEP_S, HORIZON_S + _STEP_S / 2, _STEP_S)
    hits = (float(t) for t in steps if inside(footprint, ahead(twist, float(t)).inverse().transform(outside)).any())
    contact_s = next(hits, None)
    closed = np.concatenate([footprint, footprint[:1]])
    vertices, faces, count = [], [], 0
    for after_s in _DRAWN_S:
        band, around = ribbon(ahead(twist, after_s).transform(closed))
        vertices.append(band)
        faces.append(around + np.uint32(count))
        count += len(band)
    return Outlook(np.concatenate(vertices), np.concatenate(faces), contact_s)


def inside(polygon: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of ``points`` (P, 2) are inside of the convex, counter-clockwise ``polygon`` (N, 2)."""
    within = np.ones(len(points), np.bool_)
    for (ax, ay), (bx, by) in pairwise(np.concatenate([polygon, polygon[:1]]).tolist()):
        within &= (bx - ax) * (points[:, 1] - ay) - (by - ay) * (points[:, 0] - ax) >= 0
    return within

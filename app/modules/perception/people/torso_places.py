"""Where torsos are looked for without a face: above the legs that the laser sees, of those whom nobody hides."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.messages import Persons

Vector = NDArray[np.float64]

#: Farther persons (m) have too few pixels, and were placed too roughly.
_FURTHEST_M = 7.0
#: Depth is measured within this distance (m).
_MEASURED_M = 4.5
#: A person was seen within this time (s) of the image.
_SEEN_S = 0.35
#: Half the width (m) of the patch with that of a body before it, and how much nearer (m) who hides another is.
_BESIDE_M, _NEARER_M = 0.35, 0.2
#: Standard deviation (m) over ground of a place, above which the patch may be beside the person.
_SPREAD_M = 0.15


def torso_places(
    persons: Persons, stamp: float, faces: Collection[int], poses: tuple[Pose2, Pose3], measured: bool
) -> dict[int, tuple[float, float, float]]:
    """Places (m in ``base_link``) of the middle of the faces, where those would be, by the track of the person.

    ``poses``: X_OB, the robot's at ``stamp`` of the image, and X_BC, the camera's. Persons with one of ``faces``, those
    in the image, are left out, and legs not believed to be a person's unless depth is ``measured``: a wall above a
    chair is not worn.
    """
    X_OB, X_BC = poses
    X_BO = X_OB.to_pose3().inverse()
    here = X_BC.translation[:2]
    others: dict[int, Vector] = {}
    wanted: dict[int, Vector] = {}
    for person in persons.persons:
        dt = stamp - persons.stamp
        place = np.array(person.p_OP) + dt * np.array((*person.v_O, 0.0))
        p_B = np.asarray(X_BO.transform(place), np.float64)
        tentative = person.state == "tentative"
        if not tentative:
            others[person.track] = p_B[:2] - here
        spread = math.sqrt(max(0.0, float(np.linalg.eigvalsh(person.covariance)[-1])))
        within = (_MEASURED_M if measured else 0.0) if tentative else _FURTHEST_M
        seen = stamp - person.last_seen <= _SEEN_S and spread <= _SPREAD_M
        if seen and person.face not in faces and math.dist(p_B[:2], here) <= within:
            wanted[person.track] = p_B
    found = {}
    for track, p_B in wanted.items():
        if not any(_hides(at, p_B[:2] - here) for other, at in others.items() if other != track):
            x, y, z = p_B.tolist()
            found[track] = (x, y, z)
    return found


def _hides(other: Vector, person: Vector) -> bool:
    """Whether somebody at ``other`` (2,) m from the camera is before a ``person`` (2,) m, or just beside."""
    away = float(np.hypot(*person))
    along = float(other @ person) / max(away, 1e-6)
    aside = abs(float(person[0] * other[1] - person[1] * other[0])) / max(away, 1e-6)
    return 0.0 < along < away + _NEARER_M and aside < _BESIDE_M

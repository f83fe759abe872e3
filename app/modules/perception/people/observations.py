"""What messages say of persons, in ``odom`` at their stamps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import Faces, OccupancyGrid, SoundSources
from app.modules.perception.people.values import FaceSeen
from app.modules.perception.people.voices import VoiceHeard

Vector = NDArray[np.float64]

#: Probability of being speech from which a sound is a voice.
_SPEECH = 0.5
_OCCUPIED = 65
#: A range of less certainty (m) is a guess by heights, the same in all images of a face, and errs by such a share.
#: and at least a distance (m), for directions alone may bring a filter ever nearer.
_GUESSED_M, _GUESSED_SHARE, _GUESSED_LEAST_M = 0.1, 0.25, 1.0
#: Distance (m) from both ends of a way within which obstacles do not count: a person stands there.
_ENDS_M = 0.3


def faces_seen(faces: Faces, X_OB: Pose2) -> list[FaceSeen]:
    """The faces of one image, the robot at ``X_OB`` at its stamp."""
    X_OB3 = X_OB.to_pose3()
    R = X_OB3.rotation
    seen = []
    for face in faces.faces:
        p_BF = np.array(face.p_BF)
        covariance = face.covariance
        if face.range_sigma_m > _GUESSED_M:
            towards = p_BF - faces.X_BC.translation
            away = float(np.linalg.norm(towards))
            along = max(_GUESSED_SHARE, _GUESSED_LEAST_M / max(away, 0.1))
            covariance = covariance + along**2 * np.outer(towards, towards)
        p_OF = np.asarray(X_OB3.transform(p_BF), np.float64)
        seen.append(FaceSeen(face.track, p_OF, np.asarray(R @ covariance @ R.T)))
    return seen


def voices_heard(sources: SoundSources, X_OB: Pose2) -> tuple[Vector, list[VoiceHeard]]:
    """The place (2,) m of the microphones in ``odom``, and every voice that sounds."""
    p_OA = X_OB.transform(np.array(sources.p_BA[:2], np.float64))
    voices = [
        VoiceHeard(source.track, math.atan2(source.direction[1], source.direction[0]) + X_OB.theta)
        for source in sources.sources
        if source.active and source.speech >= _SPEECH
    ]
    return p_OA, voices


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """Obstacles of a map, seen from ``odom``."""

    grid: OccupancyGrid
    X_MO: Pose2

    def passable(self, a: Vector, b: Vector) -> bool:
        """Whether no obstacle is on the straight way between ``a`` and ``b`` (2,) m in ``odom``."""
        length = math.dist(a, b)
        if length <= 2 * _ENDS_M:
            return True
        steps = np.arange(_ENDS_M, length - _ENDS_M, self.grid.resolution_m / 2) / length
        points = self.X_MO.transform(a + steps[:, None] * (b - a))
        columns, rows = np.floor((points - np.array(self.grid.origin)) / self.grid.resolution_m).astype(np.intp).T
        height, width = self.grid.cells.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        return not bool((self.grid.cells[rows[inside], columns[inside]] >= _OCCUPIED).any())

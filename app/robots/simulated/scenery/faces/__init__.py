"""Photographs of faces for people in the simulated world; sources and licences in ``README.md`` beside. Every picture
is 192 x 256 px, upright, cut so that the lines of the eyes and of the mouth are at fixed rows: the 64 px between them
are 0.040 of the person's height.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

MIDDLE_PX, EYES_PX, MOUTH_PX = 96, 120, 184
Rgb = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class FaceLook:
    """Attributes beside the picture: colours of skin and hair, and length of the hair (share of the head)."""

    skin: Rgb
    hair: Rgb
    hair_to: float


FACES: dict[str, FaceLook] = {
    "pilot": FaceLook((222, 178, 150), (128, 98, 62), -0.55),
    "programmer": FaceLook((214, 164, 138), (26, 26, 38), -0.35),
    "visitor": FaceLook((206, 152, 132), (206, 200, 196), -0.45),
    "lecturer": FaceLook((188, 128, 96), (52, 44, 42), -0.45),
}


def face_picture(name: str) -> NDArray[np.uint8]:
    """The photograph (256, 192, 3) uint8 RGB of a face of ``FACES``."""
    import cv2  # here, because naming a face in a scenario needs no pictures

    picture = cv2.imread(str(Path(__file__).parent / f"{name}.jpg"))
    assert picture is not None
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)

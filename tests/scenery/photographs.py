"""dlib's example photographs with their boxed faces, and how many of these a detector finds.

The photographs are not in the repository: they are looked for in the folder that ``HBBA_REFERENCE_DATA`` names.
"""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from app.modules.perception.faces.yunet import overlap

#: An overlap from which a box has found a face.
MATCH = 0.3

Box = tuple[float, float, float, float]

#: Faces (left, top, width, height) of dlib's ``examples/faces/training.xml``; ``testing.xml`` lies by the photographs.
TRAINING: dict[str, tuple[Box, ...]] = {
    "2007_007763.jpg": (
        (194, 90, 37, 37), (158, 114, 37, 37), (381, 89, 45, 44), (94, 198, 37, 37), (178, 214, 37, 37),
        (294, 86, 37, 37), (309, 233, 45, 44),
    ),
    "2008_002079.jpg": (
        (406, 166, 37, 37), (122, 134, 37, 37), (346, 138, 37, 37), (439, 175, 44, 44), (62, 134, 37, 37),
        (41, 194, 44, 44),
    ),
    "2008_001009.jpg": ((145, 79, 76, 76), (125, 214, 90, 91)),
    "2008_001322.jpg": ((104, 162, 76, 76), (232, 218, 63, 63), (344, 155, 90, 90)),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Photograph:
    """A file and the faces in it: left, top, width, height (px)."""

    path: Path
    boxes: tuple[Box, ...]


def boxed_photographs() -> list[Photograph]:
    """The photographs of the reference data that are there, in the order of their names."""
    data = os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data"
    folder = Path(data) / "faces"
    boxes = dict(TRAINING)
    if (folder / "testing.xml").is_file():
        for image in ET.parse(folder / "testing.xml").getroot().iter("image"):
            boxes[image.attrib["file"]] = tuple(
                (float(b.attrib["left"]), float(b.attrib["top"]), float(b.attrib["width"]), float(b.attrib["height"]))
                for b in image.iter("box")
            )
    there = [Photograph(folder / f"dlib_{name}", faces) for name, faces in sorted(boxes.items())]
    return [photograph for photograph in there if photograph.path.is_file()]


def read_rgb(path: Path) -> NDArray[np.uint8]:
    """An image file as (H, W, 3) uint8 RGB."""
    image = cv2.imread(str(path))
    assert image is not None, path
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)


def score_against(found: Sequence[Box], truth: Sequence[Box]) -> tuple[int, int]:
    """How many of the ``truth`` are found, each by a box of its own, and how many boxes are extra."""
    pairs = sorted(((overlap(f, t), i, j) for i, f in enumerate(found) for j, t in enumerate(truth)), reverse=True)
    boxes: set[int] = set()
    faces: set[int] = set()
    for share, i, j in pairs:
        if share >= MATCH and i not in boxes and j not in faces:
            boxes.add(i)
            faces.add(j)
    return len(faces), len(found) - len(boxes)

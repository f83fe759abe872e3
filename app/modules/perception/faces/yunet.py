"""Face detection: YuNet, run by OpenCV (Wu, Peng and Yu, *YuNet: A Tiny Millisecond-level Face Detector*,
Machine Intelligence Research 20, 2023).

The model (2023mar, 233 kB, MIT, Shiqi Yu) is beside this file: see YUNET.md.

Properties of OpenCV's FaceDetectorYN: input is BGR, of exactly the size set last; the result without faces is None; the
default threshold of 0.9 misses small faces, 0.8 does not and adds no false ones. It detects faces of about 10 to 300
px, so large photographs need several passes at different scales.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

#: Least score: at 0.8, all of 43 faces are found in the boxed photographs, without a false one.
THRESHOLD = 0.8

MODEL = Path(__file__).with_name("face_detection_yunet_2023mar.onnx")

#: Of two boxes with a larger intersection over union, the one with the lower score is dropped.
_OVERLAP = 0.3
_MOST = 5000


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """A face in an image: ``box`` left, top, width, height and ``landmarks`` (5, 2) float32, px (see ``Face``)."""

    score: float
    box: tuple[float, float, float, float]
    landmarks: NDArray[np.float32]


class YuNetDetector:
    """The loaded network. Not to be used by two threads at once."""

    def __init__(self, threshold: float = THRESHOLD) -> None:
        self._size = (320, 240)
        self._detector = cv2.FaceDetectorYN.create(
            str(MODEL), "", self._size, score_threshold=threshold, nms_threshold=_OVERLAP, top_k=_MOST
        )

    @property
    def threshold(self) -> float:
        """The least score of a face, in [0, 1]."""
        return float(self._detector.getScoreThreshold())

    @threshold.setter
    def threshold(self, threshold: float) -> None:
        self._detector.setScoreThreshold(threshold)

    def find(self, color: NDArray[np.uint8], longest: int | None = None) -> list[Detection]:
        """Every face of ``color`` (H, W, 3) uint8 RGB, by descending score.

        ``longest``: an image with a longer side (px) is reduced to it, which is faster and misses small faces; results
        are in pixels of the original image.
        """
        height, width = color.shape[:2]
        scale = 1.0 if longest is None else min(1.0, longest / max(width, height))
        return self._look(color, scale)

    def find_all_sizes(self, color: NDArray[np.uint8]) -> list[Detection]:
        """Every face of a photograph of any size: a pass on a reduced image for large faces, one on the original."""
        longest = max(color.shape[:2])
        scales = [min(1.0, side / longest) for side in _PHOTO_SIDES if side == _PHOTO_SIDES[0] or longest > side / 2]
        return merged(face for scale in sorted(set(scales)) for face in self._look(color, scale))

    def _look(self, color: NDArray[np.uint8], scale: float) -> list[Detection]:
        height, width = color.shape[:2]
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        if size != (width, height):
            color = np.asarray(cv2.resize(color, size, interpolation=cv2.INTER_AREA), np.uint8)
        looked_at = (max(_LEAST_SIDE, size[0]), max(_LEAST_SIDE, size[1]))
        if looked_at != size:
            below, beside = looked_at[1] - size[1], looked_at[0] - size[0]
            color = np.asarray(cv2.copyMakeBorder(color, 0, below, 0, beside, cv2.BORDER_CONSTANT), np.uint8)
        if looked_at != self._size:
            self._detector.setInputSize(looked_at)
            self._size = looked_at
        # OpenCV's type declaration lacks None.
        rows: Any = self._detector.detect(cv2.cvtColor(color, cv2.COLOR_RGB2BGR))[1]
        if rows is None:
            return []
        across, down = width / size[0], height / size[1]
        return sorted((_detection(row, across, down) for row in np.asarray(rows, np.float32)), key=lambda d: -d.score)


#: In images of 32 px and less across or down OpenCV's YuNet reports faces from uninitialised memory.
_LEAST_SIDE = 33
#: Longest sides (px) of the passes over a photograph.
_PHOTO_SIDES = (640, 1600)


def _detection(row: NDArray[np.float32], across: float, down: float) -> Detection:
    left, top, width, height = row[:4].tolist()
    # Pixel centres: u of the reduced image is (u + 1/2) s - 1/2 of the image. Boxes are given by their edges.
    landmarks = (row[4:14].reshape(5, 2) + 0.5) * np.array((across, down), np.float32) - 0.5
    box = (left * across, top * down, width * across, height * down)
    return Detection(float(row[14]), box, landmarks.astype(np.float32))


def overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> float:
    """Intersection over union of two boxes (left, top, width, height), in [0, 1]."""
    across = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    down = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    if across <= 0 or down <= 0:
        return 0.0
    both = across * down
    return both / (a[2] * a[3] + b[2] * b[3] - both)


def merged(found: Iterable[Detection]) -> list[Detection]:
    """Each face once, by its highest score, where several passes found it."""
    kept: list[Detection] = []
    for face in sorted(found, key=lambda d: -d.score):
        if all(overlap(face.box, other.box) <= _OVERLAP for other in kept):
            kept.append(face)
    return kept

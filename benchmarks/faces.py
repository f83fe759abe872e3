"""Finding faces: YuNet as this program runs it, beside the boosted cascade that OpenCV ships (Viola and Jones's kind,
as the thesis's; ``haarcascade_frontalface_alt2``, with OpenCV's own settings).

Milliseconds are CPU time of one thread for one image. Photographs: dlib's nine examples (PASCAL VOC 2011) with their 43
boxed faces, each letterboxed to the size named; a face is found if a box overlaps its own by 0.3 (intersection over
union), and each box that finds none is extra. Distances: four photographs of faces as the simulated Kinect and the
simulated panoramic camera would see them (``face_scenes``), at every half metre and several directions.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import Image
from app.modules.perception.faces.face_position import FaceLocator
from app.modules.perception.faces.yunet import THRESHOLD, YuNetDetector
from app.modules.perception.opencv import use_calling_thread
from benchmarks.report import Row, benchmark_main, row
from tests.scenery.face_scenes import NAMES, facing, kinect_image, panorama_image
from tests.scenery.photographs import Box, boxed_photographs, read_rgb, score_against

BENCHMARK = "faces"
PEER = "Haar frontalface_alt2, OpenCV"
SIZES = ((320, 240), (640, 480), (1024, 768))

Detector = Callable[[NDArray[np.uint8]], list[Box]]


def letterboxed(color: NDArray[np.uint8], size: tuple[int, int]) -> tuple[NDArray[np.uint8], float]:
    """``color`` scaled to fit the upper left of a black image of ``size`` (width, height), and the scale."""
    scale = min(size[0] / color.shape[1], size[1] / color.shape[0])
    width, height = round(color.shape[1] * scale), round(color.shape[0] * scale)
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    whole = np.zeros((size[1], size[0], 3), np.uint8)
    whole[:height, :width] = cv2.resize(color, (width, height), interpolation=how)
    return whole, scale


def haar() -> Detector:
    """The peer."""
    cascade = cv2.CascadeClassifier(vars(cv2)["data"].haarcascades + "haarcascade_frontalface_alt2.xml")

    def find(color: NDArray[np.uint8]) -> list[Box]:
        grey = cv2.equalizeHist(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY))
        return [(float(x), float(y), float(w), float(h)) for x, y, w, h in cascade.detectMultiScale(grey)]

    return find


def yunet() -> Detector:
    """Ours."""
    finder = YuNetDetector(THRESHOLD)
    return lambda color: [face.box for face in finder.find(color)]


def timed(detect: Detector, color: NDArray[np.uint8]) -> tuple[list[Box], float]:
    """What it finds, and the CPU time it takes (ms)."""
    began = time.thread_time()
    found = detect(color)
    return found, 1e3 * (time.thread_time() - began)


def on_photographs(rounds: int) -> list[Row]:
    """Found, extra and time by size, both on the same images one after the other."""
    photographs = boxed_photographs()
    if not photographs:
        print("the boxed photographs are not there (HBBA_REFERENCE_DATA): they are left out\n")
        return []
    detectors = (yunet(), haar())
    rows = []
    for size in SIZES:
        images = [(letterboxed(read_rgb(p.path), size), p.boxes) for p in photographs]
        for detect in detectors:
            detect(images[0][0][0])
        times: tuple[list[float], list[float]] = ([], [])
        scores = [[0, 0], [0, 0]]
        for number in range(rounds):
            for (image, scale), boxes in images:
                for which, detect in enumerate(detectors):
                    found, ms = timed(detect, image)
                    times[which].append(ms)
                    if number == 0:
                        scored = score_against([_scaled(box, 1 / scale) for box in found], boxes)
                        scores[which][0] += scored[0]
                        scores[which][1] += scored[1]
        case = f"boxed photographs, {size[0]}x{size[1]}"
        of = sum(len(boxes) for _, boxes in images)
        rows += [
            row(BENCHMARK, case, "CPU per image", "ms", times[0], times[1], PEER),
            row(BENCHMARK, case, "found", f"of {of}", [scores[0][0]], [scores[1][0]], PEER),
            row(BENCHMARK, case, "extra", "boxes", [scores[0][1]], [scores[1][1]], PEER),
        ]
    return rows


def _scaled(box: Box, by: float) -> Box:
    return (box[0] * by, box[1] * by, box[2] * by, box[3] * by)


@dataclass(frozen=True, slots=True)
class Look:
    """One way of looking with one camera: its name, and what of it a strategy decides."""

    case: str
    scene: Callable[..., Image]
    longest: int
    px_per_rad: float
    azimuths: tuple[float, ...]


KINECT_AZIMUTHS = (-0.35, -0.12, 0.12, 0.35)
PANORAMA_AZIMUTHS = (-1.4, -0.7, 0.1, 1.4)
LOOKS = (
    Look("Kinect, fine", kinect_image, 640, 326, KINECT_AZIMUTHS),
    Look("Kinect, coarse", kinect_image, 320, 326, KINECT_AZIMUTHS),
    Look("panorama unrolled, 400 px/rad", panorama_image, 640, 400, PANORAMA_AZIMUTHS),
    Look("panorama unrolled, 326 px/rad", panorama_image, 640, 326, PANORAMA_AZIMUTHS),
    Look("panorama unrolled, 244 px/rad", panorama_image, 640, 244, PANORAMA_AZIMUTHS),
)


def at_distances(looks: Sequence[Look], distances: Sequence[float], turns: int) -> list[Row]:
    """For each look the CPU time of an image, and the share of faces found by distance."""
    looker = FaceLocator(THRESHOLD)
    rows = []
    for look in looks:
        shares: list[float] = []
        times: list[float] = []
        for distance in distances:
            found = 0
            for turn in range(turns):
                azimuths = look.azimuths[turn % 4 :] + look.azimuths[: turn % 4]
                height = 1.47 + 0.1 * (turn % 3)
                cards = [
                    facing(name, (0.1 + distance * math.cos(a), distance * math.sin(a), height), (0.1, 0.0))
                    for name, a in zip(NAMES, azimuths, strict=True)
                ]
                image = look.scene(0.0, Pose2(), cards, seed=turn)
                began = time.thread_time()
                sightings = looker.look(image, look.longest, look.px_per_rad)
                times.append(1e3 * (time.thread_time() - began))
                found += min(len(sightings), len(cards))
            shares.append(100 * found / (turns * len(NAMES)))
        rows.append(row(BENCHMARK, look.case, "CPU per image", "ms", times[1:]))
        rows += [
            row(BENCHMARK, look.case, f"faces found at {distance:g} m", "%", [share])
            for distance, share in zip(distances, shares, strict=True)
        ]
    return rows


def measure(quick: bool) -> list[Row]:
    """All rows; under a minute, in quick under ten seconds."""
    use_calling_thread()
    distances = (1.0, 2.0, 3.0, 4.0) if quick else (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0)
    return on_photographs(1 if quick else 5) + at_distances(LOOKS, distances, 1 if quick else 4)


if __name__ == "__main__":
    raise SystemExit(benchmark_main(__doc__, measure))

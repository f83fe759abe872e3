"""Reading QR codes beside OpenCV's detector and ZBar: ``python -m benchmarks.qr [--quick] [--json] [--out FILE]``.

*Photographs*: ZXing's black-box sets 1 to 3 with their truths, where they are (``HBBA_REFERENCE_DATA``); read is a text
that is equal. *Kinect*: posters traced at 57 degrees and 640 x 480, blur 0.7 px and noise of 5 levels, face on and
turned by 30 degrees. *Panorama*: posters traced into the hemisphere of 1024 x 768, all round to 80 degrees; ours reads
undistorted patches, the peers the image as it is. Contenders take turns on each image; ms is thread CPU time an image,
OpenCV held to one thread. ZBar is measured where ``pyzbar`` and libzbar0 are installed.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.messages import Image
from app.modules.perception.fisheye_patches import FisheyePatches
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.qr_codes import decode, detect_panorama
from benchmarks.report import Row, benchmark_main, row
from tests.scenery.posters import KINECT, PANORAMA, TEXT, facing_camera, picture

#: Texts read in an RGB image (H, W, 3).
Reader = Callable[[NDArray[np.uint8]], list[str]]
#: An image and the text it holds.
Case = tuple[NDArray[np.uint8], str]

REFERENCE = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).parents[2] / "shared" / "data") / "zxing_qr"


def _grey(color: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY), np.uint8)


def ours(color: NDArray[np.uint8]) -> list[str]:
    """Ours on a plain image."""
    return [text for text, _ in decode(_grey(color))]


def ours_on_panoramas() -> Reader:
    """Ours on a fisheye's image."""
    patches = FisheyePatches(PANORAMA)

    def read(color: NDArray[np.uint8]) -> list[str]:
        image = Image(0.0, "panorama", color, None, PANORAMA, Pose3.identity())
        return [code.text for code in detect_panorama(image, patches, 4)]

    return read


def peers() -> dict[str, Reader]:
    """The other readers there are here."""
    detector = cv2.QRCodeDetector()

    def opencv(color: NDArray[np.uint8]) -> list[str]:
        try:
            found, texts, _, _ = detector.detectAndDecodeMulti(_grey(color))
        except (cv2.error, UnicodeDecodeError):
            return []
        return [text for text in texts if text] if found else []

    readers: dict[str, Reader] = {"OpenCV": opencv}
    try:
        from pyzbar import pyzbar
    except ImportError as missing:
        print(f"ZBar is left out: {missing} (pip install pyzbar, and libzbar0)", file=sys.stderr)
    else:

        def zbar(color: NDArray[np.uint8]) -> list[str]:
            symbols: list[Any] = pyzbar.decode(_grey(color), symbols=[pyzbar.ZBarSymbol.QRCODE])
            return [symbol.data.decode("utf-8", "replace") for symbol in symbols]

        readers["ZBar"] = zbar
    return readers


def photographs(name: str) -> Iterator[Case]:
    """ZXing's photographs of one set, with the text of each."""
    for photo in sorted((REFERENCE / name).glob("*")):
        truth = photo.with_suffix(".txt")
        if photo.suffix in {".png", ".jpg", ".jpeg", ".gif"} and truth.is_file():
            image = cv2.imread(str(photo), cv2.IMREAD_COLOR)
            if image is not None:
                yield np.asarray(image[..., ::-1], np.uint8).copy(), truth.read_bytes().decode()


def kinect_posters(distance_m: float, tilt_deg: float, count: int) -> Iterator[Case]:
    """Posters before a Kinect."""
    rng = np.random.default_rng((round(100 * distance_m), round(tilt_deg)))
    for seed in range(count):
        azimuth, elevation = (math.radians(a) for a in rng.uniform((-15, -10), (15, 10)))
        pose = facing_camera(distance_m, azimuth, elevation, math.radians(tilt_deg) * rng.choice((-1, 1)))
        yield picture(KINECT, {TEXT: pose}, seed=seed), TEXT


def panorama_posters(distance_m: float, count: int) -> Iterator[Case]:
    """Posters all round the panoramic camera, turned by up to 30 degrees."""
    rng = np.random.default_rng(round(100 * distance_m))
    for seed in range(count):
        azimuth = math.radians(-80 + 160 * seed / max(1, count - 1))
        elevation, tilt = (math.radians(a) for a in rng.uniform((-30, -30), (15, 30)))
        yield picture(PANORAMA, {TEXT: facing_camera(distance_m, azimuth, elevation, tilt)}, seed=seed), TEXT


def compare(case: str, images: Iterator[Case], mine: Reader, others: dict[str, Reader]) -> list[Row]:
    """How many of ``images`` each reads, and in what time; ours beside each peer."""
    readers = {"ours": mine, **others}
    read = dict.fromkeys(readers, 0)
    spent: dict[str, list[float]] = {name: [] for name in readers}
    total = 0
    for color, truth in images:
        total += 1
        for name, reader in readers.items():
            begin = time.thread_time_ns()
            texts = reader(color)
            spent[name].append((time.thread_time_ns() - begin) / 1e6)
            read[name] += truth in texts
    rows = []
    for name in others:
        rows.append(row("qr", case, f"read of {total}", "", [read["ours"]], [read[name]], name))
        rows.append(row("qr", case, "CPU", "ms", spent["ours"], spent[name], name))
    return rows


def measure(quick: bool) -> Sequence[Row]:
    """All rows; ``quick``: a few images of each kind."""
    use_calling_thread()
    others = peers()
    count = 4 if quick else 12
    rows: list[Row] = []
    for name in ("qrcode-1",) if quick else ("qrcode-1", "qrcode-2", "qrcode-3"):
        if (REFERENCE / name).is_dir():
            rows += compare(f"photographs, {name}", photographs(name), ours, others)
        else:
            print(f"{name} is left out: {REFERENCE / name} is not there (set HBBA_REFERENCE_DATA)", file=sys.stderr)
    for distance_m in (1.5, 2.5) if quick else (1.0, 1.5, 2.0, 2.5, 3.0):
        for tilt_deg in (0.0, 30.0):
            case = f"Kinect, {distance_m} m, turned {tilt_deg:.0f} deg"
            rows += compare(case, kinect_posters(distance_m, tilt_deg, count), ours, others)
    reader = ours_on_panoramas()
    for distance_m in (0.8, 1.0) if quick else (0.6, 0.8, 1.0, 1.2, 1.5):
        rows += compare(f"panorama, {distance_m} m", panorama_posters(distance_m, 2 * count), reader, others)
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))

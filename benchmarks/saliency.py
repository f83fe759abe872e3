"""What the ego-sphere takes: CPU time of one thread for a picture of each camera, and for the regions and the map.

Pictures are those of the robot's cameras (Kinect 640 x 480, panorama 1024 x 768), of a room's texture with people's
faces, and change from one to the next; the head turns slowly, so that tables of projection are never those of the last
picture. *Regions and map* is what a beat takes, five times a second, whatever the divisors. Shares are per cent of one
core at the divisors of ``config/strategies/lab.yaml``.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np

from app.base.geometry import Pose2, unit_vector
from app.messages import Image
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.saliency.ego_sphere import EgoSphere
from app.modules.perception.saliency.feature_maps import PictureFeatures
from app.modules.perception.saliency.sphere_grid import SphereGrid
from app.modules.saliency_gains import SaliencyGains, gains_of
from benchmarks.report import Row, benchmark_main, row
from tests.scenery.face_scenes import NAMES, facing, kinect_image, panorama_image

BENCHMARK = "saliency"
#: Cameras: pictures a second of each, and how one is made.
CAMERAS: dict[str, tuple[float, Callable[..., Image]]] = {
    "Kinect": (15.0, kinect_image),
    "panorama": (10.0, panorama_image),
}
DIVISORS = (2, 4)
BEATS_HZ = 5.0


def measure(quick: bool) -> Sequence[Row]:
    """Both cameras and the beat, over 20 or 200 rounds, and what they come to."""
    use_calling_thread()
    rounds = 20 if quick else 200
    grid = SphereGrid()
    rows, pictures = [], {}
    for name, (rate_hz, make) in CAMERAS.items():
        times = _of_pictures(grid, make, rounds)
        pictures[name] = rate_hz * float(np.median(times))
        rows.append(row(BENCHMARK, f"a picture, {name}", "CPU", "ms", times))
    beat = _of_beats(grid, rounds)
    rows.append(row(BENCHMARK, "regions and map", "CPU", "ms", beat))
    for phi in DIVISORS:
        share = 0.1 * (sum(pictures.values()) / phi + BEATS_HZ * float(np.median(beat)))
        rows.append(row(BENCHMARK, f"φ = {phi}, both cameras", "CPU", "% of a core", [share]))
    return rows


def _of_pictures(grid: SphereGrid, make: Callable[..., Image], rounds: int) -> list[float]:
    """CPU time (ms) of each picture."""
    images = [make(0.0, Pose2(), [facing(NAMES[0], (2.0, 0.1 * step, 1.5))], step) for step in range(4)]
    features = PictureFeatures(grid)
    times = []
    for number in range(rounds):
        image = images[number % len(images)]
        X_OC = Pose2(0.0, 0.0, 0.001 * number).to_pose3() @ image.X_BC
        began = time.thread_time()
        features.take(0.2 * number, image.color, image.camera, X_OC, X_OC.translation)
        times.append(1e3 * (time.thread_time() - began))
    return times[1:]


def _of_beats(grid: SphereGrid, rounds: int) -> list[float]:
    """CPU time (ms) of each beat, with three regions, faces and a sound."""
    sphere, gains = EgoSphere(grid), gains_of({}, SaliencyGains())
    rng = np.random.default_rng(1)
    times = []
    for number in range(rounds):
        for feature in ("motion", "color", "contrast"):
            sphere.add(feature, rng.random((grid.rows, grid.columns), np.float32))
        began = time.thread_time()
        sphere.fade(0.2 * number)
        for feature, azimuth in (("faces", 0.5), ("sounds", -0.5)):
            sphere.add_percept(feature, unit_vector(azimuth, 0.1), 1.0, math.radians(5))
        sphere.peaks(gains)
        grid.turned(sphere.saliency(gains), 0.3)
        times.append(1e3 * (time.thread_time() - began))
    return times


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))

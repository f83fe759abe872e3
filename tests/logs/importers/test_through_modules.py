"""Another robot's data through our modules: a code hangs in the world, its bag is replayed, the detector finds it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import segno
from numpy.typing import NDArray

from app.logs.open import open_log
from app.logs.replay.headless import ReplayWatch, run_headless
from app.logs.replay.options import ReplayOptions
from app.messages import Landmarks, QRCodes
from tests.logs.importers import drive
from tests.logs.importers.bags import Sent, write_ros1, write_ros2_mcap

pytestmark = [pytest.mark.slow, pytest.mark.blocking(reason="the virtual loop waits for threads by design")]

TEXT = "a code on another robot's wall"
#: The wall is the plane x = 3.5 m of odom; the poster's centre and side (m).
WALL_X, CENTRE, SIDE = 3.5, (0.9, 1.2), 0.8


def poster() -> NDArray[np.uint8]:
    """The code and its white border, one value (0 or 255) a module."""
    rows = segno.make_qr(TEXT, error="m").matrix_iter(border=4)
    return np.array([[0 if dark else 255 for dark in row] for row in rows], np.uint8)


def wall(code: NDArray[np.uint8]) -> drive.View:
    """What the camera sees of a grey wall with the code on it."""
    v, u = np.mgrid[0:240, 0:320]
    rays = np.stack(((u - drive.K[2]) / drive.K[0], (v - drive.K[5]) / drive.K[4], np.ones_like(u)), axis=-1)

    def view(number: int, stamp: float) -> tuple[NDArray[np.uint8], NDArray[np.uint16]]:
        X_OC = drive.base_at(stamp).to_pose3() @ drive.camera_at(stamp)
        directions = rays @ X_OC.rotation.T
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = (WALL_X - X_OC.translation[0]) / directions[..., 0]
            y, z = (X_OC.translation[i] + depth * directions[..., i] for i in (1, 2))
        ahead = (depth > 0.4) & (depth < 8.0)
        # Seen from the robot, y grows to the left and z upwards.
        column = np.floor((CENTRE[0] + SIDE / 2 - y) / SIDE * code.shape[1])
        row = np.floor((CENTRE[1] + SIDE / 2 - z) / SIDE * code.shape[0])
        inside = ahead & (column >= 0) & (column < code.shape[1]) & (row >= 0) & (row < code.shape[0])
        grey = np.full(depth.shape, 120, np.uint8)
        grey[inside] = code[row[inside].astype(int), column[inside].astype(int)]
        return np.repeat(grey[..., None], 3, axis=2), np.where(ahead, depth * 1000, 0).astype(np.uint16)

    return view


@pytest.mark.parametrize(
    "write",
    [lambda folder, sent: write_ros1(folder / "a.bag", sent), lambda folder, sent: write_ros2_mcap(folder / "a", sent)],
    ids=["ROS 1", "ROS 2"],
)
def test_the_detector_reads_and_places_a_code_in_a_bag(
    tmp_path: Path, write: Callable[[Path, list[Sent]], Path]
) -> None:
    said: dict[str, list[Any]] = {"qr_codes": [], "landmarks": []}
    log = open_log(write(tmp_path, drive.drive(compressed=True, view=wall(poster()))))
    # Without a map it places codes in odom, where the wall is known.
    only = ReplayOptions(only=("QRCodeDetector", "ScenarioCoordinator"))
    report = run_headless(log, only, watch=ReplayWatch(message=lambda channel, m: said.get(channel, []).append(m)))
    log.close()

    assert report.modules["QRCodeDetector"].inputs["images"].received == 40
    seen: list[QRCodes] = [m for m in said["qr_codes"] if m.codes]
    assert len(seen) >= 4
    assert {code.text for codes in seen for code in codes.codes} == {TEXT}
    landmarks: Landmarks = said["landmarks"][-1]
    (landmark,) = landmarks.landmarks
    assert landmark.text == TEXT
    np.testing.assert_allclose(landmark.p_FQ, (WALL_X, *CENTRE), atol=0.02)

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import zxingcpp
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.messages import Image
from app.modules.perception.fisheye_patches import FisheyePatches
from app.modules.perception.qr_codes import (
    central_ray,
    corner_rays,
    decode,
    detect,
    detect_panorama,
    diagonal_crossing,
    edge_angle,
    locate,
)
from tests.modules.perception.rendering import CODE_M, KINECT, X_BC, facing, kinect_image
from tests.scenery.posters import PANORAMA, facing_camera, picture

HERE = Pose2()
PATCHES = FisheyePatches(PANORAMA)
FloatArray = NDArray[np.float64]
#: A text that takes 25 x 25 modules: harder to read from afar than a short one.
LONG = "hbba:tour/stop-2/robot-lab"


def angle(one: FloatArray, other: FloatArray) -> float:
    """Between two unit vectors (rad)."""
    return float(np.arccos(np.clip(one @ other, -1.0, 1.0)))


@pytest.mark.parametrize("distance", [0.8, 1.5, 2.0, 2.5])
@pytest.mark.parametrize("turn_deg", [-30, 0, 30])
def test_a_poster_is_read_and_placed(distance: float, turn_deg: float) -> None:
    X_OQ = facing(0.1 + distance, 0.15, 1.4, math.radians(turn_deg))
    (code,) = detect(kinect_image(0.0, HERE, {"hbba:stop-1": X_OQ}))
    assert code.text == "hbba:stop-1"
    assert code.p_BQ is not None
    assert math.dist(code.p_BQ, tuple(X_OQ.translation)) < 0.01 + 0.005 * distance**2
    assert code.n_BQ is not None
    assert code.normal_sigma is not None
    assert angle(np.array(code.n_BQ), -X_OQ.rotation[:, 2]) < min(3.0 * code.normal_sigma, 0.15)
    half = CODE_M / 2
    square = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
    expected = KINECT.project((X_BC.inverse() @ X_OQ).transform(square))
    np.testing.assert_allclose(code.corners, expected, atol=3.0)
    assert not code.corners.flags.writeable


def test_enlarging_reads_what_is_too_far_otherwise() -> None:
    images = [kinect_image(0.0, HERE, {LONG: facing(2.6, 0.013 * i, 1.3 + 0.017 * i)}, seed=i) for i in range(4)]
    assert sum(len(detect(image, upscale=False)) for image in images) < 4
    for image in images:
        (code,) = detect(image, upscale=True)
        assert code.text == LONG
        assert code.p_BQ is not None
        assert code.p_BQ[0] == pytest.approx(2.6, abs=0.02)


def test_several_codes_in_one_image() -> None:
    posters = {"left": facing(1.5, 0.4, 1.3), "right": facing(1.8, -0.4, 1.2)}
    codes = {code.text: code for code in detect(kinect_image(0.0, HERE, posters))}
    assert codes.keys() == posters.keys()
    for text, code in codes.items():
        assert code.p_BQ is not None
        assert math.dist(code.p_BQ, tuple(posters[text].translation)) < 0.03


def test_no_code_no_result() -> None:
    assert detect(kinect_image(0.0, HERE, {})) == ()


@pytest.mark.parametrize("kind", ["MicroQRCode", "RMQRCode"])
def test_smaller_kinds_of_codes_are_not_read(kind: str) -> None:
    """In the grain of walls they were found again and again, as posters of four digits."""
    code = zxingcpp.create_barcode("2118", getattr(zxingcpp.BarcodeFormat, kind))
    picture = np.array(zxingcpp.write_barcode_to_image(code, scale=6))
    assert zxingcpp.read_barcodes(picture)
    assert decode(picture) == []


def test_a_hole_in_the_depth_does_not_move_the_code_and_no_depth_gives_no_place() -> None:
    X_OQ = facing(1.5, 0.0, 1.3, math.radians(40))
    image = kinect_image(0.0, HERE, {"hole": X_OQ})
    (whole,) = detect(image)
    assert image.depth is not None
    u = round(float(whole.corners[:, 0].mean()))
    image.depth[:, u:] = 0
    (half,) = detect(image)
    assert half.p_BQ is not None
    assert math.dist(half.p_BQ, tuple(X_OQ.translation)) < 0.03
    image.depth[:] = 0
    (none,) = detect(image)
    assert (none.text, none.p_BQ) == ("hole", None)


def test_a_few_wild_depths_do_not_move_the_code() -> None:
    X_OQ = facing(1.5, 0.0, 1.3)
    image = kinect_image(0.0, HERE, {"wild": X_OQ})
    assert image.depth is not None
    wild = np.random.default_rng(3).random(image.depth.shape) < 0.1
    image.depth[wild] = 4800
    (code,) = detect(image)
    assert code.p_BQ is not None
    assert math.dist(code.p_BQ, tuple(X_OQ.translation)) < 0.03


@given(st.floats(0.6, 4.5), st.floats(-0.3, 0.3), st.floats(-0.2, 0.2), st.floats(-60, 60), st.integers(0, 2**32 - 1))
def test_locate_finds_the_centre_of_any_plane_quad(z: float, x: float, y: float, turn_deg: float, seed: int) -> None:
    """Exact depth of a tilted square: the centre comes out to the depth's own grain (1 mm) over the fit."""
    turn = math.radians(turn_deg)
    right = np.array([math.cos(turn), 0.0, math.sin(turn)]) * CODE_M / 2
    down = np.array([0.0, CODE_M / 2, 0.0])
    centre = np.array([x * z, y * z, z])
    corners = KINECT.project(
        np.stack((centre - right - down, centre + right - down, centre + right + down, centre - right + down))
    )
    normal = np.cross(right, down)
    v, u = np.mgrid[: KINECT.height, : KINECT.width]
    rays = KINECT.back_project(np.stack((u, v), -1).astype(float), np.ones(u.shape))
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (normal @ centre) / (rays @ normal)
    depth = np.where((depth > 0.4) & (depth < 6), depth, 0)
    found = locate(corners.astype(np.float32), np.round(depth * 1000).astype(np.uint16), KINECT)
    assert found is not None
    assert math.dist(found.p_CQ, centre) < 0.004
    # Millimetres over a code that is a few pixels wide tell its direction badly, and it says so.
    towards = normal / np.linalg.norm(normal) * -math.copysign(1.0, normal @ centre)
    assert found.n_CQ is not None
    assert found.normal_sigma is not None
    assert angle(found.n_CQ, towards) < 4.0 * found.normal_sigma
    assert found.normal_sigma < 0.03 or z > 2.0


def test_a_code_half_out_of_the_picture_is_placed_by_what_is_in_it() -> None:
    depth = np.full((480, 640), 2000, np.uint16)
    corners = np.array([(-40, 200), (39, 200), (39, 280), (-40, 280)], np.float32)
    found = locate(corners, depth, KINECT)
    assert found is not None
    assert found.p_CQ[2] == pytest.approx(2.0, abs=0.01)
    assert locate(corners - np.array([100, 0], np.float32), depth, KINECT) is None


def test_depths_on_one_line_give_their_median() -> None:
    depth = np.zeros((480, 640), np.uint16)
    depth[200:280, 320] = 1500
    corners = np.array([(317, 200), (323, 200), (323, 280), (317, 280)], np.float32)
    found = locate(corners, depth, KINECT)
    assert found is not None
    assert found.p_CQ[2] == pytest.approx(1.5)
    assert found.n_CQ is None


def test_diagonals_cross_where_perspective_puts_the_centre() -> None:
    square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    np.testing.assert_allclose(diagonal_crossing(square), (1.0, 1.0))
    trapeze = np.array([(0.0, 0.0), (4.0, 1.0), (4.0, 3.0), (0.0, 4.0)])
    np.testing.assert_allclose(diagonal_crossing(trapeze)[1], 2.0)
    assert diagonal_crossing(trapeze)[0] > 2.0, "nearer to the far, short side"
    np.testing.assert_allclose(diagonal_crossing(np.zeros((4, 2))), (0.0, 0.0))


REFERENCE = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).parents[4] / "shared" / "data") / "zxing_qr"


@pytest.mark.parametrize(("name", "least"), [("qrcode-1", 20), ("qrcode-2", 33), ("qrcode-3", 42)])
def test_real_photographs(name: str, least: int) -> None:
    """ZXing's black-box photographs: the published bar of its own decoder is 17 of 20, 32 of 35, 38 of 42."""
    folder = REFERENCE / name
    if not folder.is_dir():
        pytest.skip(f"reference photographs are not there: {folder} (set HBBA_REFERENCE_DATA)")
    right = total = 0
    for photo in sorted(p for p in folder.iterdir() if p.suffix in {".png", ".jpg", ".jpeg", ".gif"}):
        truth = photo.with_suffix(".txt")
        grey = cv2.imread(str(photo), cv2.IMREAD_GRAYSCALE)
        assert grey is not None, photo
        total += 1
        texts = [text for text, _ in decode(np.asarray(grey, np.uint8))]
        right += truth.exists() and truth.read_bytes().decode() in texts
    assert total >= least
    assert right >= least


# --- The panoramic camera ---------------------------------------------------------------------------------------------


def panorama(posters: dict[str, Pose3], **kind: Any) -> Image:
    return Image(0.0, "panorama_optical_frame", picture(PANORAMA, posters, **kind), None, PANORAMA, X_BC)


@pytest.mark.parametrize("azimuth_deg", [-80, -45, 0, 30, 75])
@pytest.mark.parametrize("tilt_deg", [0, 30])
def test_the_panorama_is_read_to_a_metre_in_all_directions(azimuth_deg: float, tilt_deg: float) -> None:
    X_CQ = facing_camera(1.0, math.radians(azimuth_deg), math.radians(-15), math.radians(tilt_deg))
    image = panorama({LONG: X_CQ}, seed=azimuth_deg + 100)
    (code,) = detect_panorama(image, PATCHES, 4)
    assert (code.text, code.p_BQ) == (LONG, None)
    half = CODE_M / 2
    square = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
    np.testing.assert_allclose(code.corners, PANORAMA.project(X_CQ.transform(square)), atol=2.5)
    assert not code.corners.flags.writeable
    ray = central_ray(corner_rays(code, PANORAMA))
    to_centre = X_CQ.translation / np.linalg.norm(X_CQ.translation)
    assert math.degrees(math.acos(min(1.0, float(ray @ to_centre)))) < 0.3
    assert 1.0 * 2 * math.tan(edge_angle(corner_rays(code, PANORAMA)) / 2) == pytest.approx(CODE_M, abs=0.02)


def test_the_same_text_twice_in_the_panorama_is_two_codes_and_one_poster_never_is() -> None:
    left, right = (facing_camera(0.8, math.radians(a)) for a in (-35, 15))
    image = panorama({"exit": left})
    both = image.color.copy()
    both[:, 512:] = panorama({"exit": right}).color[:, 512:]
    assert len(detect_panorama(image, PATCHES, 8)) == 1
    found = detect_panorama(replace(image, color=both), PATCHES, 8)
    assert [code.text for code in found] == ["exit", "exit"]


@given(st.floats(-80, 80), st.floats(-50, 50), st.floats(-50, 50), st.floats(0, 360), st.floats(0.5, 2))
def test_the_central_ray_points_at_the_centre_with_any_camera(
    azimuth: float, elevation: float, tilt: float, roll: float, distance: float
) -> None:
    X_CQ = facing_camera(distance, *(math.radians(a) for a in (azimuth, elevation, tilt, roll)))
    half = CODE_M / 2
    square = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
    rays = X_CQ.transform(square).astype(np.float64)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    np.testing.assert_allclose(central_ray(rays), X_CQ.translation / distance, atol=1e-9)

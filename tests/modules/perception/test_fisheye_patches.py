from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import FisheyeModel
from app.modules.perception.fisheye_patches import HALF_FOV, STEP, FisheyePatches
from tests.scenery.posters import PANORAMA, TEXT, facing_camera, picture

PATCHES = FisheyePatches(PANORAMA)


def grey_of(azimuth_deg: float, elevation_deg: float, distance_m: float = 1.0) -> np.ndarray:
    place = facing_camera(distance_m, math.radians(azimuth_deg), math.radians(elevation_deg))
    return cv2.cvtColor(picture(PANORAMA, {TEXT: place}), cv2.COLOR_RGB2GRAY)


@given(st.integers(-8, 8), st.integers(-4, 4), st.floats(0, 300), st.floats(0, 300))
def test_a_pixel_of_a_patch_shows_what_the_camera_sees_along_its_ray(across: int, up: int, u: float, v: float) -> None:
    """A picture whose grey is a smooth function of direction comes out as that function in every patch."""
    pixel = np.array([u, v])
    ray = PATCHES.rays((across, up), pixel)
    assert np.linalg.norm(ray) == pytest.approx(1.0)
    middle = PATCHES.rays((across, up), np.array([160.5, 160.5]))
    assert math.atan2(middle[0], middle[2]) == pytest.approx(across * STEP)
    assert -math.asin(middle[1]) == pytest.approx(up * STEP)
    assert math.acos(min(1.0, float(ray @ middle))) <= math.sqrt(2) * HALF_FOV


def test_a_patch_is_resampled_where_its_rays_look() -> None:
    v, u = np.mgrid[: PANORAMA.height, : PANORAMA.width]
    rays = PANORAMA.rays(np.stack((u, v), axis=-1).astype(float))
    smooth = np.nan_to_num(128 + 100 * rays[..., 0] * np.cos(2 * rays[..., 1])).round().astype(np.uint8)
    for cell in ((0, 0), (7, 0), (-4, 3), (2, -4)):
        patch = PATCHES.cut(smooth, cell)
        assert patch.shape == (322, 322)
        v, u = np.mgrid[: patch.shape[0], : patch.shape[1]]
        looked = PATCHES.rays(cell, np.stack((u, v), axis=-1))
        np.testing.assert_allclose(patch, 128 + 100 * looked[..., 0] * np.cos(2 * looked[..., 1]), atol=1.6)


def test_beyond_the_hemisphere_a_patch_is_black() -> None:
    v, u = np.mgrid[: PANORAMA.height, : PANORAMA.width]
    seen = np.isfinite(PANORAMA.rays(np.stack((u, v), axis=-1).astype(float))[..., 0])
    white = np.where(seen, 255, 0).astype(np.uint8)
    patch = PATCHES.cut(white, (9, 0))
    assert patch[:, :150].min() > 250
    assert patch[:, 175:].max() == 0


@pytest.mark.parametrize(("azimuth", "elevation"), [(0, 0), (37, -12), (-63, 21), (80, -5), (-78, -30)])
def test_the_likeliest_patch_holds_the_poster(azimuth: float, elevation: float) -> None:
    across, up = PATCHES.promising(grey_of(azimuth, elevation), 4)[0]
    assert abs(math.degrees(across * STEP) - azimuth) <= 8
    assert abs(math.degrees(up * STEP) - elevation) <= 8


def test_where_nothing_is_printed_nothing_is_promising_however_noisy() -> None:
    bare = cv2.cvtColor(picture(PANORAMA, {}, noise=8.0), cv2.COLOR_RGB2GRAY)
    assert PATCHES.promising(bare.astype(np.uint8), 8) == []
    stripes = np.zeros_like(bare)
    stripes[:, ::4] = stripes[:, 1::4] = 255
    assert PATCHES.promising(stripes.astype(np.uint8), 8) == [], "print is dense in both directions"


def test_never_more_patches_than_allowed_and_none_twice() -> None:
    clutter = np.random.default_rng(0).integers(0, 2, (PANORAMA.height // 3, PANORAMA.width // 3)).astype(np.uint8)
    grey = cv2.resize(255 * clutter, (PANORAMA.width, PANORAMA.height), interpolation=cv2.INTER_NEAREST)
    cells = PATCHES.promising(grey.astype(np.uint8), 6)
    assert len(cells) == len(set(cells)) == 6


def test_tables_are_kept_but_not_without_bound() -> None:
    camera = FisheyeModel.from_fov(256, 192, math.pi, math.pi)
    patches = FisheyePatches(camera)
    grey = np.zeros((192, 256), np.uint8)
    for cell in [(across, up) for across in range(-8, 9) for up in range(-2, 2)]:
        patches.cut(grey, cell)
    assert len(patches._tables) == 64

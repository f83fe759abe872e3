"""Feature maps of synthetic pictures: what stands out, where it truly is, and what does not count."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import CameraModel, FisheyeModel, unit_vector
from app.modules.perception.saliency.ego_sphere import EgoSphere, Peak
from app.modules.perception.saliency.feature_maps import FeatureMaps, PictureFeatures
from app.modules.perception.saliency.sphere_grid import SphereGrid
from tests.modules.perception.saliency.pictures import FISHEYE, KINECT, Disc, camera_at, picture

GRID = SphereGrid()
P_OH = np.array([0.0, 0.0, 1.0])
GREY, WHITE, RED = (140, 140, 140), (230, 230, 230), (200, 30, 30)
CAMERAS = pytest.mark.parametrize("camera", [KINECT, FISHEYE], ids=["pinhole", "fisheye"])
Camera = CameraModel | FisheyeModel


def peak_of(found: FeatureMaps | None, feature: str) -> Peak | None:
    """Where a map is highest."""
    assert found is not None
    sphere = EgoSphere(GRID)
    sphere.add(feature, found.maps.get(feature, np.zeros((GRID.rows, GRID.columns), np.float32)))
    return next(iter(sphere.peaks({feature: 1.0}, 1)), None)


def off_deg(peak: Peak | None, disc: Disc) -> float:
    assert peak is not None
    cosine = float(unit_vector(peak.azimuth, peak.elevation) @ unit_vector(disc.azimuth, disc.elevation))
    return math.degrees(math.acos(min(1.0, cosine)))


def seen(
    features: PictureFeatures, camera: Camera, stamp: float, discs: list[Disc], heading: float = 0.0
) -> FeatureMaps:
    X_OC = camera_at(heading)
    found = features.take(stamp, picture(camera, X_OC, discs, noise=2.0, seed=int(100 * stamp)), camera, X_OC, P_OH)
    assert found is not None
    return found


@CAMERAS
def test_a_bright_disc_is_a_contrast_and_no_colour(camera: Camera) -> None:
    disc = Disc(0.25, 0.12, WHITE)
    found = seen(PictureFeatures(GRID), camera, 0.0, [disc])
    assert off_deg(peak_of(found, "contrast"), disc) < 2.0
    assert found.maps["color"].max() < 0.1 * found.maps["contrast"].max()
    assert "motion" not in found.maps, "there is nothing to compare with"


@CAMERAS
def test_a_red_disc_among_grey_ones_stands_out_by_colour(camera: Camera) -> None:
    red = Disc(-0.2, -0.1, RED)
    discs = [red, Disc(0.2, 0.1, WHITE), Disc(0.15, -0.15, (40, 40, 40))]
    assert off_deg(peak_of(seen(PictureFeatures(GRID), camera, 0.0, discs), "color"), red) < 2.0


@pytest.mark.parametrize("color", [(200, 30, 30), (30, 160, 30), (30, 30, 200), (200, 190, 20)])
def test_each_colour_stands_out(color: tuple[int, int, int]) -> None:
    disc = Disc(0.1, 0.0, color)
    assert off_deg(peak_of(seen(PictureFeatures(GRID), FISHEYE, 0.0, [disc]), "color"), disc) < 2.0


def test_an_even_wall_has_nothing_that_stands_out_not_at_the_picture_s_edge_either() -> None:
    for camera in (KINECT, FISHEYE):
        features = PictureFeatures(GRID)
        for stamp in (0.0, 0.2):
            found = seen(features, camera, stamp, [])
        assert {name: round(float(values.max()), 1) for name, values in found.maps.items()} == {
            "contrast": 0.0,
            "color": 0.0,
            "motion": 0.0,
        }


@CAMERAS
def test_what_moves_stands_out_where_it_is_and_what_stands_does_not(camera: Camera) -> None:
    features = PictureFeatures(GRID)
    still = [Disc(-0.25, 0.1, WHITE), Disc(0.3, -0.15, RED)]
    seen(features, camera, 0.0, [*still, Disc(0.0, 0.0, GREY)])
    moved = Disc(0.07, 0.0, (220, 220, 40))
    found = seen(features, camera, 0.2, [*still, moved])
    assert off_deg(peak_of(found, "motion"), moved) < 4.0
    again = seen(features, camera, 0.4, [*still, moved])
    assert again.maps["motion"].max() < 0.05


@CAMERAS
@pytest.mark.parametrize("turn_deg", [1.0, -2.7, 3.5])
def test_the_head_s_own_turning_is_no_motion(camera: Camera, turn_deg: float) -> None:
    features = PictureFeatures(GRID)
    discs = [Disc(-0.25, 0.1, WHITE), Disc(0.2, -0.1, RED), Disc(0.05, 0.15, (30, 30, 30))]
    seen(features, camera, 0.0, discs)
    found = seen(features, camera, 0.2, discs, heading=math.radians(turn_deg))
    assert found.maps["motion"].max() < 0.15


def test_pictures_of_a_camera_that_turns_fast_do_not_count_nor_does_motion_across_them() -> None:
    features = PictureFeatures(GRID)
    discs = [Disc(0.2, 0.0, WHITE)]
    seen(features, KINECT, 0.0, discs)
    X_OC = camera_at(math.radians(6))
    assert features.take(0.2, picture(KINECT, X_OC, discs), KINECT, X_OC, P_OH) is None
    found = seen(features, KINECT, 0.4, [Disc(0.3, 0.0, WHITE)], heading=math.radians(6))
    assert "contrast" in found.maps
    assert "motion" not in found.maps


def test_after_the_camera_moved_near_things_do_not_seem_to_move() -> None:
    features = PictureFeatures(GRID)
    for stamp, x in ((0.0, 0.0), (0.2, 0.08)):
        X_OC = camera_at(p_OC=(x, 0.0, 1.0))
        found = features.take(stamp, picture(KINECT, X_OC, [Disc(0.1, 0.0, WHITE)]), KINECT, X_OC, P_OH)
    assert found is not None
    assert "motion" not in found.maps


def test_where_all_flickers_nothing_stands_out() -> None:
    features = PictureFeatures(GRID)
    for stamp, grey in ((0.0, 90), (0.2, 200)):
        X_OC = camera_at()
        found = features.take(stamp, picture(FISHEYE, X_OC, [], ground=(grey,) * 3), FISHEYE, X_OC, P_OH)
    assert found is not None
    assert found.maps["motion"].max() < 0.05


def test_another_camera_s_place_is_accounted_for_at_the_range_that_is_taken() -> None:
    """A camera 0.4 m under the head sees a thing at its own height level; from the head it is down."""
    X_OC = camera_at(p_OC=(0.0, 0.0, 0.6))
    found = PictureFeatures(GRID, range_m=2.0).take(
        0.0, picture(FISHEYE, X_OC, [Disc(0.3, 0.0, WHITE)]), FISHEYE, X_OC, P_OH
    )
    assert off_deg(peak_of(found, "contrast"), Disc(0.3, -math.asin(0.4 / 2.0), WHITE)) < 2.0


@given(heading=st.floats(-math.pi, math.pi), turn=st.floats(-0.5, 0.5))
@settings(max_examples=15, deadline=None)
def test_a_turned_robot_sees_the_same_sphere(heading: float, turn: float) -> None:
    discs = [Disc(heading + 0.4, 0.1, RED), Disc(heading - 0.5, -0.2, WHITE)]
    spheres = []
    for at in (heading, heading + turn):
        sphere = EgoSphere(GRID)
        for feature, values in seen(PictureFeatures(GRID), FISHEYE, 0.0, discs, at).maps.items():
            sphere.add(feature, values)
        spheres.append(sphere.peaks({"color": 1.0, "contrast": 1.0}, 2))
    for disc, *peaks in zip(discs, *spheres, strict=True):
        assert all(off_deg(peak, disc) < 2.5 for peak in peaks)
    assert [p.saliency for p in spheres[0]] == pytest.approx([p.saliency for p in spheres[1]], rel=0.25)

"""Finding and placing faces: YuNet, the fisheye's image unrolled, depth and rays."""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2, Pose3
from app.modules.perception.faces import yunet
from app.modules.perception.faces.face_position import FaceLocator, apparent_size, face_depth, in_image, ray_covariance
from app.modules.perception.faces.face_tracks import FACE_M
from app.modules.perception.faces.panorama import Strip, StripView
from app.modules.perception.faces.yunet import MODEL, Detection, YuNetDetector, merged, overlap
from app.modules.perception.height_prior import SHARES, STANDING
from app.robots.simulated.scenery import gait, scenario_state
from tests.scenery.face_scenes import NAMES, PANORAMA, X_BKINECT, X_BPANORAMA, facing, kinect_image, panorama_image
from tests.scenery.photographs import boxed_photographs, read_rgb, score_against

VIEW = StripView(326)


@pytest.fixture(scope="module")
def looker() -> FaceLocator:
    return FaceLocator(yunet.THRESHOLD)


# --- YuNet -------------------------------------------------------------------------------------------------------


def test_all_boxed_faces_are_found_and_nothing_else() -> None:
    photographs = boxed_photographs()
    if not photographs:
        pytest.skip("the boxed photographs are not here (HBBA_REFERENCE_DATA, or shared/data beside the checkout)")
    finder = YuNetDetector()
    scores = [
        score_against([f.box for f in finder.find_all_sizes(read_rgb(photograph.path))], photograph.boxes)
        for photograph in photographs
    ]
    assert sum(len(photograph.boxes) for photograph in photographs) == 43
    assert sum(found for found, _ in scores) == 43
    assert sum(extra for _, extra in scores) == 0


def test_the_model_goes_with_its_licence() -> None:
    text = MODEL.with_name("YUNET.md").read_text(encoding="utf-8")
    assert "MIT License" in text
    assert "Copyright (c) 2020 Shiqi Yu" in text
    assert hashlib.sha256(MODEL.read_bytes()).hexdigest() in text


def test_a_reduced_image_gives_the_same_places(looker: FaceLocator) -> None:
    image = kinect_image(0, Pose2(), [facing("pilot", (1.5, 0, 1.5))]).color
    (whole,), (reduced,) = looker.finder.find(image), looker.finder.find(image, 320)
    assert overlap(whole.box, reduced.box) > 0.8
    assert np.abs(whole.landmarks - reduced.landmarks).max() < 4


def test_large_and_small_faces_of_a_large_photograph_are_found(looker: FaceLocator) -> None:
    near, far = facing("pilot", (0.6, 0.0, 1.3)), facing("visitor", (2.2, 0.75, 1.5))
    image = np.repeat(np.repeat(kinect_image(0, Pose2(), [near, far]).color, 4, axis=0), 4, axis=1)
    found = looker.finder.find_all_sizes(image)
    assert len(found) == 2
    assert max(f.box[2] for f in found) > 500


def test_of_overlapping_boxes_the_higher_scored_stays() -> None:
    marks = np.zeros((5, 2), np.float32)
    a, b, c = (
        Detection(s, box, marks) for s, box in ((0.8, (0, 0, 10, 10)), (0.9, (1, 1, 10, 10)), (0.85, (30, 0, 9, 9)))
    )
    assert [f.score for f in merged([a, b, c])] == [0.9, 0.85]
    assert overlap(a.box, a.box) == 1
    assert overlap(a.box, c.box) == 0


# --- the fisheye's image unrolled -------------------------------------------------------------------------------


@settings(deadline=None, max_examples=20)
@given(
    azimuth=st.floats(-1.5, 1.5),
    elevation=st.floats(-0.4, 0.75),
    tilt=st.floats(-0.15, 0.15),
    roll=st.floats(-0.1, 0.1),
)
def test_a_strip_stands_upright_however_the_camera_is_held(
    azimuth: float, elevation: float, tilt: float, roll: float
) -> None:
    X_BC = Pose3.from_translation_rpy((0, 0, 0), (roll, tilt, 0)) @ X_BPANORAMA
    strip = Strip(PANORAMA, X_BC.rotation[2], StripView(60))
    column = (strip.view.azimuth - azimuth) * 60 - 0.5
    row = (strip.view.highest - elevation) * 60 - 0.5
    x, y, z = X_BC.rotation @ strip.rays(np.array((column, row)))
    assert math.asin(z) == pytest.approx(elevation, abs=1e-9)
    ahead = X_BC.rotation[:, 2]
    assert math.atan2(y, x) - math.atan2(ahead[1], ahead[0]) == pytest.approx(azimuth, abs=1e-9)


def test_a_strip_shows_what_the_fisheye_sees_there() -> None:
    color = np.zeros((PANORAMA.height, PANORAMA.width, 3), np.uint8)
    ray_B = np.array((math.cos(1.2) * math.cos(0.3), math.sin(1.2) * math.cos(0.3), math.sin(0.3)))
    u, v = np.round(PANORAMA.project(X_BPANORAMA.rotation.T @ ray_B)).astype(int)
    color[v - 1 : v + 2, u - 1 : u + 2] = 255
    strip = Strip(PANORAMA, X_BPANORAMA.rotation[2], VIEW)
    rows, columns = np.nonzero(strip.unroll(color)[..., 0] > 128)
    seen = X_BPANORAMA.rotation @ strip.rays(np.array((columns.mean(), rows.mean())))
    assert math.degrees(math.acos(min(1.0, float(seen @ ray_B)))) < 0.2


@given(camera=st.floats(0.3, 1.9), face=st.floats(1.05, 1.80), distance=st.floats(0.9, 8))
def test_a_strip_of_people_holds_their_faces(camera: float, face: float, distance: float) -> None:
    view = StripView.of_people(camera, 100)
    assert view.lowest < math.atan2(face - camera, distance) < view.highest


def test_a_strip_is_made_again_when_the_camera_tilts_and_not_when_it_trembles() -> None:
    strip = Strip(PANORAMA, X_BPANORAMA.rotation[2], StripView(60))
    for degrees, fits in ((0.3, True), (3.0, False)):
        tilted = Pose3.from_translation_rpy((0, 0, 0), (0, math.radians(degrees), 0)) @ X_BPANORAMA
        assert strip.fits(PANORAMA, tilted.rotation[2]) == fits


def test_a_box_at_the_rim_is_reported_in_pixels_of_the_image() -> None:
    strip = Strip(PANORAMA, X_BPANORAMA.rotation[2], VIEW)
    face = Detection(0.9, (60.0, 60.0, 50.0, 60.0), np.full((5, 2), 85, np.float32))
    seen = in_image(face, strip)
    assert seen is not None
    left, top, width, height = seen.box
    u, v = seen.landmarks[0]
    assert left < u < left + width
    assert top < v < top + height
    assert left > 0
    beyond = Detection(0.9, (-60.0, 60.0, 50.0, 60.0), np.full((5, 2), -40, np.float32))
    assert in_image(beyond, strip) is None


# --- places -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("distance", [0.8, 1.5, 2.5, 4.0])
def test_faces_with_depth_are_placed_within_centimetres(looker: FaceLocator, distance: float) -> None:
    cards = [
        facing(n, (distance * math.cos(a), distance * math.sin(a), 1.55))
        for n, a in zip(NAMES, (-0.3, -0.1, 0.1, 0.3), strict=True)
    ]
    sightings = looker.look(kinect_image(0, Pose2(), cards), 640, 326)
    assert len(sightings) == 4
    for sighting in sightings:
        assert sighting.measured
        deviation = min((sighting.p_BF - card.place for card in cards), key=lambda d: float(np.linalg.norm(d)))
        assert np.linalg.norm(deviation) < 0.03
        assert deviation @ np.linalg.solve(sighting.covariance, deviation) < 16


@pytest.mark.parametrize("azimuth", [0.0, 80.0, -80.0])
@pytest.mark.parametrize("distance", [0.8, 1.5, 2.0])
def test_faces_all_around_have_their_direction_and_a_distance_with_its_deviation(
    looker: FaceLocator, azimuth: float, distance: float
) -> None:
    a = math.radians(azimuth)
    card = facing("lecturer", (0.1 + distance * math.cos(a), distance * math.sin(a), 1.5))
    (sighting,) = looker.look(panorama_image(0, Pose2(), [card]), None, 326)
    truth = np.array(card.place) - X_BPANORAMA.translation
    true_range = float(np.linalg.norm(truth))
    assert math.degrees(math.acos(min(1.0, float(sighting.ray @ truth) / true_range))) < 1.0
    assert abs(sighting.range_m - true_range) < 2 * sighting.range_sigma_m
    assert abs(math.log(FACE_M / sighting.size_rad / true_range)) < 0.35, "the size, too, says how far it is"
    along = float(sighting.ray @ sighting.covariance @ sighting.ray)
    assert along == pytest.approx(sighting.range_sigma_m**2)
    assert along > 50 * np.linalg.eigvalsh(sighting.covariance)[0], "long along the ray, short across it"


@given(st.floats(-0.4, 0.4), st.floats(-0.3, 0.3), st.floats(0.01, 0.06), st.floats(0.01, 0.06))
@settings(max_examples=30, deadline=None)
def test_a_face_has_the_size_of_its_box_wherever_it_is_in_the_image(
    right: float, down: float, wide: float, high: float
) -> None:
    camera = PANORAMA
    left, top = camera.project(np.array((math.sin(right), math.sin(down), 1.5)))
    size = apparent_size((float(left), float(top), wide * camera.fx, high * camera.fy), camera.rays)
    assert size == pytest.approx(math.sqrt(wide * high), rel=0.1)


def test_beyond_the_depths_reach_height_takes_its_place(looker: FaceLocator) -> None:
    image = kinect_image(0, Pose2(), [facing("visitor", (2.0, 0.0, 1.6))])
    blind = type(image)(image.stamp, image.frame, image.color, np.zeros_like(image.depth), image.camera, X_BKINECT)
    (sighting,) = looker.look(blind, 640, 326)
    assert not sighting.measured
    assert sighting.range_sigma_m > 0.3


def test_a_faces_depth_is_not_its_backgrounds() -> None:
    depth = np.full((100, 100), 4000, np.uint16)
    depth[30:70, 38:62] = 1500
    depth[35:50, 40:50] = 0
    assert face_depth((35, 30, 30, 40), depth) == pytest.approx(1.5)
    # A face turned away, half hidden: what is behind does not pull its depth to its farther cheek.
    depth[30:70, 40:49] = np.linspace(1450, 1550, 9)
    depth[30:70, 49:62] = 4000
    assert face_depth((32, 30, 32, 40), depth) == pytest.approx(1.50, abs=0.01)
    assert face_depth((70, 70, 60, 60), np.zeros((100, 100), np.uint16)) is None
    assert face_depth((120, 30, 30, 40), depth) is None, "outside the image"


def test_a_covariance_along_a_ray() -> None:
    ray = np.array((0.6, 0.0, 0.8))
    covariance = ray_covariance(ray, 0.5, 0.01)
    assert math.sqrt(ray @ covariance @ ray) == pytest.approx(0.5)
    assert sorted(np.sqrt(np.linalg.eigvalsh(covariance))) == pytest.approx([0.01, 0.01, 0.5])


def test_simulated_people_are_drawn_from_the_same_heights() -> None:
    assert (STANDING.mean_m, STANDING.sigma_m) == (scenario_state.HEIGHT_MEAN_M, scenario_state.HEIGHT_SIGMA_M)
    assert (SHARES["eyes"], SHARES["mouth"]) == (gait.EYES_SHARE, gait.MOUTH_SHARE)


@pytest.mark.parametrize("size", [(1, 1), (640, 10), (20, 200), (32, 32), (640, 32)])
def test_an_image_with_hardly_a_side_has_no_faces(size: tuple[int, int]) -> None:
    width, height = size
    noise = np.random.default_rng(1).integers(0, 255, (height, width, 3), np.uint8)
    # More than once, since the memory that was looked at differs.
    assert [YuNetDetector().find(noise) for _ in range(3)] == [[], [], []]

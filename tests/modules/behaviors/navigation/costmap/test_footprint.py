from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.link import BaseLimits, RobotDescription
from app.modules.behaviors.navigation.costmap.footprint import Footprint, clearances
from tests.modules.behaviors.navigation.maps import OBLONG, ROUND

RESOLUTION = 0.025


def test_radii_of_a_round_body_and_of_a_rectangle() -> None:
    assert ROUND.inscribed_m == pytest.approx(0.28, abs=1e-3)
    assert ROUND.circumscribed_m == pytest.approx(0.28 / math.cos(math.pi / 16), abs=1e-3)
    assert OBLONG.inscribed_m == pytest.approx(0.215)
    assert OBLONG.circumscribed_m == pytest.approx(math.hypot(0.254, 0.215))


def test_an_arm_to_the_side_needs_a_passage_as_wide_as_both_though_the_bodys_middle_may_pass_aside() -> None:
    arm = np.array([[0.25, -0.25], [0.25, 0.25], [0.05, 0.75], [-0.05, 0.75], [-0.25, 0.25], [-0.25, -0.25]])
    outline = Footprint.stretched(arm, sideways=False)
    assert outline.with_arms
    assert outline.passing_m == pytest.approx(0.5)
    assert outline.inscribed_m == pytest.approx(Footprint.polygon(arm).inscribed_m)
    assert Footprint.stretched(arm, sideways=True).passing_m == pytest.approx(outline.inscribed_m)
    ahead = arm[:, ::-1][::-1]
    assert Footprint.stretched(ahead, sideways=False).passing_m == pytest.approx(0.25)
    assert not OBLONG.with_arms
    assert OBLONG.passing_m == OBLONG.inscribed_m


def test_a_body_that_does_not_move_has_none() -> None:
    desk = RobotDescription("desk", Path("desk.urdf"), BaseLimits(1, 1, 1, 1), {}, simulated=False)
    with pytest.raises(ValueError, match="desk has no footprint"):
        Footprint.of(desk)


@pytest.mark.parametrize(
    "corners",
    [
        [[0.1, 0.0], [0.0, 0.1]],
        [[0.2, 0.2], [0.2, -0.2], [-0.2, -0.2], [-0.2, 0.2]],
        [[0.2, -0.2], [0.05, 0.0], [0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2]],
        [[0.5, -0.1], [0.5, 0.1], [0.2, 0.1], [0.2, -0.1]],
    ],
    ids=["two corners", "clockwise", "dented", "not around base_link"],
)
def test_what_is_no_footprint_is_refused(corners: list[list[float]]) -> None:
    with pytest.raises(ValueError, match="footprint"):
        Footprint.polygon(np.array(corners))


@given(st.floats(0.02, 0.1), st.booleans())
def test_samples_leave_no_gap(spacing_m: float, oblong: bool) -> None:
    body = OBLONG if oblong else ROUND
    samples = body.samples(spacing_m)
    assert body.contains(samples, 1e-9).all()
    inside = np.random.default_rng(0).uniform(-0.3, 0.3, (400, 2))
    beyond = inside[body.contains(inside) & (np.hypot(*inside.T) > body.inscribed_m)]
    gaps = np.linalg.norm(beyond[:, None] - samples[None], axis=-1).min(axis=1)
    assert (gaps <= spacing_m).all()


@settings(max_examples=40)
@given(
    st.lists(st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6)), min_size=1, max_size=5),
    st.floats(-0.1, 0.1),
    st.floats(-0.1, 0.1),
    st.floats(-math.pi, math.pi),
    st.booleans(),
)
def test_clearances_are_those_of_the_polygon(
    obstacles: list[tuple[float, float]], x: float, y: float, theta: float, oblong: bool
) -> None:
    body = OBLONG if oblong else ROUND
    free = np.ones((80, 80), dtype=np.uint8)
    for ox, oy in obstacles:
        free[int((oy + 1.0) / RESOLUTION), int((ox + 1.0) / RESOLUTION)] = 0
    distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * np.float32(RESOLUTION)
    found = float(clearances(distance, (-1.0, -1.0), RESOLUTION, body, np.array([[x, y, theta]]))[0])
    rows, columns = np.nonzero(free == 0)
    middles = np.stack((columns, rows), axis=-1) * RESOLUTION - 1.0 + 0.5 * RESOLUTION - np.array([x, y])
    c, s = math.cos(theta), math.sin(theta)
    seen = middles @ np.array([[c, -s], [s, c]])
    polygon = body.corners.astype(np.float32)[:, None]
    true = min(-cv2.pointPolygonTest(polygon, (float(px), float(py)), measureDist=True) for px, py in seen)
    if true <= -RESOLUTION:
        assert found < 0.5 * RESOLUTION + 0.02, "it touches"
    else:
        assert found <= true + 1.5 * RESOLUTION
        if found < body.circumscribed_m:
            assert found >= min(true, 0.5) - 1.5 * RESOLUTION - (body.circumscribed_m - body.inscribed_m)
    if found < 0.5 * RESOLUTION:
        assert true < 1.5 * RESOLUTION, "it touches nothing that is a cell and a half away"

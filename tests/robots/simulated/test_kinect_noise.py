"""The Kinect's noise on pictures whose depth is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.robots.simulated.kinect_noise import KinectNoise, camera_model
from app.robots.stream_config import KinectConfig

CONFIG = KinectConfig()
SHAPE = (CONFIG.height, CONFIG.width)
NOISE = KinectNoise(CONFIG, np.random.default_rng(5))


def measure(depth_m: NDArray[np.float32], noise: KinectNoise = NOISE) -> NDArray[np.uint16]:
    out = np.zeros(SHAPE, dtype=np.uint16)
    noise.depth((1.0 / depth_m).astype(np.float32), out)
    return out


def flat(depth_m: float) -> NDArray[np.float32]:
    return np.full(SHAPE, depth_m, dtype=np.float32)


def test_the_field_of_view_is_57_by_43_degrees() -> None:
    camera = camera_model(CONFIG)
    assert math.degrees(2 * math.atan(320 / camera.fx)) == pytest.approx(57)
    assert math.degrees(2 * math.atan(240 / camera.fy)) == pytest.approx(43)


@given(st.floats(0.5, 4.7))
def test_depth_is_true_on_average_and_its_noise_grows_as_published(depth_m: float) -> None:
    measured = measure(flat(depth_m)).astype(float) / 1000
    seen = measured[measured > 0]
    assert seen.size > 0.9 * measured.size
    published = 0.0012 + 0.0019 * (depth_m - 0.4) ** 2
    step = CONFIG.quantum_m * depth_m**2
    assert seen.mean() == pytest.approx(depth_m, abs=0.1 * step + 0.001)
    # Sheppard's correction, up to what it leaves out where a step is as wide as the noise.
    expected = math.hypot(published, step / math.sqrt(12))
    assert seen.std() == pytest.approx(expected, rel=0.2, abs=0.3 * step)


def test_depths_come_in_steps_that_grow_with_the_square() -> None:
    steps_at = {z: np.diff(np.unique(measure(flat(z))[measure(flat(z)) > 0])).min() / 1000 for z in (1.0, 4.0)}
    assert steps_at[1.0] == pytest.approx(CONFIG.quantum_m, abs=0.001)
    assert steps_at[4.0] == pytest.approx(16 * CONFIG.quantum_m, rel=0.15)


@pytest.mark.parametrize("depth_m", [0.1, 0.35, 5.6, 40.0])
def test_out_of_range_is_no_measurement(depth_m: float) -> None:
    assert (measure(flat(depth_m)) == 0).mean() > 0.99


def test_a_near_thing_casts_a_shadow_beside_it_and_has_ragged_edges() -> None:
    scene = flat(3.0)
    scene[100:380, 300:400] = 1.0
    holes = measure(scene) == 0
    shadow_px = camera_model(CONFIG).fx * CONFIG.baseline_m * (1 / 1.0 - 1 / 3.0)
    left_of_it = holes[200:300, 200:300].sum(axis=1)
    assert left_of_it.mean() == pytest.approx(shadow_px, abs=4)
    assert holes[200:300, 410:].mean() < 0.01
    assert holes[98:102, 320:380].any(axis=0).mean() > 0.5
    assert holes[150:330, 310:390].mean() < 0.01


def test_a_floor_seen_at_a_slant_is_no_edge() -> None:
    rows = np.arange(CONFIG.height, dtype=np.float32)[:, None] - 239.5
    camera = camera_model(CONFIG)
    depth = np.where(rows > 60, 1.38 * camera.fy / np.maximum(rows, 1), 100.0) + np.zeros(SHAPE)
    holes = measure(depth.astype(np.float32))[430:] == 0  # nearer than 4.5 m
    assert holes.mean() < 0.01


def test_color_noise_is_slight_and_never_wraps_around() -> None:
    for level in (0, 128, 255):
        picture = np.full((*SHAPE, 3), level, dtype=np.uint8)
        out = np.zeros_like(picture)
        NOISE.color(picture, out)
        error = out.astype(float) - level
        assert np.abs(error).max() < 15
        if level == 128:
            assert abs(error.mean()) < 0.1
            assert error.std() == pytest.approx(CONFIG.color_noise, rel=0.1)


def test_each_picture_has_other_noise_and_the_same_seed_the_same() -> None:
    first, second = (KinectNoise(CONFIG, np.random.default_rng(9)) for _ in range(2))
    a, b = measure(flat(2.0), first), measure(flat(2.0), first)
    assert not np.array_equal(a, b)
    np.testing.assert_array_equal(a, measure(flat(2.0), second))

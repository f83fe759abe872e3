from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.modules.perception.landmark_map import LandmarkMap, SightingModel

FREE = SightingModel(floor_m=1e-9, per_m2=0.01)
NEAR = st.floats(-0.3, 0.3)
SIGHTINGS = st.lists(st.tuples(NEAR, NEAR, NEAR, st.floats(0.5, 5.0)), min_size=1, max_size=20)


@given(SIGHTINGS)
def test_without_a_floor_it_is_the_mean_weighted_by_precision(
    sightings: list[tuple[float, float, float, float]],
) -> None:
    known = LandmarkMap(FREE, gate_m=10.0)
    for stamp, (x, y, z, range_m) in enumerate(sightings):
        known.see(float(stamp), "a", (x, y, z), range_m)
    (landmark,) = known.landmarks
    weights = np.array([1 / FREE.sigma_m(s[3]) ** 2 for s in sightings])
    mean = (weights[:, None] * np.array([s[:3] for s in sightings])).sum(axis=0) / weights.sum()
    np.testing.assert_allclose(landmark.p_FQ, mean, atol=1e-9)
    assert landmark.sigma_m == pytest.approx(1 / math.sqrt(weights.sum()), rel=1e-6)
    assert landmark.sightings == len(sightings)
    assert (landmark.first_seen, landmark.last_seen) == (0.0, len(sightings) - 1.0)


@given(SIGHTINGS)
def test_a_landmark_stays_among_its_sightings_and_its_sigma_above_the_floor(
    sightings: list[tuple[float, float, float, float]],
) -> None:
    known = LandmarkMap(gate_m=10.0)
    before = math.inf
    for x, y, z, range_m in sightings:
        landmark = known.see(0.0, "a", (x, y, z), range_m)
        assert 0.02 <= landmark.sigma_m <= before
        before = landmark.sigma_m
    for axis in range(3):
        seen = [s[axis] for s in sightings]
        assert min(seen) - 1e-9 <= landmark.p_FQ[axis] <= max(seen) + 1e-9


def test_a_near_sighting_outweighs_a_far_one() -> None:
    known = LandmarkMap()
    known.see(0.0, "a", (4.0, 0.0, 1.0), 4.0)
    landmark = known.see(1.0, "a", (4.2, 0.0, 1.0), 1.0)
    assert landmark.p_FQ[0] > 4.18


def test_a_landmark_can_follow_drift_for_ever() -> None:
    known = LandmarkMap()
    for i in range(1000):
        known.see(float(i), "a", (1.0, 0.0, 1.0), 1.0)
    for i in range(50):
        known.see(1000.0 + i, "a", (1.3, 0.0, 1.0), 1.0)
    (landmark,) = known.landmarks
    assert landmark.p_FQ[0] == pytest.approx(1.3, abs=0.01)


def test_the_same_text_in_two_places_is_two_landmarks_in_the_order_seen() -> None:
    known = LandmarkMap(gate_m=1.0)
    known.see(0.0, "exit", (0.0, 0.0, 1.0), 1.0)
    known.see(1.0, "exit", (5.0, 0.0, 1.0), 1.0)
    known.see(2.0, "stop", (0.0, 0.0, 1.0), 1.0)
    known.see(3.0, "exit", (5.1, 0.0, 1.0), 1.0)
    known.see(4.0, "exit", (0.1, 0.0, 1.0), 1.0)
    assert [(m.text, m.sightings, round(m.p_FQ[0])) for m in known.landmarks] == [
        ("exit", 2, 0),
        ("exit", 2, 5),
        ("stop", 1, 0),
    ]


@given(st.lists(st.tuples(st.sampled_from("ab"), st.sampled_from((0.0, 3.0, 6.0)), NEAR), max_size=40))
def test_each_sighting_counts_once_and_each_place_has_one_landmark(seen: list[tuple[str, float, float]]) -> None:
    known = LandmarkMap(gate_m=1.0)
    for text, place, off in seen:
        known.see(0.0, text, (place + off, 0.0, 0.0), 1.0)
    assert sum(m.sightings for m in known.landmarks) == len(seen)
    assert len(known.landmarks) == len({(text, place) for text, place, _ in seen})

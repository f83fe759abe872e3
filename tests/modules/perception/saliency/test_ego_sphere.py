"""The sphere: peaks where something was, that fade, are inhibited and come back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import unit_vector
from app.modules.perception.saliency.ego_sphere import EgoSphere, Peak, SphereRules
from app.modules.perception.saliency.sphere_grid import SphereGrid
from app.modules.saliency_gains import FEATURES

ALL = dict.fromkeys(FEATURES, 1.0)
WIDE = math.radians(5)
ANGLE = st.floats(-math.pi, math.pi)
UP = st.floats(-0.6, 0.6)


def sphere(**rules: float) -> EgoSphere:
    made = EgoSphere(SphereGrid(), SphereRules(**rules))
    made.fade(0.0)
    return made


def off(peak: Peak, azimuth: float, elevation: float) -> float:
    """Angle (rad) between a peak and a direction."""
    cosine = float(unit_vector(peak.azimuth, peak.elevation) @ unit_vector(azimuth, elevation))
    return math.acos(min(1.0, cosine))


@given(ANGLE, UP)
def test_a_percept_is_a_peak_in_its_direction_within_a_degree(azimuth: float, elevation: float) -> None:
    s = sphere()
    s.add_percept("faces", unit_vector(azimuth, elevation), 1.0, WIDE)
    (peak,) = s.peaks(ALL)
    assert off(peak, azimuth, elevation) < math.radians(1)
    assert peak.shares["faces"] == pytest.approx(peak.saliency)


def test_an_empty_sphere_has_no_peak() -> None:
    assert sphere().peaks(ALL) == ()


def test_the_three_most_salient_come_in_order_and_not_one_of_them_twice() -> None:
    s = sphere()
    for azimuth, strength in ((0.0, 0.5), (1.5, 0.9), (-1.5, 0.7), (3.1, 0.3)):
        s.add_percept("sounds", unit_vector(azimuth, 0.1), strength, WIDE)
    peaks = s.peaks(ALL)
    assert [round(peak.azimuth, 1) for peak in peaks] == [1.5, -1.5, 0.0]
    assert [peak.saliency for peak in peaks] == sorted((peak.saliency for peak in peaks), reverse=True)


@given(st.lists(st.tuples(ANGLE, UP, st.floats(0.3, 1)), min_size=2, max_size=8))
@settings(max_examples=30)
def test_peaks_are_apart(percepts: list[tuple[float, float, float]]) -> None:
    s = sphere()
    for azimuth, elevation, strength in percepts:
        s.add_percept("sounds", unit_vector(azimuth, elevation), strength, WIDE)
    peaks = s.peaks(ALL)
    for i, peak in enumerate(peaks):
        for other in peaks[:i]:  # two cells less, for a peak's place is finer than its cell
            assert off(peak, other.azimuth, other.elevation) > s.rules.apart_rad - 2 * s.grid.step_rad


@given(st.floats(0, 5), st.sampled_from(FEATURES))
def test_gains_scale_saliency_and_its_shares(gain: float, feature: str) -> None:
    s = sphere()
    s.add_percept("motion", unit_vector(0.5, 0), 0.8, WIDE)
    s.add_percept(feature, unit_vector(0.5, 0), 0.6, WIDE)
    one, scaled = s.saliency(ALL), s.saliency(dict.fromkeys(FEATURES, gain))
    assert scaled == pytest.approx(gain * one, abs=1e-5)
    for peak in s.peaks({**ALL, feature: gain}):
        assert sum(peak.shares.values()) == pytest.approx(peak.saliency, abs=1e-5)


def test_a_gain_decides_which_of_two_is_the_most_salient() -> None:
    s = sphere()
    s.add_percept("faces", unit_vector(1.0, 0.2), 0.6, WIDE)
    s.add_percept("sounds", unit_vector(-1.0, 0.2), 0.5, WIDE)
    assert s.peaks(ALL)[0].azimuth > 0
    assert s.peaks({**ALL, "sounds": 2.0})[0].azimuth < 0
    assert len(s.peaks({"sounds": 1.0})) == 1


def test_what_was_perceived_fades_and_the_greater_value_counts() -> None:
    s = sphere(decay_s=1.0)
    s.add_percept("faces", unit_vector(0, 0), 1.0, WIDE)
    before = s.peaks(ALL)[0].saliency
    s.fade(1.0)
    assert s.peaks(ALL)[0].saliency == pytest.approx(before / math.e, rel=1e-3)
    s.fade(0.5)
    assert s.peaks(ALL)[0].saliency == pytest.approx(before / math.e, rel=1e-3), "time does not go back"
    s.add_percept("faces", unit_vector(0, 0), 0.1, WIDE)
    assert s.peaks(ALL)[0].saliency == pytest.approx(before / math.e, rel=1e-3)
    s.add_percept("faces", unit_vector(0, 0), 1.0, WIDE)
    assert s.peaks(ALL)[0].saliency == pytest.approx(before, rel=1e-3)


@given(ANGLE, st.floats(0.5, 20))
@settings(max_examples=30)
def test_an_inhibited_peak_leaves_its_place_to_the_next_and_comes_back(azimuth: float, recovery_s: float) -> None:
    s = sphere(recovery_s=recovery_s)
    there, beside = unit_vector(azimuth, 0.0), unit_vector(azimuth + 1.5, 0.0)

    def seen(now: float) -> tuple[Peak, ...]:
        s.fade(now)
        s.add_percept("motion", there, 1.0, WIDE)
        s.add_percept("motion", beside, 0.6, WIDE)
        return s.peaks(ALL)

    first = seen(1.0)[0]
    assert off(first, azimuth, 0.0) < 0.05
    s.inhibit(there)
    after = seen(1.0)
    assert off(after[0], azimuth + 1.5, 0.0) < 0.05
    back = seen(1.0 + 2 * recovery_s)[0]
    assert off(back, azimuth, 0.0) < 0.05
    assert first.saliency * (1 - math.exp(-2)) * 0.95 < back.saliency < first.saliency


def test_the_picture_all_around_has_no_seam_behind() -> None:
    s = sphere()
    values = np.zeros((s.grid.rows, s.grid.columns), np.float32)
    values[14:18, :2] = values[14:18, -2:] = 1.0
    s.add("motion", values)
    (peak,) = s.peaks(ALL)
    assert abs(abs(peak.azimuth) - math.pi) < math.radians(1)

"""Arrival times of sound by direction, round a body too, and the directions that are searched."""

from __future__ import annotations

import numpy as np

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND, arrivals, search_grid, tangents
from app.robots.stream_config import MicrophonesConfig

ARRAY = MicrophoneArray(np.array(MicrophonesConfig().positions))


def test_a_grid_has_what_an_array_can_report() -> None:
    assert (search_grid(ARRAY, 2000, -20)[:, 2] > np.sin(np.radians(-20))).all()
    flat = MicrophoneArray(ARRAY.positions[:4])
    assert (search_grid(flat, 2000, -90)[:, 2] >= -1e-9).all()
    line = search_grid(ARRAY.subset(2), 2000, -20)
    np.testing.assert_allclose(line[:, 2], 0, atol=1e-9)
    assert (line[:, 0] >= -1e-9).all()


def test_round_a_body_the_way_is_longer_only_in_its_shadow() -> None:
    directions = search_grid(ARRAY, 500, -90)
    radius = float(np.linalg.norm(ARRAY.offsets[0]))
    straight = arrivals(ARRAY.offsets, directions, 2.0)
    around = arrivals(ARRAY.offsets, directions, 2.0, radius)
    facing = directions @ (ARRAY.offsets / radius).T
    assert (around >= straight - 1e-12).all()
    np.testing.assert_allclose(around[facing > 0.2], straight[facing > 0.2])
    assert (around[facing < -0.2] > straight[facing < -0.2]).all()
    assert float((around - straight).max()) < radius * (np.pi / 2) / SPEED_OF_SOUND


def test_tangents_are_at_right_angles() -> None:
    directions = search_grid(ARRAY, 300, -90)
    basis = tangents(directions)
    np.testing.assert_allclose(basis @ basis.transpose(0, 2, 1), np.broadcast_to(np.eye(2), (300, 2, 2)), atol=1e-12)
    np.testing.assert_allclose((basis @ directions[:, :, None])[:, :, 0], 0, atol=1e-12)

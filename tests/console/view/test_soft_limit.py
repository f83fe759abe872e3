"""The fan of the soft limit: its shape, and what a viewer is sent of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.console.view.soft_limit import FAN_M, PAST, WITHIN, SoftLimitFan, edge, surface
from tests.console.view.viewer_client import Client

SURFACE, EDGE = "/base_link/soft_limit/surface", "/base_link/soft_limit/edge"


@pytest.mark.parametrize("degrees", [10, 30, 60])
def test_its_surface_is_the_sector_to_both_sides(degrees: int) -> None:
    angle = math.radians(degrees)
    vertices, faces = surface(angle)
    corners = vertices[faces].astype(float)
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert areas.sum() == pytest.approx(angle * FAN_M**2, rel=0.01)
    azimuths = np.arctan2(vertices[1:, 1], vertices[1:, 0])
    assert (azimuths.min(), azimuths.max()) == pytest.approx((-angle, angle))
    outline, around = edge(angle)
    assert around.max() == len(outline) - 1
    assert np.hypot(*outline[:, :2].T).max() == pytest.approx(FAN_M, abs=0.05)


def test_a_viewer_sees_it_filled_more_while_the_head_looks_past_it() -> None:
    client = Client()
    fan = SoftLimitFan(client, "/base_link")  # type: ignore[arg-type]
    assert fan.draw(None, 0.0) == 0
    assert not client.nodes
    assert fan.draw(0.5, 0.2) == 1
    assert client.nodes[SURFACE].opacity == WITHIN
    assert fan.draw(0.5, 0.3) == 0
    assert fan.draw(0.5, -0.6) == 1
    assert client.nodes[SURFACE].opacity == PAST
    assert fan.draw(1.0, -0.6) == 1
    assert client.nodes[SURFACE].opacity == WITHIN
    assert client.nodes[SURFACE].vertices[:, 1].max() == pytest.approx(FAN_M * math.sin(1.0))
    assert fan.draw(None, 0.0) == 1
    assert {client.nodes[name].visible for name in (SURFACE, EDGE)} == {False}
    assert fan.draw(1.0, 0.0) == 1
    assert {client.nodes[name].visible for name in (SURFACE, EDGE)} == {True}

"""Culling in the renderer: by walls and bounding spheres, without loss of any visible shape."""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose3
from app.robots.simulated.camera_rendering import ChangeDetector
from app.robots.simulated.occlusion import Occlusion
from app.robots.simulated.renderer import PerspectiveView, Renderer, WorldSnapshot
from tests.robots.conftest import needs_gl

AHEAD = PerspectiveView(np.eye(3), -1.0, right=1.0, bottom=-0.75, top=0.75, width=64, height=48)
#: Two rooms of 6 x 6 m under one ceiling; in the wall between them, at x = 0, a gap of 1 m from y = 1 to 2.
ROOMS = """
<mujoco>
  <worldbody>
    <geom name="south" type="box" pos="0 -1 1.25" size="0.05 2 1.25"/>
    <geom name="north" type="box" pos="0 2.5 1.25" size="0.05 0.5 1.25"/>
    <geom name="counter" type="box" pos="-1 0 0.5" size="0.05 1 0.5" group="2"/>
    <geom name="floor" type="plane" size="6 6 1"/>
    <geom name="ceiling" type="plane" pos="0 0 2.5" size="6 6 1" quat="0 1 0 0"/>
    <body pos="-2 0 1"><joint name="slide" type="slide" axis="0 1 0"/>
      <geom type="box" size="0.01 0.01 0.01" mass="1" group="3"/>
      <camera name="eye" quat="0.5 0.5 -0.5 -0.5"/>
    </body>
    <body name="near" mocap="true" pos="-0.7 0.2 1"><geom name="near" type="sphere" size="0.2" group="1"/></body>
    <body name="far" mocap="true" pos="2 0.2 1"><geom name="far" type="sphere" size="0.2" group="1"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(ROOMS)


@pytest.fixture
def renderer(model: mujoco.MjModel) -> Iterator[Renderer]:
    renderer = Renderer(model)
    yield renderer
    renderer.close()


def after(snapshot: WorldSnapshot, body: int, y: float, slide: float = 0.0) -> WorldSnapshot:
    """``snapshot`` with a scripted body at ``y`` and the camera moved by ``slide``."""
    mocap = snapshot.mocap.copy()
    mocap[body, 1] = y
    return WorldSnapshot(1.0, snapshot.qpos + slide, mocap, Pose3.identity())


@needs_gl
def test_a_picture_is_drawn_again_only_where_something_that_may_be_seen_has_moved(
    model: mujoco.MjModel, renderer: Renderer
) -> None:
    near, far = 0, 1
    start = WorldSnapshot.initial(model)
    watch = ChangeDetector(renderer, 0, AHEAD)
    assert watch.changed(start)
    assert not watch.changed(after(start, far, -0.5))  # behind the wall
    assert watch.changed(after(start, near, 0.25))
    assert watch.changed(start)
    assert not watch.changed(after(start, near, 0.2 + 1e-6))
    assert watch.changed(after(start, near, 0.2, slide=0.01))
    # Out of sight, from where he was seen; then about behind the wall; then in the gap of it
    assert watch.changed(after(start, near, 20.0))
    gone = after(start, near, 20.0)
    behind, in_the_gap = after(gone, far, 0.0), after(gone, far, 2.9)
    assert not watch.changed(behind)
    assert watch.changed(in_the_gap)
    assert not watch.changed(after(gone, far, 2.9))
    assert watch.changed(behind)


@needs_gl
def test_creeping_is_noticed_in_the_end(model: mujoco.MjModel, renderer: Renderer) -> None:
    start = WorldSnapshot.initial(model)
    watch = ChangeDetector(renderer, 0, AHEAD)
    watch.changed(start)
    assert any(watch.changed(after(start, 0, 0.2, slide=i * 3e-5)) for i in range(5))


@needs_gl
def test_what_is_hidden_would_not_have_shown(model: mujoco.MjModel, renderer: Renderer) -> None:
    color = np.zeros((48, 64, 3), np.uint8)
    start = WorldSnapshot.initial(model)
    renderer.draw(start, 0, AHEAD)
    renderer.read(AHEAD, color)
    with_far = color.copy()
    renderer.draw(after(start, 1, -20.0), 0, AHEAD)
    renderer.read(AHEAD, color)
    np.testing.assert_array_equal(color, with_far)


def cut(eye: np.ndarray, point: np.ndarray, wall: tuple[float, float]) -> bool:
    """Whether the wall at x = 0 from y = ``wall[0]`` to ``wall[1]`` is between ``eye`` and ``point``."""
    if (eye[0] < 0) == (point[0] < 0):
        return False
    share = eye[0] / (eye[0] - point[0])
    return bool(wall[0] <= eye[1] + share * (point[1] - eye[1]) <= wall[1])


@settings(max_examples=200, deadline=None)
@given(
    eye=st.tuples(st.floats(-5, -0.2), st.floats(-3, 3), st.floats(0.1, 2.4)),
    center=st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(0.2, 2.3)),
)
def test_nothing_is_called_hidden_of_which_a_part_can_be_seen(
    eye: tuple[float, float, float], center: tuple[float, float, float]
) -> None:
    model = mujoco.MjModel.from_xml_string(ROOMS)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    centers = data.geom_xpos.copy()
    ball = model.geom("far").id
    centers[ball] = center
    hidden = Occlusion(model, data).hidden(np.array(eye), centers)
    assert not hidden[[model.geom(name).id for name in ("floor", "ceiling", "counter")]].any()
    around = np.linspace(0, 2 * math.pi, 60)
    rim = np.array(center)[:2] + 0.2 * np.column_stack([np.cos(around), np.sin(around)])
    seen = [not (cut(np.array(eye), p, (-3, 1)) or cut(np.array(eye), p, (2, 3))) for p in rim]
    if hidden[ball]:
        assert not any(seen)


def test_what_stands_behind_a_wall_is_hidden_and_what_stands_in_its_gap_is_not(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    occlusion = Occlusion(model, data)
    far = model.geom("far").id
    centers = data.geom_xpos.copy()
    assert occlusion.hidden(np.array([-2.0, 0.0, 1.0]), centers)[far]
    centers[far] = (2.0, 2.9, 1.0)
    assert not occlusion.hidden(np.array([-2.0, 0.0, 1.0]), centers)[far]


def test_without_a_ceiling_one_looks_over_walls() -> None:
    model = mujoco.MjModel.from_xml_string(ROOMS.replace('name="ceiling"', 'name="roof"'))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    assert not Occlusion(model, data).hidden(np.array([-2.0, 0.0, 1.0]), data.geom_xpos).any()

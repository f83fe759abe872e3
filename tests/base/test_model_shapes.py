"""What a model file says that a robot looks like."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh

from app.base import paths
from app.base.model_shapes import visual_shapes

MODEL = """<robot name="sketch">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base">
    <visual><origin xyz="1 0 0"/><geometry><box size="2 4 6"/></geometry><material name="red"/></visual>
    <visual>
      <origin rpy="0 {right} 0"/><geometry><cylinder radius="0.1" length="2"/></geometry>
      <material name="blue"><color rgba="0 0 1 0.5"/></material>
    </visual>
    <collision><geometry><sphere radius="9"/></geometry></collision>
  </link>
  <link name="head">
    <visual><geometry><sphere radius="0.5"/></geometry><material name="blue"/></visual>
    {more}
  </link>
  <joint name="neck" type="fixed"><parent link="base"/><child link="head"/></joint>
</robot>
"""


def model(folder: Path, more: str = "") -> Path:
    path = folder / "sketch.urdf"
    path.write_text(MODEL.format(right=math.pi / 2, more=more))
    return path


def part(folder: Path) -> None:
    """An STL file of a box, 1 m wide."""
    folder.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box(extents=(1, 1, 1)).export(folder / "part.stl")


def test_shapes_are_in_their_links_frame_with_their_colour(tmp_path: Path) -> None:
    box, cylinder, sphere = visual_shapes(model(tmp_path))
    assert (box.link, box.color) == ("base", (255, 0, 0))
    np.testing.assert_allclose(box.mesh.bounds, [[0, -2, -3], [2, 2, 3]])
    assert (cylinder.link, cylinder.color) == ("base", (0, 0, 255))
    np.testing.assert_allclose(cylinder.mesh.bounds, [[-1, -0.1, -0.1], [1, 0.1, 0.1]], atol=1e-9)
    assert (sphere.link, sphere.color) == ("head", (0, 0, 255)), "a material is known wherever it was described"
    np.testing.assert_allclose(sphere.mesh.bounds, [[-0.5] * 3, [0.5] * 3], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "where"),
    [
        ("part.stl", "."),
        ("meshes/part.stl", "meshes"),
        ("package://sketch_description/meshes/part.stl", "../meshes"),
        ("package://sketch_description/meshes/part.stl", "../../sketch_description/meshes"),
    ],
)
def test_a_mesh_is_found_and_scaled(name: str, where: str, tmp_path: Path) -> None:
    folder = tmp_path / "packages" / "sketch_description" / "urdf"
    folder.mkdir(parents=True)
    part(folder / where)
    more = f'<visual><geometry><mesh filename="{name}" scale="2 4 6"/></geometry></visual>'
    *_, shape = visual_shapes(model(folder, more))
    assert shape.link == "head"
    np.testing.assert_allclose(shape.mesh.bounds, [[-1, -2, -3], [1, 2, 3]])


def test_a_mesh_keeps_its_own_colour_unless_the_model_names_one(tmp_path: Path) -> None:
    material = trimesh.visual.material.PBRMaterial(baseColorFactor=[0, 255, 0, 255])
    textured = trimesh.visual.TextureVisuals(material=material)
    trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)], visual=textured).export(tmp_path / "part.glb")
    mesh = '<geometry><mesh filename="part.glb"/></geometry>'
    more = f'<visual>{mesh}</visual><visual>{mesh}<material name="red"/></visual>'
    assert [shape.color for shape in visual_shapes(model(tmp_path, more))][3:] == [(0, 255, 0), (255, 0, 0)]


def test_a_mirrored_mesh_keeps_its_outside(tmp_path: Path) -> None:
    part(tmp_path)
    more = '<visual><geometry><mesh filename="part.stl" scale="1 -1 1"/></geometry></visual>'
    *_, shape = visual_shapes(model(tmp_path, more))
    assert shape.mesh.volume == pytest.approx(1.0)


@pytest.mark.parametrize("name", ["gone.stl", "package://sketch_description/meshes/gone.stl"])
def test_a_mesh_that_is_not_there_is_said(name: str, tmp_path: Path) -> None:
    more = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    with pytest.raises((OSError, ValueError), match=r"gone\.stl"):
        visual_shapes(model(tmp_path, more))


def test_a_kind_of_file_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    (tmp_path / "part.what").write_text("?")
    more = '<visual><geometry><mesh filename="part.what"/></geometry></visual>'
    with pytest.raises(ValueError, match=r"part\.what cannot be read.*STL"):
        visual_shapes(model(tmp_path, more))


@pytest.mark.parametrize("path", sorted((paths.config_dir() / "robots").glob("*.urdf")), ids=lambda path: path.stem)
def test_every_body_of_the_project_can_be_drawn(path: Path) -> None:
    shapes = visual_shapes(path)
    assert shapes
    assert all(np.isfinite(shape.mesh.vertices).all() for shape in shapes)

"""A model of others becomes a body: what is kept, what is measured, what is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.base.kinematic_model import load_model
from app.base.model_shapes import visual_shapes
from app.maps.map_file import read_map
from app.robots.importing.body_folder import ImportedBody, import_body
from app.robots.simulated.kinematic.config import load_kinematic_config
from tests.robots.importing.models import write_mjcf, write_urdf


@pytest.fixture
def wheeled(tmp_path: Path) -> ImportedBody:
    return import_body(write_urdf(tmp_path), tmp_path / "out")


@pytest.fixture
def arm(tmp_path: Path) -> ImportedBody:
    return import_body(write_mjcf(tmp_path), tmp_path / "out")


def test_the_body_can_be_run_at_once(wheeled: ImportedBody) -> None:
    config = load_kinematic_config(wheeled.file)
    assert config.name == "Wheeled Arm"
    assert config.laser is not None
    assert config.laser.link == "base_laser"
    assert [joint.name for joint in config.groups["arm"].joints] == ["arm_1_joint", "arm_2_joint"]
    assert config.actuators["arm"].velocity == 0.5
    cells = read_map(config.map).cells
    assert set(np.unique(cells)) == {0, 100}


def test_its_outline_is_that_of_the_base_and_its_wheels(wheeled: ImportedBody) -> None:
    corners = np.array(wheeled.footprint)
    assert corners[:, 0].max() == pytest.approx(0.2, abs=0.02)  # not the arm's 1.05
    assert corners[:, 1].max() == pytest.approx(0.22, abs=0.02)
    assert wheeled.height_m == pytest.approx(0.25, abs=0.01)


def test_meshes_are_beside_it_and_what_cannot_be_read_is_said(wheeled: ImportedBody) -> None:
    folder = wheeled.file.parent
    assert [path.name for path in (folder / "meshes").iterdir()] == ["hand.stl"]
    assert {shape.link for shape in visual_shapes(folder / "robot.urdf")} == {"base", "left_wheel", "arm_1", "arm_2"}
    remarks = "\n".join(wheeled.remarks)
    assert "lamp.step: is .step; .stl, .obj, .ply, .glb, .dae can be read; its shape is left out." in remarks
    assert "lost.stl: was not found; its shape is left out." in remarks
    assert "joint lamp_joint: of type floating, taken as fixed." in remarks
    assert "<gazebo" not in (folder / "robot.urdf").read_text("utf-8")


def test_collada_becomes_what_the_page_reads(tmp_path: Path) -> None:
    collada = pytest.importorskip("collada", reason="the extra 'models' is not installed")
    path = write_urdf(tmp_path)
    path.write_text(path.read_text("utf-8").replace("hand.stl", "hand.dae"), "utf-8")
    write_triangle(collada, path.parents[1] / "meshes" / "hand.dae")
    body = import_body(path, tmp_path / "out")
    assert [mesh.name for mesh in (tmp_path / "out" / "meshes").iterdir()] == ["hand.glb"]
    (hand,) = (shape for shape in visual_shapes(body.file.parent / "robot.urdf") if shape.link == "arm_2")
    assert len(hand.mesh.faces) == 1


@pytest.mark.parametrize("name", ["irl1_tr", "jackal", "turtlebot4"])
def test_a_model_of_ours_comes_out_as_it_went_in(name: str, tmp_path: Path) -> None:
    path = paths.config_dir() / "robots" / f"{name}.urdf"
    before = load_model(path)
    body = import_body(path, tmp_path / "out")
    after = load_model(body.file.parent / "robot.urdf")
    rng = np.random.default_rng(1)
    positions = {joint: float(rng.uniform(-0.5, 0.5)) for joint in before.joint_names}
    raised = float(after.pose(before.root).translation[2])
    for link in before.links:
        expected, found = before.pose(link, positions), after.pose(link, positions)
        assert np.allclose(found.translation, expected.translation + np.array([0.0, 0.0, raised]), atol=1e-6)
        assert np.allclose(found.rotation, expected.rotation)


def test_every_body_of_a_mujoco_model_is_where_mujoco_has_it(arm: ImportedBody, tmp_path: Path) -> None:
    model = load_model(arm.file.parent / "robot.urdf")
    source = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    data = mujoco.MjData(source)
    rng = np.random.default_rng(2)
    for _ in range(20):
        positions = {"yaw": rng.uniform(-1, 1), "pitch": rng.uniform(-1, 1), "reach": rng.uniform(0, 0.2)}
        for joint, value in {**positions, "thumb_joint": 0.1 + 0.5 * positions["pitch"]}.items():
            data.joint(joint).qpos[0] = value
        mujoco.mj_kinematics(source, data)
        X_WB = model.pose("base")
        for name in ("shoulder", "hand", "thumb", "tip"):
            pose = model.pose(name, positions)
            apart = data.body(name).xpos - data.body("base").xpos
            assert np.allclose(pose.translation - X_WB.translation, apart, atol=1e-6), name
            assert np.allclose(pose.rotation, data.body(name).xmat.reshape(3, 3), atol=1e-6), name


def test_the_shapes_of_a_mujoco_model_are_kept(arm: ImportedBody) -> None:
    shapes = visual_shapes(arm.file.parent / "robot.urdf")
    assert {shape.link for shape in shapes} == {"base", "shoulder", "hand", "thumb", "tip"}
    assert [shape.color for shape in shapes if shape.link == "base"] == [(0, 255, 0)]  # its cylinder is for collisions
    assert sum(shape.link == "shoulder" for shape in shapes) == 3  # a capsule: a cylinder between two spheres
    assert "body base was taken; beside it there are ball." in arm.remarks
    assert "body tip: it floats or turns in a ball joint; taken as fixed." in arm.remarks
    assert arm.groups == {"yaw": ("yaw", "pitch", "reach")}


def test_it_stands_on_the_floor(arm: ImportedBody) -> None:
    model = load_model(arm.file.parent / "robot.urdf")
    lowest = min(
        float(model.pose(shape.link).transform(np.asarray(shape.mesh.vertices, np.float64))[:, 2].min())
        for shape in visual_shapes(arm.file.parent / "robot.urdf")
    )
    assert model.root == "floor_link"
    assert lowest == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<robot", "is no XML"),
        ("<sdf/>", "is no URDF: it begins with <sdf>"),
        ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property/></robot>', "is xacro, which ROS makes"),
        ("<mujoco><nonsense/></mujoco>", "MuJoCo refuses it"),
        ("<mujoco/>", "has no body"),
        ('<robot name="a"><link name="b"/></robot>', "has no shape that can be read"),
        ('<robot name="a"><link name="b"/><link name="c"/></robot>', "its links must form one tree"),
    ],
)
def test_what_is_no_model_is_refused(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "model.urdf"
    path.write_text(text, "utf-8")
    with pytest.raises(ConfigError, match=said):
        import_body(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_that_exists_is_not_touched(tmp_path: Path) -> None:
    path = write_mjcf(tmp_path)
    (tmp_path / "out").mkdir()
    with pytest.raises(ConfigError, match="exists; name another folder"):
        import_body(path, tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []


def write_triangle(collada: Any, path: Path) -> None:
    document = collada.Collada()
    corners = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0], np.float32)
    source = collada.source.FloatSource("corners", corners, ("X", "Y", "Z"))
    geometry = collada.geometry.Geometry(document, "geometry", "triangle", [source])
    inputs = collada.source.InputList()
    inputs.addInput(0, "VERTEX", "#corners")
    geometry.primitives.append(geometry.createTriangleSet(np.array([0, 1, 2]), inputs, "plain"))
    document.geometries.append(geometry)
    node = collada.scene.Node("node", children=[collada.scene.GeometryNode(geometry, [])])
    document.scenes.append(collada.scene.Scene("scene", [node]))
    document.scene = document.scenes[0]
    with path.open("wb") as file:
        document.write(file)

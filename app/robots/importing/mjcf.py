"""A MuJoCo model (MJCF) made into a URDF: its bodies as links, its joints one by one, its shapes as they are compiled.

What URDF has no word for is simplified, and said: ball joints are fixed, ellipsoids are meshes, capsules are a cylinder
between two spheres. https://mujoco.readthedocs.io/en/stable/XMLreference.html
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.geometry import Pose3
from app.robots.importing.urdf import ImportedModel

_JOINTS = {int(mujoco.mjtJoint.mjJNT_HINGE): "revolute", int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic"}
#: Shapes of these groups and above are drawn by no viewer of MuJoCo unless it is asked to: they are for collisions.
_HIDDEN_GROUP = 3
_GEOM = mujoco.mjtGeom
_NO_LIMIT = 1e3


def read_mjcf(path: Path) -> ImportedModel:
    """The model of the MJCF file ``path``: its largest tree of bodies. Raises ConfigError for what MuJoCo refuses."""
    try:
        compiled = mujoco.MjModel.from_xml_path(str(path))
    except (ValueError, OSError) as failure:
        raise ConfigError(f"MuJoCo refuses it: {str(failure).strip()}", str(path)) from None
    return _Writer(compiled, path).model


class _Writer:
    def __init__(self, compiled: Any, path: Path) -> None:
        self._from = compiled
        self.model = ImportedModel(ElementTree.Element("robot", {"name": path.stem}))
        self._names = {body: self._name(mujoco.mjtObj.mjOBJ_BODY, body, "body") for body in range(compiled.nbody)}
        children: dict[int, list[int]] = {}
        for body in range(1, compiled.nbody):
            children.setdefault(int(compiled.body_parentid[body]), []).append(body)
        self._children = children
        roots = sorted(children.get(0, []), key=lambda body: -len(self._below(body)))
        if not roots:
            raise ConfigError("has no body", str(path))
        if len(roots) > 1:
            others = ", ".join(self._names[body] for body in roots[1:])
            self.model.remarks.append(f"body {self._names[roots[0]]} was taken; beside it there are {others}.")
        self._link(roots[0], None)
        self._mimic()

    def _name(self, kind: Any, number: int, otherwise: str) -> str:
        return mujoco.mj_id2name(self._from, kind, number) or f"{otherwise}_{number}"

    def _below(self, body: int) -> list[int]:
        return [body, *(each for child in self._children.get(body, []) for each in self._below(child))]

    def _link(self, body: int, parent: str | None) -> None:
        name = self._names[body]
        link = ElementTree.SubElement(self.model.robot, "link", {"name": name})
        for geom in range(self._from.ngeom):
            if self._from.geom_bodyid[geom] == body:
                self._shape(link, geom)
        if parent is not None:
            self._joints(body, parent)
        for child in self._children.get(body, []):
            self._link(child, name)

    def _joints(self, body: int, parent: str) -> None:
        """The joints between ``parent`` and ``body``, with a link without shapes between two of them."""
        source, name = self._from, self._names[body]
        X = _pose(source.body_pos[body], source.body_quat[body])
        first = int(source.body_jntadr[body])
        numbers = range(first, first + int(source.body_jntnum[body]))
        moving = [number for number in numbers if int(source.jnt_type[number]) in _JOINTS]
        if len(moving) < len(numbers):
            self.model.remarks.append(f"body {name}: it floats or turns in a ball joint; taken as fixed.")
        if not moving:
            self._joint(f"{name}_fixed", "fixed", (parent, name), X)
            return
        at = np.zeros(3)  # of the frame that the joints so far lead to, in the body
        for number in moving:
            p = np.array(source.jnt_pos[number], np.float64)
            between = f"{name}_by_{self._name(mujoco.mjtObj.mjOBJ_JOINT, number, 'joint')}"
            ElementTree.SubElement(self.model.robot, "link", {"name": between})
            joint = self._joint(
                self._name(mujoco.mjtObj.mjOBJ_JOINT, number, "joint"),
                self._kind(number),
                (parent, between),
                X @ Pose3(np.eye(3), p - at),
            )
            ElementTree.SubElement(joint, "axis", {"xyz": _text(source.jnt_axis[number])})
            ElementTree.SubElement(joint, "limit", self._limit(number))
            parent, X, at = between, Pose3.identity(), p
        self._joint(f"{name}_fixed", "fixed", (parent, name), Pose3(np.eye(3), -at))

    def _kind(self, number: int) -> str:
        kind = _JOINTS[int(self._from.jnt_type[number])]
        return "continuous" if kind == "revolute" and not self._from.jnt_limited[number] else kind

    def _limit(self, number: int) -> dict[str, str]:
        limits = {"effort": "0", "velocity": f"{_NO_LIMIT:g}"}
        if self._from.jnt_limited[number]:
            lower, upper = self._from.jnt_range[number]
            limits |= {"lower": f"{lower:.6g}", "upper": f"{upper:.6g}"}
        return limits

    def _joint(self, name: str, kind: str, ends: tuple[str, str], X_PJ: Pose3) -> ElementTree.Element:
        joint = ElementTree.SubElement(self.model.robot, "joint", {"name": name, "type": kind})
        ElementTree.SubElement(joint, "parent", {"link": ends[0]})
        ElementTree.SubElement(joint, "child", {"link": ends[1]})
        _origin(joint, X_PJ)
        return joint

    def _shape(self, link: ElementTree.Element, geom: int) -> None:
        source = self._from
        X = _pose(source.geom_pos[geom], source.geom_quat[geom])
        hidden = source.geom_group[geom] >= _HIDDEN_GROUP
        solid = bool(source.geom_contype[geom] or source.geom_conaffinity[geom])
        for kind in (*(() if hidden else ("visual",)), *(("collision",) if solid else ())):
            for placed, element in self._geometry(geom, X):
                shape = ElementTree.SubElement(link, kind)
                _origin(shape, placed)
                ElementTree.SubElement(shape, "geometry").append(element)
                if kind == "visual":
                    material = source.geom_matid[geom]
                    rgba = source.mat_rgba[material] if material >= 0 else source.geom_rgba[geom]
                    colored = ElementTree.SubElement(shape, "material", {"name": f"{link.get('name')}_{geom}"})
                    ElementTree.SubElement(colored, "color", {"rgba": _text(rgba)})

    def _geometry(self, geom: int, X: Pose3) -> list[tuple[Pose3, ElementTree.Element]]:
        """The elements of URDF that a geom is, each with its pose in the link."""
        kind, size = _GEOM(int(self._from.geom_type[geom])), [float(value) for value in self._from.geom_size[geom]]
        if kind == _GEOM.mjGEOM_BOX:
            return [(X, ElementTree.Element("box", {"size": _text(2 * np.array(size))}))]
        if kind == _GEOM.mjGEOM_SPHERE:
            return [(X, _sphere(size[0]))]
        if kind in (_GEOM.mjGEOM_CYLINDER, _GEOM.mjGEOM_CAPSULE):
            cylinder = ElementTree.Element("cylinder", {"radius": f"{size[0]:.6g}", "length": f"{2 * size[1]:.6g}"})
            if kind == _GEOM.mjGEOM_CYLINDER:
                return [(X, cylinder)]
            ends = [X @ Pose3(np.eye(3), np.array([0.0, 0.0, side * size[1]])) for side in (-1, 1)]
            return [(X, cylinder), *((end, _sphere(size[0])) for end in ends)]
        if kind == _GEOM.mjGEOM_ELLIPSOID:
            ball = trimesh.creation.icosphere(subdivisions=2)
            ball.vertices = np.asarray(ball.vertices) * size
            return [(X, self._mesh(f"ellipsoid_{geom}", ball))]
        if kind == _GEOM.mjGEOM_MESH:
            number = int(self._from.geom_dataid[geom])
            return [(X, self._mesh(self._name(mujoco.mjtObj.mjOBJ_MESH, number, "mesh"), self._vertices(number)))]
        return []

    def _vertices(self, number: int) -> trimesh.Trimesh:
        source = self._from
        at, count = source.mesh_vertadr[number], source.mesh_vertnum[number]
        face, faces = source.mesh_faceadr[number], source.mesh_facenum[number]
        vertices, triangles = source.mesh_vert[at : at + count], source.mesh_face[face : face + faces]
        return trimesh.Trimesh(vertices, triangles, process=False)

    def _mesh(self, name: str, mesh: trimesh.Trimesh) -> ElementTree.Element:
        file = "".join(c if c.isalnum() or c in "._-" else "_" for c in name) + ".stl"
        if file not in self.model.meshes:
            self.model.meshes[file] = trimesh.exchange.stl.export_stl(mesh)
        return ElementTree.Element("mesh", {"filename": f"meshes/{file}"})

    def _mimic(self) -> None:
        """Joints that follow another by an equality, linearly."""
        source = self._from
        joints = {joint.get("name"): joint for joint in self.model.robot.findall("joint")}
        for number in range(source.neq):
            if source.eq_type[number] != mujoco.mjtEq.mjEQ_JOINT or source.eq_obj2id[number] < 0:
                continue
            follower, led = (
                self._name(mujoco.mjtObj.mjOBJ_JOINT, int(ids[number]), "joint")
                for ids in (source.eq_obj1id, source.eq_obj2id)
            )
            offset, multiplier = (f"{value:.6g}" for value in source.eq_data[number][:2])
            if follower in joints and led in joints:
                values = {"joint": led, "multiplier": multiplier, "offset": offset}
                ElementTree.SubElement(joints[follower], "mimic", values)


def _sphere(radius: float) -> ElementTree.Element:
    return ElementTree.Element("sphere", {"radius": f"{radius:.6g}"})


def _origin(element: ElementTree.Element, pose: Pose3) -> None:
    ElementTree.SubElement(element, "origin", {"xyz": _text(pose.translation), "rpy": _text(_rpy(pose.rotation))})


def _pose(position: Any, quaternion: Any) -> Pose3:
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, quaternion)
    return Pose3(rotation.reshape(3, 3), np.array(position, np.float64))


def _rpy(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """Roll, pitch and yaw (rad) about fixed axes, as URDF takes them."""
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.hypot(R[0, 0], R[1, 0]) < 1e-9:
        return np.array([np.arctan2(-R[1, 2], R[1, 1]), pitch, 0.0])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def _text(values: Any) -> str:
    return " ".join(f"{float(value):.8g}" for value in values)

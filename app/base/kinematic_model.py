"""Kinematic model of a body: frames, joints and forward kinematics of a URDF file.

Shapes are read by the physics and the console. (A mesh library would read all of it, at one second of import time for
every start of the link.)
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.geometry import Pose3
from app.base.plain_file import open_plain

MOVING_TYPES = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint's position (rad or m) is ``multiplier`` times that of ``joint``, plus ``offset`` (rad or m)."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One joint: ``X_PJ`` is its frame in the parent link at position 0; ``axis`` (3,) a unit vector in that frame.

    ``lower`` and ``upper`` bound its position (rad or m), ``velocity`` its speed (rad/s or m/s); infinite where the
    file says none. ``effort`` bounds its torque or force (N m or N; 0 where the file says none). ``damping`` is its
    own resistance (N m s/rad or N s/m). ``mimic``: the joint that it follows, if it does.
    """

    name: str
    kind: str
    parent: str
    child: str
    X_PJ: Pose3
    axis: NDArray[np.float64]
    lower: float
    upper: float
    velocity: float = math.inf
    effort: float = 0.0
    damping: float = 0.0
    mimic: Mimic | None = None

    @property
    def moves(self) -> bool:
        """Whether it is movable by itself: one that follows another is not."""
        return self.kind in MOVING_TYPES and self.mimic is None

    def pose(self, position: float) -> Pose3:
        """``X_PC``: pose of the child link in the parent link at ``position`` (rad or m)."""
        if self.kind == "prismatic":
            return self.X_PJ @ Pose3(np.eye(3), self.axis * position)
        if self.kind in MOVING_TYPES:
            return self.X_PJ @ Pose3(rotation_about(self.axis, position), np.zeros(3))
        return self.X_PJ


class KinematicModel:
    """The tree of links and joints of one URDF file."""

    def __init__(self, root: str, joints: tuple[Joint, ...]) -> None:
        self.root = root
        self.joints = {joint.name: joint for joint in joints}
        self._joint_above = {joint.child: joint for joint in joints}

    @property
    def links(self) -> tuple[str, ...]:
        """Every link, the root first, then in the order of the joints that carry them."""
        return (self.root, *self._joint_above)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints that move by themselves, in the file's order."""
        return tuple(name for name, joint in self.joints.items() if joint.moves)

    def pose(self, link: str, positions: Mapping[str, float] | None = None) -> Pose3:
        """``X_BF``: pose of ``link`` in the root link at joint ``positions`` by name (missing ones are 0).

        Raises KeyError naming the links there are.
        """
        positions = positions or {}
        pose = Pose3.identity()
        for joint in self._up(link):
            pose = joint.pose(self.position(joint.name, positions)) @ pose
        return pose

    def poses(self, links: Iterable[str], positions: Mapping[str, float]) -> dict[str, Pose3]:
        """:meth:`pose` of each of ``links``, by name; what they have in common is computed once."""
        known = {self.root: Pose3.identity()}
        for link in links:
            for joint in self.chain(link):
                if joint.child not in known:
                    known[joint.child] = known[joint.parent] @ joint.pose(self.position(joint.name, positions))
        return {link: known[link] for link in links}

    def chain(self, link: str) -> tuple[Joint, ...]:
        """The joints from the root down to ``link``, fixed ones among them; raises KeyError as :meth:`pose`."""
        return tuple(self._up(link))[::-1]

    def position(self, name: str, positions: Mapping[str, float]) -> float:
        """Position (rad or m) of the joint ``name`` at ``positions`` by name: of one that follows another, too."""
        if (mimic := self.joints[name].mimic) is None:
            return positions.get(name, 0.0)
        return mimic.multiplier * positions.get(mimic.joint, 0.0) + mimic.offset

    def jacobian(
        self, link: str, joints: Sequence[str], positions: Mapping[str, float] | None = None
    ) -> NDArray[np.float64]:
        """How the origin of ``link`` moves (3, n) in the root link (m) for each unit of ``joints`` (rad, m), which move
        by themselves, at ``positions`` by name; zero for those that do not move it. Raises KeyError as :meth:`pose`."""
        positions = positions or {}
        end = self.pose(link, positions).translation
        columns = {name: np.zeros(3) for name in joints}
        X_BP = Pose3.identity()
        for joint in self.chain(link):
            name, gain = (joint.mimic.joint, joint.mimic.multiplier) if joint.mimic else (joint.name, 1.0)
            if name in columns:
                X_BJ = X_BP @ joint.X_PJ
                axis = X_BJ.rotation @ joint.axis
                arm = axis if joint.kind == "prismatic" else np.cross(axis, end - X_BJ.translation)
                columns[name] = columns[name] + gain * arm
            X_BP = X_BP @ joint.pose(self.position(joint.name, positions))
        return np.column_stack(list(columns.values())) if columns else np.zeros((3, 0))

    def moved_by(self, link: str) -> tuple[str, ...]:
        """The joints that move ``link`` in the root link, from the link up; raises KeyError as :meth:`pose`."""
        above = (self.joints[joint.mimic.joint] if joint.mimic else joint for joint in self._up(link))
        return tuple(joint.name for joint in above if joint.moves)

    def _up(self, link: str) -> Iterator[Joint]:
        if link != self.root and link not in self._joint_above:
            raise KeyError(f"the robot has no link {link!r}; it has {', '.join(self.links)}")
        while link != self.root:
            joint = self._joint_above[link]
            yield joint
            link = joint.parent


def rotation_about(axis: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """The rotation matrix (3, 3) by ``angle`` (rad) about the unit vector ``axis`` (Rodrigues' formula)."""
    x, y, z = (float(v) for v in axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross))


def load_model(path: Path) -> KinematicModel:
    """Read the URDF file ``path``.

    Raises ConfigError if it is invalid, if its links do not form a tree, or a joint mimics one that cannot move.
    """
    try:
        with open_plain(path) as file:
            robot = ElementTree.parse(file).getroot()
        joints = tuple(_joint(element) for element in robot.findall("joint"))
        links = [element.attrib["name"] for element in robot.findall("link")]
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror}", str(path)) from None
    except ElementTree.ParseError as failure:
        raise ConfigError(f"is no XML: {failure}", str(path)) from None
    except (KeyError, ValueError, AttributeError) as failure:
        raise ConfigError(f"is no URDF: {failure}", str(path)) from None
    children = [joint.child for joint in joints]
    roots = [link for link in links if link not in children]
    if len(roots) != 1 or len(set(children)) != len(children):
        raise ConfigError(
            f"its links must form one tree; these have no parent: {', '.join(roots) or 'none'}", str(path)
        )
    movable = {joint.name for joint in joints if joint.moves}
    for joint in joints:
        if joint.mimic is not None and joint.mimic.joint not in movable:
            raise ConfigError(f"{joint.name} mimics {joint.mimic.joint!r}, which is no movable joint of it", str(path))
    return KinematicModel(roots[0], joints)


def _joint(element: ElementTree.Element) -> Joint:
    origin = element.find("origin")
    xyz = _vector(origin.get("xyz", "0 0 0") if origin is not None else "0 0 0")
    rpy = _vector(origin.get("rpy", "0 0 0") if origin is not None else "0 0 0")
    axis_element = element.find("axis")
    axis = np.array(_vector(axis_element.attrib["xyz"] if axis_element is not None else "1 0 0"))
    length = float(np.linalg.norm(axis))
    if element.attrib["type"] in MOVING_TYPES and length == 0.0:
        raise ValueError(f"the axis of joint {element.get('name')!r} is 0 0 0, which is no direction")
    limit, dynamics = element.find("limit"), element.find("dynamics")
    return Joint(
        name=element.attrib["name"],
        kind=element.attrib["type"],
        parent=_child(element, "parent").attrib["link"],
        child=_child(element, "child").attrib["link"],
        X_PJ=Pose3.from_translation_rpy(xyz, rpy),
        axis=axis / (length or 1.0),
        lower=float(limit.get("lower", "-inf")) if limit is not None else -math.inf,
        upper=float(limit.get("upper", "inf")) if limit is not None else math.inf,
        velocity=float(limit.get("velocity", "inf")) if limit is not None else math.inf,
        effort=float(limit.get("effort", "0")) if limit is not None else 0.0,
        damping=float(dynamics.get("damping", "0")) if dynamics is not None else 0.0,
        mimic=_mimic(element.find("mimic")),
    )


def _mimic(element: ElementTree.Element | None) -> Mimic | None:
    if element is None:
        return None
    return Mimic(element.attrib["joint"], float(element.get("multiplier", "1")), float(element.get("offset", "0")))


def _child(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    found = element.find(tag)
    if found is None:
        raise ValueError(f"joint {element.get('name')!r} has no <{tag}>")
    return found


def _vector(text: str) -> tuple[float, float, float]:
    x, y, z = (float(part) for part in text.split())
    return (x, y, z)

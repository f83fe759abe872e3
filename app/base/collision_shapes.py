"""The collision shapes of a URDF file: boxes, cylinders and spheres, each fixed to a link."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.geometry import FloatArray, Pose3
from app.base.plain_file import open_plain

Kind = Literal["box", "cylinder", "sphere"]


@dataclass(frozen=True, slots=True, eq=False)
class CollisionShape:
    """A solid fixed to ``link`` at ``X_LS``, around its own origin. ``half`` (3,) m: half a box's sides; of a cylinder
    (along z) radius, radius and half its length; of a sphere three times its radius."""

    link: str
    kind: Kind
    X_LS: Pose3
    half: NDArray[np.float64]

    def distance(self, points: FloatArray) -> NDArray[np.float64]:
        """Distances (...) m of ``points`` (..., 3), in the shape's own frame, from its surface; 0 inside."""
        if self.kind == "sphere":
            return np.asarray(np.maximum(np.linalg.norm(points, axis=-1) - self.half[0], 0.0))
        if self.kind == "cylinder":
            beside = np.maximum(np.hypot(points[..., 0], points[..., 1]) - self.half[0], 0.0)
            return np.asarray(np.hypot(beside, np.maximum(np.abs(points[..., 2]) - self.half[2], 0.0)))
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points) - self.half, 0.0), axis=-1))

    def capsule(self) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """The ends (3,) m in the link of a segment along the shape's longest side, and the radius (m) about the segment
        that covers the shape."""
        long = int(np.argmax(self.half))
        across = np.delete(self.half, long)
        radius = float(across[0]) if self.kind != "box" else float(np.hypot(*across))
        along = np.zeros(3)
        # A sphere is covered by a point.
        along[long] = 0.0 if self.kind == "sphere" else self.half[long]
        ends = self.X_LS.transform(np.stack([-along, along]))
        return ends[0], ends[1], radius


def load_collision_shapes(path: Path) -> tuple[CollisionShape, ...]:
    """Every collision shape of the URDF file ``path``. Raises ConfigError if it cannot be read, or has a mesh."""
    try:
        with open_plain(path) as file:
            robot = ElementTree.parse(file).getroot()
        return tuple(
            _shape(link.attrib["name"], element)
            for link in robot.findall("link")
            for element in link.findall("collision")
        )
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror}", str(path)) from None
    except ElementTree.ParseError as failure:
        raise ConfigError(f"is no XML: {failure}", str(path)) from None
    except (KeyError, ValueError) as failure:
        raise ConfigError(f"is no URDF: {failure}", str(path)) from None


def _shape(link: str, element: ElementTree.Element) -> CollisionShape:
    origin = element.find("origin")
    xyz = _vector(origin.get("xyz", "0 0 0") if origin is not None else "0 0 0")
    rpy = _vector(origin.get("rpy", "0 0 0") if origin is not None else "0 0 0")
    X_LS = Pose3.from_translation_rpy(xyz, rpy)
    if (box := element.find("geometry/box")) is not None:
        return CollisionShape(link, "box", X_LS, np.array(_vector(box.attrib["size"])) / 2)
    if (cylinder := element.find("geometry/cylinder")) is not None:
        radius, length = float(cylinder.attrib["radius"]), float(cylinder.attrib["length"])
        return CollisionShape(link, "cylinder", X_LS, np.array([radius, radius, length / 2]))
    if (sphere := element.find("geometry/sphere")) is not None:
        return CollisionShape(link, "sphere", X_LS, np.full(3, float(sphere.attrib["radius"])))
    raise ValueError(f"a collision shape of {link} is neither a box, nor a cylinder, nor a sphere")


def _vector(text: str) -> tuple[float, float, float]:
    x, y, z = (float(part) for part in text.split())
    return (x, y, z)

"""Shapes of a robot's model file (URDF): boxes, cylinders, spheres, meshes, in their links' frames."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from app.base.geometry import Pose3

Color = tuple[int, int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """One visual shape: ``mesh``'s vertices are in the frame of ``link``, in m; ``color`` is red, green, blue."""

    link: str
    color: Color
    mesh: trimesh.Trimesh


def visual_shapes(model: Path) -> list[Shape]:
    """Every visual shape of the URDF file ``model``. Raises ValueError or OSError for one that cannot be."""
    robot = ElementTree.parse(model).getroot()
    named = {
        material.attrib["name"]: color
        for material in robot.iter("material")
        if "name" in material.attrib and (color := _color(material)) is not None
    }
    return [
        shape
        for link in robot.findall("link")
        for visual in link.findall("visual")
        for shape in _shapes(visual, link.attrib["name"], named, model)
    ]


def merged(meshes: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    """Several meshes as one."""
    mesh = trimesh.util.concatenate(meshes)
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def _shapes(visual: ElementTree.Element, link: str, named: Mapping[str, Color], model: Path) -> Iterator[Shape]:
    origin = visual.find("origin")
    xyz, rpy = ("0 0 0", "0 0 0") if origin is None else (origin.get("xyz", "0 0 0"), origin.get("rpy", "0 0 0"))
    X_LS = Pose3.from_translation_rpy(_three(xyz), _three(rpy))
    material = visual.find("material")
    color = None if material is None else (_color(material) or named.get(material.get("name", "")))
    for mesh in _meshes(visual, model):
        mesh.vertices = X_LS.transform(np.asarray(mesh.vertices, np.float64))
        yield Shape(link, color or _own_color(mesh.visual), mesh)


def _meshes(visual: ElementTree.Element, model: Path) -> Iterator[trimesh.Trimesh]:
    """The shape in its own frame, whole or, out of a file, in parts."""
    if (box := visual.find("geometry/box")) is not None:
        yield trimesh.creation.box(extents=_three(box.attrib["size"]))
    elif (cylinder := visual.find("geometry/cylinder")) is not None:
        yield trimesh.creation.cylinder(float(cylinder.attrib["radius"]), float(cylinder.attrib["length"]))
    elif (sphere := visual.find("geometry/sphere")) is not None:
        yield trimesh.creation.icosphere(radius=float(sphere.attrib["radius"]))
    elif (file := visual.find("geometry/mesh")) is not None:
        path = _mesh_file(file.attrib["filename"], model)
        try:
            scene = trimesh.load_scene(path)
        except (ImportError, NotImplementedError) as failure:
            raise ValueError(f"{path.name} cannot be read: {failure}; STL, OBJ, PLY and GLB can") from None
        scale = _three(file.get("scale", "1 1 1"))
        for mesh in scene.dump():
            if isinstance(mesh, trimesh.Trimesh):
                mesh.apply_transform(np.diag((*scale, 1.0)))  # which keeps the outside of a mirrored one outside
                yield mesh


def _mesh_file(name: str, model: Path) -> Path:
    """Where a mesh is: relative to ``model``; ``package://`` is looked for beside it and in the folders above."""
    scheme, _, rest = name.rpartition("://")
    if scheme != "package":
        return model.parent / rest
    inside = Path(*Path(rest).parts[1:])
    candidates = [folder / part for folder in model.resolve().parents for part in (rest, inside)]
    found = next((path for path in candidates if path.is_file()), None)
    if found is None:
        raise FileNotFoundError(f"there is no {name} beside {model} nor in a folder above")
    return found


def _own_color(visual: Any) -> Color:
    """The colour that a mesh brings: its material's, or the one that most of its faces have."""
    red, green, blue = (int(value) for value in np.asarray(getattr(visual, "material", visual).main_color)[:3])
    return (red, green, blue)


def _color(material: ElementTree.Element) -> Color | None:
    color = material.find("color")
    if color is None:
        return None
    red, green, blue, *_ = (int(255 * float(part)) for part in color.attrib["rgba"].split())
    return (red, green, blue)


def _three(text: str) -> tuple[float, float, float]:
    x, y, z = (float(part) for part in text.split())
    return (x, y, z)

"""A model of others made into a body's folder: model, meshes, an empty floor, and its file, to be filled in."""

from __future__ import annotations

import re
import tempfile
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.kinematic_model import KinematicModel, load_model
from app.base.model_shapes import visual_shapes
from app.maps.map_file import pgm_bytes, yaml_text
from app.messages import OccupancyGrid
from app.robots.importing.groups import proposed_groups, speed_of
from app.robots.importing.mjcf import read_mjcf
from app.robots.importing.outline import Outline, outline
from app.robots.importing.urdf import READ_AS_IS, ImportedModel, parsed, read_urdf

_FLOOR_M, _RESOLUTION_M = 12.0, 0.05
#: A root that is higher above the lowest point than this (m) is put on the floor.
_OFF_FLOOR_M = 0.005
_LASER = re.compile(r"laser|lidar|hokuyo|scan|rplidar|sick", re.IGNORECASE)
_CAMERA = re.compile(r"optical", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class ImportedBody:
    """What was written: the ``file`` of the body, its groups, its size, and what is to be looked at."""

    file: Path
    links: int
    joints: int
    groups: dict[str, tuple[str, ...]]
    height_m: float
    footprint: tuple[tuple[float, float], ...]
    laser: str
    cameras: tuple[str, ...]
    remarks: tuple[str, ...]


def import_body(path: Path, folder: Path, packages: Path | None = None, name: str = "") -> ImportedBody:
    """Write the body of the URDF or MJCF file ``path`` into ``folder``, which must not exist yet: wholly or not at all.

    Raises ConfigError for a model that cannot be read or has no shape, and OSError of the disk.
    """
    if folder.exists():
        raise ConfigError(f"{folder} exists; name another folder, or move it away", "--out")
    imported = read_mjcf(path) if parsed(path).tag == "mujoco" else read_urdf(path, packages)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".importing-", dir=folder.parent) as made:
        working = Path(made, folder.name)
        (working / "meshes").mkdir(parents=True)
        body = _written(imported, path, working, name or imported.robot.get("name", "") or path.stem)
        working.rename(folder)
    return replace(body, file=folder / body.file.name)


def _written(imported: ImportedModel, path: Path, folder: Path, name: str) -> ImportedBody:
    for file, source in imported.meshes.items():
        _write_mesh(folder / "meshes" / file, source)
    model_file = folder / "robot.urdf"
    _write(imported.robot, model_file)
    model = load_model(model_file)
    sized = outline(model, _vertices(model_file))
    if sized is None:
        raise ConfigError("has no shape that can be read, so it has no size", str(path))
    if abs(sized.bottom_m) > _OFF_FLOOR_M:
        _put_on_floor(imported, model, sized.bottom_m)
        _write(imported.robot, model_file)
        model = load_model(model_file)
    (folder / "floor.yaml").write_text(yaml_text(_floor(), "floor.pgm"), "utf-8")
    (folder / "floor.pgm").write_bytes(pgm_bytes(_floor()))
    body = _described(folder, model, sized, imported.remarks)
    body.file.write_text(_text(name, path.name, body, model), "utf-8")
    return body


def _described(folder: Path, model: KinematicModel, sized: Outline, remarks: list[str]) -> ImportedBody:
    lasers = [link for link in model.links if _LASER.search(link)]
    fixed = sorted((link for link in lasers if not model.moved_by(link)), key=_unlikely)
    if not sized.footprint:
        remarks.append("footprint: what no joint moves does not lie around the root; a circle of 0.28 m is assumed.")
    if len(fixed) > 1:
        remarks.append(f"laser: {fixed[0]} was chosen; there are also {', '.join(fixed[1:])}.")
    if not fixed:
        moved = f": a joint moves {', '.join(lasers)}" if lasers else ""
        remarks.append(f"laser: no link of it is named as one and fixed to the base{moved}.")
    return ImportedBody(
        file=folder / "body.yaml",
        links=len(model.links),
        joints=len(model.joint_names),
        groups=proposed_groups(model),
        height_m=round(sized.top_m - sized.bottom_m, 3),
        footprint=sized.footprint,
        laser=fixed[0] if fixed else "",
        cameras=tuple(link for link in model.links if _CAMERA.search(link)),
        remarks=tuple(remarks),
    )


def _unlikely(link: str) -> tuple[bool, int]:
    """The order of lasers: those of a base first, then short names; a camera's emulated one last."""
    return not re.search(r"base|front", link, re.IGNORECASE), len(link) + 100 * ("rgbd" in link.lower())


def _write(robot: ElementTree.Element, path: Path) -> None:
    ElementTree.indent(robot)
    ElementTree.ElementTree(robot).write(path, "utf-8", xml_declaration=True)


def _write_mesh(path: Path, source: Path | bytes) -> None:
    if isinstance(source, bytes):
        path.write_bytes(source)
    elif source.suffix.lower() in READ_AS_IS:
        path.write_bytes(source.read_bytes())
    else:
        path.write_bytes(trimesh.load_scene(source).export(file_type="glb"))  # type: ignore[no-untyped-call]


def _vertices(model: Path) -> dict[str, NDArray[np.float64]]:
    """Vertices (N, 3) m of the visual shapes, by link, in its frame."""
    points: dict[str, list[NDArray[np.float64]]] = {}
    for shape in visual_shapes(model):
        points.setdefault(shape.link, []).append(np.asarray(shape.mesh.vertices, np.float64))
    return {link: np.concatenate(parts) for link, parts in points.items() if sum(map(len, parts))}


def _put_on_floor(imported: ImportedModel, model: KinematicModel, bottom_m: float) -> None:
    """A new root on the floor, below the former one."""
    root = "floor_link"
    while root in model.links:
        root = f"{root}_"
    imported.robot.insert(0, ElementTree.Element("link", {"name": root}))
    joint = ElementTree.SubElement(imported.robot, "joint", {"name": f"{root}_joint", "type": "fixed"})
    ElementTree.SubElement(joint, "parent", {"link": root})
    ElementTree.SubElement(joint, "child", {"link": model.root})
    ElementTree.SubElement(joint, "origin", {"xyz": f"0 0 {-bottom_m:.6g}", "rpy": "0 0 0"})
    imported.remarks.append(
        f"{root} is its root, on the floor: {model.root} is {-bottom_m:.3f} m above its lowest point, all joints at 0."
    )


def _floor() -> OccupancyGrid:
    """An empty square with walls."""
    count = round(_FLOOR_M / _RESOLUTION_M)
    cells = np.zeros((count, count), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    corner = (-_FLOOR_M / 2, -_FLOOR_M / 2)
    return OccupancyGrid(0.0, "map", cells, resolution_m=_RESOLUTION_M, origin=corner, version=0)


def _text(name: str, source: str, body: ImportedBody, model: KinematicModel) -> str:
    corners = ", ".join(f"[{x:g}, {y:g}]" for x, y in body.footprint)
    lines = [
        f"# Made of {source} by `hbba body import`: what is marked ? is to be set (docs/bodies.md).",
        "# As it is, it drives on an empty floor without physics: hbba run --config jackal --robot body.yaml",
        "kind: kinematic",
        f"name: {_quoted(name)}",
        "model: robot.urdf",
        "map: floor.yaml",
        *([f"footprint: [{corners}]"] if corners else []),
        f"height_m: {max(body.height_m, 0.01):g}",
        "limits: {linear_mps: 0.3, angular_radps: 1.0, linear_mps2: 0.4, angular_radps2: 2.0}    # ? of its base",
        f"laser: {{link: {_quoted(body.laser)}}}    # ? also fov_deg, range_max_m"
        if body.laser
        else "laser: null    # ?",
    ]
    if body.cameras:
        lines.append(f"# Optical frames, for a camera of a real body: {', '.join(body.cameras)}")
    if body.groups:
        lines.append("actuators:    # ? joints that are commanded together")
        for group, joints in body.groups.items():
            names = ", ".join(map(_quoted, joints))
            lines.append(f"  {_quoted(group)}: {{joints: [{names}], velocity: {speed_of(model, joints):g}}}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    plain = re.fullmatch(r"[A-Za-z_][A-Za-z0-9_ ./-]*", text) and text.lower() not in ("on", "off", "yes", "no", "null")
    return text if plain else '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'

"""A URDF model made whole: its meshes beside it, in formats that are read, and no joint of an unknown kind."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path

from app.base.errors import ConfigError
from app.base.kinematic_model import MOVING_TYPES

#: Formats that the page's view reads as they are.
READ_AS_IS = (".stl", ".obj", ".ply", ".glb")
#: Formats that are converted where their reader is installed.
CONVERTED = (".dae",)
_KINDS = (*MOVING_TYPES, "fixed")
_XACRO = "{http://www.ros.org/wiki/xacro}"


@dataclass(slots=True)
class ImportedModel:
    """A model on its way: ``robot`` is its URDF, whose meshes are files of the folder ``meshes``; ``meshes`` has where
    each of them comes from, or its own bytes; ``remarks`` are sentences for people."""

    robot: ElementTree.Element
    meshes: dict[str, Path | bytes] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)


def read_urdf(path: Path, packages: Path | None = None) -> ImportedModel:
    """The model of the URDF file ``path``; ``packages``: a folder with the packages that ``package://`` names.

    Raises ConfigError for a file that is no URDF.
    """
    robot = parsed(path)
    if robot.tag != "robot":
        raise ConfigError(f"is no URDF: it begins with <{robot.tag}>, not <robot>", str(path))
    if any(element.tag.startswith(_XACRO) for element in robot.iter()):
        raise ConfigError("is xacro, which ROS makes URDF of: xacro FILE > robot.urdf", str(path))
    model = ImportedModel(_plain(robot))
    _fix_joints(model)
    _gather_meshes(model, path, packages)
    _draw_collisions(model)
    return model


def parsed(path: Path) -> ElementTree.Element:
    """The root of the XML file ``path``. Raises ConfigError."""
    try:
        return ElementTree.parse(path).getroot()
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror}", str(path)) from None
    except ElementTree.ParseError as failure:
        raise ConfigError(f"is no XML: {failure}", str(path)) from None


def _plain(robot: ElementTree.Element) -> ElementTree.Element:
    """``robot`` with its links, joints and materials alone: the rest is for simulators and controllers."""
    kept = ElementTree.Element("robot", {"name": robot.get("name", "robot")})
    kept.extend(element for element in robot if element.tag in ("material", "link", "joint"))
    return kept


def _fix_joints(model: ImportedModel) -> None:
    for joint in model.robot.findall("joint"):
        kind = joint.get("type", "")
        if kind not in _KINDS:
            joint.set("type", "fixed")
            model.remarks.append(f"joint {joint.get('name')}: of type {kind or 'none'}, taken as fixed.")
        if joint.get("type") == "fixed":
            for axis in joint.findall("axis"):  # some are 0 0 0, which is no direction
                joint.remove(axis)


def _gather_meshes(model: ImportedModel, path: Path, packages: Path | None) -> None:
    taken: dict[Path, str] = {}
    said: set[str] = set()
    for link in model.robot.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            mesh = shape.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.get("filename", "")
            found = find_mesh(name, path, packages)
            why = "was not found" if found is None else _unreadable(found)
            if found is None or why:
                link.remove(shape)
                if name not in said:
                    said.add(name)
                    model.remarks.append(f"mesh {name}: {why}; its shape is left out.")
                continue
            if found not in taken:
                taken[found] = _free_name(model, found)
                model.meshes[taken[found]] = found
            mesh.set("filename", f"meshes/{taken[found]}")


def find_mesh(name: str, model: Path, packages: Path | None) -> Path | None:
    """Where the mesh ``name`` of ``model`` is: beside it; for ``package://`` below ``packages`` or a folder above."""
    scheme, _, rest = name.rpartition("://")
    if scheme == "file":
        return Path(rest) if Path(rest).is_file() else None
    roots = [model.resolve().parent]
    if scheme:
        roots = [*([packages.resolve()] if packages is not None else []), *model.resolve().parents]
    inside = Path(*Path(rest).parts[1:]) if scheme else Path(rest)
    return next((path for root in roots for path in (root / rest, root / inside) if path.is_file()), None)


def _unreadable(mesh: Path) -> str:
    """Why ``mesh`` cannot be read; "" if it can."""
    suffix = mesh.suffix.lower()
    if suffix in READ_AS_IS:
        return ""
    if suffix in CONVERTED:
        try:
            import collada  # noqa: F401
        except ImportError:
            return "is COLLADA, which needs pycollada: pip install 'hbba[models]'"
        return ""
    return f"is {suffix or 'of no format'}; {', '.join((*READ_AS_IS, *CONVERTED))} can be read"


def _free_name(model: ImportedModel, mesh: Path) -> str:
    """A file name of the folder ``meshes`` that no other mesh has."""
    suffix = ".glb" if mesh.suffix.lower() in CONVERTED else mesh.suffix.lower()
    name, number = f"{mesh.stem}{suffix}", 2
    while name in model.meshes:
        name, number = f"{mesh.stem}_{number}{suffix}", number + 1
    return name


def _draw_collisions(model: ImportedModel) -> None:
    """Draw the collision shapes of a link that has no other."""
    for link in model.robot.findall("link"):
        if not link.findall("visual"):
            for shape in link.findall("collision"):
                visual = ElementTree.SubElement(link, "visual")
                visual.extend(element for element in shape if element.tag in ("origin", "geometry"))

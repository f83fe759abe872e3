"""``hbba ros package DIR``: the definitions of our messages as a package of ROS 2, for programs of others."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.output import write_text

if TYPE_CHECKING:
    from collections.abc import Iterable

_PACKAGE = "hbba_msgs"
_MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>{version}</version>
  <description>Messages and services of HBBA; written by hbba ros package.</description>
  <maintainer email="hbba@example.org">HBBA</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
{depends}
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""
_CMAKE = """\
cmake_minimum_required(VERSION 3.8)
project({name})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{finds}
rosidl_generate_interfaces(${{PROJECT_NAME}}
{files}
  DEPENDENCIES {depends}
)
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


def add_parser(kinds: Any) -> None:
    """The command among those of ``hbba ros``."""
    parser = kinds.add_parser(
        "package",
        help="write our messages as a package of ROS 2",
        description="Write the package hbba_msgs for a workspace of ROS 2 (colcon build): the definitions of what "
        "`hbba run --ros2` publishes and serves, so that programs of others, ros2 topic echo among them, read it.",
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="where, as src/hbba_msgs; it must not be there yet")
    parser.add_argument("--config", type=Path, metavar="FILE", help="the program (default: that of the lab)")


def run(args: argparse.Namespace) -> int:
    """Write it. Raises ConfigError for a folder that is there, or a program that cannot be read."""
    from app.base import paths
    from app.program.config import load_configuration

    if args.folder.exists():
        raise ConfigError(f"{args.folder} is there already; name a folder that is not")
    channels = load_configuration(args.config or paths.config_dir() / "lab.yaml").channels
    files = package(interfaces(spec.message_type for spec in channels.values()))
    for name, text in files.items():
        path = args.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, text)
    print(f"{args.folder}: {len(files) - 2} definitions; colcon build --packages-select {_PACKAGE}")
    return 0


def interfaces(message_types: Iterable[type[Any]]) -> dict[str, str]:
    """The files of our definitions, by name in the package, of these classes and of the services."""
    from app.logs.ros import typestore
    from app.logs.ros.converters import converter
    from app.logs.ros.generated import UnrecordableType
    from app.modules.viewers.ros2.desires import ADD, REMOVE

    wanted: set[str] = set()
    for message_type in message_types:
        try:
            topics = converter("any", message_type).topics
        except UnrecordableType:
            continue
        for topic in topics:
            wanted |= _with_parts(topic.type)
    texts = dict(typestore.added())
    found = {
        f"msg/{name.rpartition('/')[2]}.msg": texts[name] for name in sorted(wanted) if name.startswith(f"{_PACKAGE}/")
    }
    services = {
        f"srv/{each.type.rpartition('/')[2]}.srv": f"{each.request}---\n{each.response}" for each in (ADD, REMOVE)
    }
    return {name: text if text.endswith("\n") else f"{text}\n" for name, text in {**found, **services}.items()}


def package(files: dict[str, str]) -> dict[str, str]:
    """``files`` with the manifest and the build file that belong to them."""
    from app.base import paths

    used = {
        kind.partition("/")[0]
        for text in files.values()
        for line in text.splitlines()
        if "/" in (kind := line.partition(" ")[0])
    }
    depends = sorted(used - {_PACKAGE})
    manifest = _MANIFEST.format(
        name=_PACKAGE,
        version=".".join((paths.version() or "0.0.0").split(".")[:3]),
        depends="\n".join(f"  <depend>{each}</depend>" for each in depends),
    )
    cmake = _CMAKE.format(
        name=_PACKAGE,
        finds="\n".join(f"find_package({each} REQUIRED)" for each in depends),
        files="\n".join(f'  "{name}"' for name in files),
        depends=" ".join(depends),
    )
    return {"package.xml": manifest, "CMakeLists.txt": cmake, **files}


def _with_parts(name: str) -> set[str]:
    """A type and all that it uses."""
    from app.logs.ros.live.kinds import fields_of

    found, open_ = set[str](), [name]
    while open_:
        each = open_.pop()
        if each not in found:
            found.add(each)
            open_ += [kind.nested for _, kind in fields_of(each) if kind.nested]
    return found

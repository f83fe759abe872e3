"""``hbba body``: makes a robot's model into a body, and shows models."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.arguments import whole
from app.commands.output import add_json, print_json

if TYPE_CHECKING:
    from app.robots.importing.body_folder import ImportedBody


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "body", help="make a robot's model into a body, and look at models", description="Bodies (docs/bodies.md)."
    )
    kinds = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    importing = kinds.add_parser(
        "import",
        help="make a body of a URDF or MJCF file",
        description="Write a folder with the robot's model, its meshes and a body's file: size, limits, groups of "
        "joints and sensors, with what is to be set marked ?. It can be driven on an empty floor at once.",
    )
    importing.add_argument("file", type=Path, metavar="FILE", help="the model: URDF, or MuJoCo's MJCF")
    importing.add_argument(
        "-o", "--out", type=Path, metavar="FOLDER", help="the new folder (default: FILE's name, here)"
    )
    importing.add_argument("--packages", type=Path, metavar="FOLDER", help="where the packages of package:// are")
    importing.add_argument("--name", default="", help="the robot's name (default: the model's)")
    add_json(importing)
    showing = kinds.add_parser(
        "show",
        help="look at a model, and move its joints",
        description="Serve the model as a page of this computer alone, with a slider for each joint; Ctrl-C ends it.",
    )
    showing.add_argument("file", type=Path, metavar="FILE", help="a URDF file, or a body's file")
    showing.add_argument(
        "--port", type=whole(0, 65535), default=8090, metavar="N", help="default 8090; 0: any free one"
    )


def run(args: argparse.Namespace) -> int:
    """Do it. Raises ConfigError for a model that cannot be read."""
    return _show(args) if args.what == "show" else _import(args)


def _import(args: argparse.Namespace) -> int:
    from app.robots.importing.body_folder import import_body

    folder = Path(args.file.stem) if args.out is None else args.out
    try:
        body = import_body(args.file, folder, args.packages, args.name)
    except OSError as failure:
        print(f"hbba body: {failure.filename or folder}: {failure.strerror or failure}", file=sys.stderr)
        return 1
    if args.json:
        print_json(asdict(body) | {"file": str(body.file)})
        return 0
    print("\n".join(_lines(body)))
    for remark in body.remarks:
        print(remark, file=sys.stderr)
    return 0


def _lines(body: ImportedBody) -> list[str]:
    groups = ", ".join(f"{name} ({len(joints)})" for name, joints in body.groups.items())
    outline = f"{len(body.footprint)} corners" if body.footprint else "no outline of its own"
    return [
        f"{body.file}: {body.links} links, {body.joints} joints, {body.height_m:.2f} m high, {outline}",
        f"groups of joints: {groups or 'none'}",
        f"laser: {body.laser or 'none'}; optical frames: {', '.join(body.cameras) or 'none'}",
        f"  hbba body show {body.file}",
        f"  hbba run --config jackal --robot {body.file}",
    ]


def _show(args: argparse.Namespace) -> int:
    from app.commands.body_page import serve_model
    from app.console.server import listen
    from app.robots.factory import load_body

    if args.file.suffix in (".yaml", ".yml"):
        body = load_body(args.file)
        model, footprint = body.model, tuple(body.footprint)
    else:
        model, footprint = args.file, ()
    listener = listen("127.0.0.1", args.port)
    port = int(listener.getsockname()[1])
    listener.close()
    try:
        return serve_model(model, footprint, port)
    except (OSError, ValueError) as failure:
        raise ConfigError(f"cannot be shown: {failure}", str(model)) from None

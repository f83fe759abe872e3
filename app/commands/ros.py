"""``hbba ros map [BAG]``: the mapping of a robot over ROS 2, proposed from its graph, or from a bag."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands import ros_package
from app.commands.output import add_json, print_json, write_text

if TYPE_CHECKING:
    from app.base.kinematic_model import KinematicModel
    from app.robots.ros2.survey import Found


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "ros", help="propose the mapping of a robot over ROS 2", description="Robots that speak ROS 2 (docs/ros2.md)."
    )
    kinds = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    mapping = kinds.add_parser(
        "map",
        help="propose a mapping from the robot's topics",
        description="Look at the robot's graph, or at a bag of it, and propose its mapping on standard output; what is "
        "missing is said on standard error. Values marked ? are to be set. Exit code 1 where the robot has no odometry "
        "or takes no velocities, so that it cannot be driven.",
    )
    mapping.add_argument("bag", nargs="?", type=Path, metavar="BAG", help="a bag, ROS 1 or 2; none: the live graph")
    mapping.add_argument(
        "--listen",
        type=_seconds,
        default=5.0,
        metavar="S",
        help="how long to listen (default 5 s), four times as long at most where nothing comes",
    )
    mapping.add_argument("--domain", type=int, metavar="N", help="ROS_DOMAIN_ID (default: the environment's)")
    mapping.add_argument("--model", type=Path, metavar="URDF", help="the robot's model, to look for the laser's link")
    mapping.add_argument("--dot", type=Path, metavar="FILE", help="write the robot's frames here, for Graphviz")
    ros_package.add_parser(kinds)
    add_json(mapping, "print one JSON document instead: the mapping's text, what is missing, the topics")


def run(args: argparse.Namespace) -> int:
    """Do what is asked for. Raises ConfigError for what cannot be read."""
    return ros_package.run(args) if args.what == "package" else _propose(args)


def _propose(args: argparse.Namespace) -> int:
    """Print the proposal. Raises ConfigError for a bag or a model that cannot be read."""
    from dataclasses import asdict, replace

    from app.base.kinematic_model import load_model
    from app.robots.ros2.frame_tree import differences, dot, text
    from app.robots.ros2.proposal import propose

    found = _found(args)
    topics, frames = found.topics, text(found.frames)
    model = None if args.model is None else load_model(args.model)
    proposal = propose(topics, None if model is None else _links(model))
    if model is not None and (apart := differences(found.frames, model, sorted({topic.frame for topic in topics}))):
        proposal = replace(proposal, missing=(*proposal.missing, *apart))
    if args.dot is not None:
        write_text(args.dot, dot(found.frames))
    if args.json:
        document = {"mapping": proposal.text, "missing": proposal.missing, "remarks": proposal.remarks}
        print_json({**document, "topics": [asdict(topic) for topic in topics], "frames": frames})
    else:
        print(proposal.text, end="")
        if frames:
            print("# The robot's frames; ~ before those that move:")
            print("\n".join(f"#   {line}" for line in frames))
        for sentence in proposal.remarks:
            print(sentence, file=sys.stderr)
        for sentence in proposal.missing:
            print(f"missing: {sentence}", file=sys.stderr)
    return int(not proposal.drivable)


def _found(args: argparse.Namespace) -> Found:
    from app.logs.log import LogError
    from app.logs.ros.live.graph import MISSING
    from app.robots.ros2 import survey

    if args.bag is not None:
        try:
            return survey.bag(args.bag)
        except LogError as failure:
            raise ConfigError(str(failure)) from None
    try:
        return survey.live(args.listen, args.domain)
    except ImportError:
        raise ConfigError(MISSING) from None


def _links(model: KinematicModel) -> dict[str, bool]:
    """The links of the model, and whether each is fixed to its base."""
    return {link: not model.moved_by(link) for link in model.links}


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0 < seconds <= 600:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of seconds above 0, up to 600")
    return seconds

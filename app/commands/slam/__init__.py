"""``hbba slam LOG``: a map out of a log, and how good it is."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands.arguments import real, whole
from app.commands.output import add_json, print_json

_NUMBER = real(rule="must be a number")


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "slam",
        help="map a place from a log of a laser and odometry",
        description="Map the place that a log was recorded in, as the robot would have, but as fast as this computer "
        "can, and say how well: against relations between scans (Kuemmerle et al., 2009) and against another "
        "trajectory, where these are given. Exit code 0 if a map was made, 2 if a file cannot be read.",
    )
    parser.add_argument(
        "log",
        metavar="LOG",
        help="a CARMEN log (.log, .clf, .gz), a recording of hbba, a ROS bag, or arrays (.npz with `ranges` (N, B) m "
        "and `pose` (N, 3) m, rad of odometry)",
    )
    parser.add_argument(
        "--relations",
        type=Path,
        metavar="FILE",
        help="relations: lines `i j dx dy dtheta` between scans by number from 0, or `t1 t2 x y z roll pitch yaw` by "
        "time",
    )
    parser.add_argument("--reference", type=Path, metavar="FILE", help="a CARMEN log with corrected poses")
    parser.add_argument("--phi", type=whole(1), default=1, metavar="N", help="take only one scan of N (default: all)")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="write map, pose graph and trajectory into FOLDER")
    add_json(parser)
    laser = parser.add_argument_group("the laser of an .npz, where its number of rays does not say enough")
    laser.add_argument("--angle-min", type=_NUMBER, metavar="DEG", help="of the first ray (default: by their number)")
    laser.add_argument("--angle-step", type=_NUMBER, metavar="DEG", help="from ray to ray (default: by their number)")
    laser.add_argument("--range-max", type=_NUMBER, metavar="M", help="from here on, nothing was hit (default: 80)")
    laser.add_argument("--laser-x", type=_NUMBER, metavar="M", help="of the laser in the body (default: 0)")
    log = parser.add_argument_group("logs with several lasers")
    log.add_argument("--scans", metavar="CHANNEL", help="the laser's channel (default: scan, or the only one)")
    log.add_argument("--odometry", metavar="CHANNEL", help="odometry's (default: odometry, or the only one)")
    log.add_argument("--remap", type=Path, metavar="FILE", help="which topics of a bag are which channels")


def run(args: argparse.Namespace) -> int:
    from app.commands.detect.outputs import make_folder
    from app.commands.progress import shown
    from app.commands.slam.report import figures, print_figures
    from app.commands.slam.sweeps import open_sweeps
    from app.commands.slam.truth import read_reference, read_relations

    if args.out is not None:
        make_folder(args.out, "--out")
    source = open_sweeps(args)
    relations = None if args.relations is None else read_relations(args.relations)
    reference = None if args.reference is None else read_reference(args.reference)
    with shown("map") as progress:
        from app.modules.perception.slam.offline_mapping import mapped
        from app.modules.perception.slam.self_check import checked

        log = mapped(source.sweeps, phi=args.phi, on_progress=lambda done, text: progress(done, source.count, text))
    if not log.rows:
        raise ConfigError(f"{args.log}: has no scan with odometry to it that shows anything")
    check = checked(log)
    document = figures(source, log, phi=args.phi, check=check, relations=relations, reference=reference)
    if args.out is not None:
        from app.commands.slam.outputs import write

        document["written"] = write(args.out, log, check)
    if args.json:
        print_json(document)
    else:
        print_figures(document)
    return 0

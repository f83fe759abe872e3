"""``hbba detect``: the robot's perceptions on files of the user, each in a file of its own beside this one."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import ModuleType
from typing import Any

from app.commands.detect import faces, noises, qr, voices

#: Detectors, by the word after ``hbba detect``.
DETECTORS: Mapping[str, ModuleType] = {
    "faces": faces,
    "qr": qr,
    "voices": voices,
    "noises": noises,
}


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "detect",
        help="find faces, QR codes, voices and loud noises in your own files",
        description="Run the robot's perceptions on files of yours.",
    )
    kinds = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    for detector in DETECTORS.values():
        detector.add_parser(kinds)


def run(args: argparse.Namespace) -> int:
    code: int = DETECTORS[args.what].run(args)
    return code

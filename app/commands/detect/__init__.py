"""``hbba detect``: the robot's perceptions on files of the user, each in a file of its own beside this one."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any, Protocol

from app.commands.detect import faces, noises, qr, voices


class Detector(Protocol):
    """The functions of each file here."""

    def add_parser(self, kinds: Any) -> None:
        """Declare the word after ``hbba detect``, its help and arguments."""
        ...

    def run(self, args: argparse.Namespace) -> int:
        """Do it and return the exit code. May raise ConfigError for a person's mistake."""
        ...


#: Detectors, by the word after ``hbba detect``.
DETECTORS: Mapping[str, Detector] = {
    "faces": faces,
    "qr": qr,
    "voices": voices,
    "noises": noises,
}


def add_parser(subparsers: Any) -> None:
    """Declare ``hbba detect`` and its detectors."""
    parser = subparsers.add_parser(
        "detect",
        help="find faces, QR codes, voices and loud noises in your own files",
        description="Run the robot's perceptions on files of yours.",
    )
    kinds = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    for detector in DETECTORS.values():
        detector.add_parser(kinds)


def run(args: argparse.Namespace) -> int:
    """Do it and return the exit code. May raise ConfigError for a person's mistake."""
    return DETECTORS[args.what].run(args)

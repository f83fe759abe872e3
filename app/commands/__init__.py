"""The commands of ``hbba``, one file each.

``add_parser(subparsers)`` declares the command's name, help and arguments; ``run(args)`` does it and returns the exit
code. It may raise ConfigError for a person's mistake.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType

from app.commands import (
    bench,
    body,
    calibrate,
    check,
    completion,
    detect,
    doctor,
    experiment,
    log,
    new,
    node,
    password,
    replay,
    ros,
    run,
    slam,
    solve,
    tour,
)

COMMANDS: Mapping[str, ModuleType] = {
    "run": run,
    "replay": replay,
    "log": log,
    "doctor": doctor,
    "check": check,
    "solve": solve,
    "calibrate": calibrate,
    "detect": detect,
    "experiment": experiment,
    "slam": slam,
    "tour": tour,
    "ros": ros,
    "body": body,
    "node": node,
    "new": new,
    "password": password,
    "bench": bench,
    "completion": completion,
}

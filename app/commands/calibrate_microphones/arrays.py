"""The array that is calibrated, and where it is configured."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.base.errors import ConfigError
from app.commands.packaged import config_file
from app.modules.perception.voices.microphone_array import MicrophoneArray, load_array
from app.robots.devices.config import SoundInputConfig


@dataclass(frozen=True, slots=True, eq=False)
class ConfiguredArray:
    """``array`` as configured in ``file`` at the key path ``key`` (None, (): it comes from a recording), its ``name``
    for people; ``input``: the sound card's input of a robot of devices."""

    array: MicrophoneArray
    name: str
    file: Path | None = None
    key: tuple[str, ...] = ()
    input: SoundInputConfig | None = None


def configured_array(args: argparse.Namespace) -> ConfiguredArray | None:
    """The array of ``--array`` or ``--robot``; None where neither was given. Raises ConfigError."""
    if args.array is not None:
        file = config_file(args.array, "array", "--array")
        array = load_array(file)
        return ConfiguredArray(_with_body(array, args.body), str(args.array), file, ("positions",))
    if args.robot is not None:
        file = config_file(args.robot, "robot", "--robot")
        return _of_robot(file, args)
    return None


def array_at(positions: Any, body_m: float | None, where: str) -> MicrophoneArray:
    """The array of ``positions`` (M, 3) m. Raises ConfigError, naming ``where`` they come from."""
    try:
        return MicrophoneArray(np.array(positions, np.float64).reshape(-1, 3), body_m=body_m or 0.0)
    except ValueError as failure:
        raise ConfigError(f"{where}: {failure}") from None


def _of_robot(file: Path, args: argparse.Namespace) -> ConfiguredArray:
    from app.robots.factory import load_body

    body = load_body(file)
    streams = getattr(body, "streams", None)
    microphones = getattr(body, "microphones", None) or getattr(streams, "microphones", None)
    positions = getattr(microphones, "positions", None)
    if positions is None:
        raise ConfigError(
            "has no microphones with positions; give them where a ruler says they are (positions: one [x, y, z] for "
            "each channel), or name an array's file with --array",
            str(file),
        )
    key = ("microphones", "positions") if hasattr(body, "microphones") else ("streams", "microphones", "positions")
    return ConfiguredArray(
        array_at(positions, args.body, f"{file}: {'.'.join(key)}"),
        str(args.robot),
        file,
        key,
        microphones if isinstance(microphones, SoundInputConfig) else None,
    )


def _with_body(array: MicrophoneArray, body_m: float | None) -> MicrophoneArray:
    return array if body_m is None else MicrophoneArray(array.positions, body_m=body_m)

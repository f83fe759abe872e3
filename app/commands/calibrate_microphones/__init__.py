"""``hbba calibrate microphones``: positions and gains of an array's microphones, by claps around it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from app.base.errors import ConfigError
from app.commands.arguments import real, whole
from app.commands.output import add_json, print_json
from app.commands.parser import Parser

if TYPE_CHECKING:
    from app.commands.calibrate_microphones.arrays import ConfiguredArray
    from app.modules.perception.voices.array_calibration.results import Calibration

COMMAND = "hbba calibrate microphones"


def make_parser() -> Parser:
    """The parser of its arguments."""
    parser = Parser(
        prog=COMMAND,
        description="Measure where the microphones of an array are, and how sensitive, by claps around it: 1 to 2 m "
        "away, each from another side, some high and some low (around a flat array, all at its height). The claps come "
        "from the sound card, or from a recording. Microphones that hear nothing, noise or the same as another are "
        "named, and so are channels in another order than configured. Nothing is written without --write. Exit code 0 "
        "if the array is calibrated or confirmed, 1 if the claps do not suffice, 2 if a file cannot be read.",
    )
    parser.add_argument(
        "file",
        nargs="?",
        metavar="FILE",
        help="a recording with claps: WAV, FLAC, Ogg, MP3, a log, or a recording's name (default: the sound card)",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--array", type=Path, metavar="ARRAY", help="the configured positions: a file of an array, or a name as irl1"
    )
    where.add_argument(
        "--robot", type=Path, metavar="ROBOT", help="... or a robot's file with microphones, or a name as webcam"
    )
    parser.add_argument(
        "--body", type=real(0, 1), metavar="M", help="radius (m) of the body between the microphones, as a sphere"
    )
    parser.add_argument(
        "--input",
        metavar="NAME",
        help="name or number of the sound card's input (default: the robot's, or the default)",
    )
    parser.add_argument("--rate", type=whole(16_000, 192_000), metavar="HZ", help="its samples a second (48000)")
    parser.add_argument("--claps", type=whole(8, 60), default=16, metavar="N", help="how many to wait for (default 16)")
    parser.add_argument(
        "--channel", metavar="CHANNEL", help="the channel of a log (default: microphones, or the only one)"
    )
    parser.add_argument(
        "--write",
        action="store_true",
        help="write the positions into the file of --array or --robot, if the verdict is so",
    )
    add_json(parser)
    return parser


def run(args: argparse.Namespace) -> int:
    from app.commands.calibrate_microphones.arrays import configured_array
    from app.commands.calibrate_microphones.listening import claps_in
    from app.commands.calibrate_microphones.report import document_of, print_report
    from app.commands.calibrate_microphones.sound_inputs import opened
    from app.commands.detect.sounds import NoRecording
    from app.logs.log import LogError
    from app.robots.devices.image_inputs import InputUnavailable

    configured = configured_array(args)
    if args.write and configured is None:
        raise ConfigError("--write: name the file to be written with --array or --robot")
    try:
        with opened(args, configured) as sound:
            configured = configured or sound.array
            claps = claps_in(sound, configured.array, args.claps)
    except (NoRecording, LogError, InputUnavailable) as failure:
        print(f"{COMMAND}: {args.file or 'sound card'}: {failure}", file=sys.stderr)
        return 2
    from app.modules.perception.voices.array_calibration.calibration import calibrate
    from app.modules.perception.voices.array_calibration.results import NotEnough, Verdict

    try:
        result = calibrate(claps, configured.array)
    except NotEnough as failure:
        if args.json:
            print_json(
                {"array": configured.name, "claps_heard": len(claps), "verdict": "repeat", "reasons": [str(failure)]}
            )
        else:
            print(f"Not calibrated: {failure}.")
        return 1
    written = _written(configured, result) if args.write else None
    if args.json:
        print_json(document_of(configured, len(claps), result) | {"written": written})
    else:
        print_report(configured, len(claps), result, written)
    return 1 if result.verdict is Verdict.REPEAT else 0


def _written(configured: ConfiguredArray, result: Calibration) -> Path | None:
    """Write the positions where they are configured; None if the verdict is against it. Raises ConfigError."""
    from app.base.yaml_edit import replace_numbers
    from app.base.yaml_source import KeyPath
    from app.modules.perception.voices.array_calibration.results import Verdict

    if result.verdict is not Verdict.ADOPT or configured.file is None:
        return None
    numbers: dict[KeyPath, str] = {
        (*configured.key, channel, axis): f"{value:.4f}"
        for channel, position in enumerate(result.positions.tolist())
        for axis, value in enumerate(position)
    }
    replace_numbers(configured.file, numbers)
    return configured.file

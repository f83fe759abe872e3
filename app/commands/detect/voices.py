"""``hbba detect voices FILE… --array ARRAY``: voices with their directions in recordings of several microphones."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.arguments import file_named, real, whole
from app.commands.detect.outputs import exit_code, find_files, make_folder, unused
from app.commands.detect.sounds import (
    FORMATS,
    SUFFIXES,
    NoRecording,
    blocks_of,
    listen_through,
    open_recording,
)
from app.commands.detect.voices_report import TrackSummary, Writer, percept, print_tables, summary
from app.commands.output import add_json, print_json
from app.commands.packaged import config_file
from app.commands.progress import Progress

if TYPE_CHECKING:
    import numpy as np
    import soundfile
    from numpy.typing import NDArray

    from app.modules.perception.voices.array_check import ArrayCheck
    from app.modules.perception.voices.microphone_array import MicrophoneArray

COMMAND = "hbba detect voices"
#: Lowest sample rate (Hz) at which voices can be distinguished from other sounds.
LEAST_RATE = 16_000


def add_parser(kinds: Any) -> None:
    parser = kinds.add_parser(
        "voices",
        help="who speaks from where, in recordings of several microphones",
        description="Locate and follow the sources of sound in recordings of several microphones, say which of them "
        "are voices, and write each by itself. Azimuth is 0 in front and positive to the left, elevation positive "
        "upward, in the axes of the array's file. Exit code 0 if a source was found, 1 if none was, 2 if a file cannot "
        "be read or does not fit the array.",
    )
    parser.add_argument(
        "files",
        nargs="+",
        type=file_named,
        metavar="FILE",
        help=f"a recording ({FORMATS}), one channel per microphone, or a folder of them",
    )
    parser.add_argument(
        "--array",
        type=Path,
        required=True,
        metavar="ARRAY",
        help="where the microphones are, in the order of the channels, and the body between them: a file, or a "
        "name as irl1",
    )
    parser.add_argument("--microphones", type=whole(2, 32), metavar="N", help="use only the N that locate best")
    parser.add_argument(
        "--height",
        type=real(0, 10, rule="must be a height from 0 to 10 (m)"),
        metavar="M",
        help="height of the array's middle above the floor (m): adds distances",
    )
    add_json(parser, "print one JSON document instead: also what was heard when")
    parser.add_argument("--separate", type=Path, metavar="FOLDER", help="write each source by itself into FOLDER")


def run(args: argparse.Namespace) -> int:
    paths = find_files(args.files, SUFFIXES, "recording")
    from app.modules.perception.voices.microphone_array import load_array

    args.array = config_file(args.array, "array", "--array")
    array = load_array(args.array)
    if args.microphones is not None and args.microphones > len(array):
        raise ConfigError(f"--microphones: {args.array} has {len(array)}, not {args.microphones}")
    if args.separate is not None:
        make_folder(args.separate, "--separate")
    names: set[str] = set()

    def listen(path: Path, progress: Progress) -> dict[str, Any]:
        return _listen(path, array, args, names, progress)

    documents = listen_through(paths, "listen for voices", COMMAND, "tracks", listen)
    if args.json:
        print_json({"array": args.array, "files": documents})
    else:
        print_tables(documents)
    return exit_code(documents, "tracks")


def _listen(
    path: Path, array: MicrophoneArray, args: argparse.Namespace, names: set[str], progress: Progress
) -> dict[str, Any]:
    """The document of one file. Raises NoRecording."""
    with open_recording(path) as recording:
        channels, rate = recording.channels, recording.samplerate
        if channels != len(array):
            raise NoRecording(
                f"has {channels} channel{'s' * (channels != 1)}, but {args.array} has {len(array)} microphones; there "
                "must be one channel for each"
            )
        if rate < LEAST_RATE:
            raise NoRecording(f"has {rate} samples a second; at least {LEAST_RATE} are needed")
        return _heard(path, recording, array=array, args=args, names=names, progress=progress)


def _heard(
    path: Path,
    recording: soundfile.SoundFile,
    array: MicrophoneArray,
    args: argparse.Namespace,
    names: set[str],
    progress: Progress,
) -> dict[str, Any]:
    # Imports take half a second; unusable files are reported before.
    import numpy as np

    from app.modules.perception.voices.microphone_array import MicrophoneArray
    from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline

    rate = recording.samplerate
    lifted = array.positions - array.middle + np.array([0.0, 0.0, args.height or 0.0])
    used = MicrophoneArray(lifted, body_m=array.body_m).subset(args.microphones or len(array))
    pipeline = VoicePipeline(used, rate, PipelineSettings(separation=args.separate is not None))
    tracks: dict[int, TrackSummary] = {}
    timeline: list[dict[str, Any]] = []
    writer = None if args.separate is None else Writer(args.separate, unused(path.stem, names))
    done = 0
    try:
        for block in blocks_of(recording, pipeline.step, progress):
            sources, separated = pipeline.process(_filled(block, pipeline.step), done / rate, done)
            done += len(block)
            for source in sources.sources:
                tracks.setdefault(source.track, TrackSummary(sources.stamp)).add(sources.stamp, source)
            if args.json:
                timeline.append(percept(sources, args.height is not None))
            if writer is not None and separated is not None:
                writer.write(separated)
    finally:
        if writer is not None:
            writer.close()
    heard = {track: sound for track, sound in tracks.items() if sound.active}
    if writer is not None:
        for track, sound in heard.items():
            sound.file = writer.files.get(track)
    document: dict[str, Any] = {
        "file": str(path),
        "duration_s": round(done / rate, 3),
        "rate": rate,
        "microphones": len(used),
    }
    document |= _array_report(path, pipeline.array_check, args.array)
    document["tracks"] = [summary(track, sound, args.height is not None) for track, sound in heard.items()]
    return document | ({"timeline": timeline} if args.json else {})


def _array_report(path: Path, check: ArrayCheck, array: Path) -> dict[str, Any]:
    """The check of the array by the sound; a warning goes to standard error if the array cannot be right."""
    if not check.moments:
        return {}
    report: dict[str, Any] = {"array_explains": round(check.share, 3), "array_moments": check.moments}
    if check.failed:
        share, least = 100 * check.share, 100 * check.least_share
        report["warning"] = (
            f"the microphones' positions do not explain what they heard ({share:.0f} % of what they agree on in "
            f"{check.moments} loud moments, where right positions explain {least:.0f} % and more), so directions are "
            f"wrong: check the order of the channels, the positions (m) and body_m in {array}, or measure them with "
            "`hbba calibrate microphones`"
        )
        print(f"{COMMAND}: {path}: {report['warning']}", file=sys.stderr)
    return report


def _filled(block: NDArray[np.int16], length: int) -> NDArray[np.int16]:
    import numpy as np

    return np.pad(block, ((0, length - len(block)), (0, 0)))

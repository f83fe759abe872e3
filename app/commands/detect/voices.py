"""``hbba detect voices FILE… --array ARRAY``: who speaks from where, in anyone's recordings of several microphones."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.arguments import file_named, number, whole
from app.commands.detect.outputs import make_folder, unused
from app.commands.detect.voices_report import Heard, Writer, percept, print_tables, summary
from app.commands.output import add_json, print_json
from app.commands.packaged import config_file
from app.commands.progress import Progress, shown
from app.errors import ConfigError
from app.plain_file import check_plain

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from app.messages import SeparatedSound, SoundSources
    from app.modules.perception.voices.array import MicrophoneArray
    from app.modules.perception.voices.pipeline import VoicePipeline

COMMAND = "hbba detect voices"
#: Slower sound has no room for what tells voices apart.
LEAST_RATE = 16_000
#: No sound card gives more.
MOST_RATE = 384_000
FORMATS = "WAV, FLAC, Ogg"


def add_parser(kinds: Any) -> None:
    """Declare ``hbba detect voices``."""
    parser = kinds.add_parser(
        "voices",
        help="who speaks from where, in recordings of several microphones",
        description="Locate and follow the sources of sound in recordings of several microphones, tell which of them "
        "are voices, and write each by itself. Azimuth is 0 in front and positive to the left, elevation positive "
        "upward, in the axes of the array's file. Exit code 0 if a source was found, 1 if none was, 2 if a file cannot "
        "be read or does not fit the array.",
    )
    parser.add_argument(
        "files", nargs="+", type=file_named, metavar="FILE", help=f"a recording ({FORMATS}), one channel per microphone"
    )
    parser.add_argument(
        "--array",
        type=Path,
        required=True,
        metavar="ARRAY",
        help="where the microphones are, in the order of the channels, and the body between them: a file, or a "
        "name as irl1",
    )
    parser.add_argument("--microphones", type=whole(2, 32), metavar="N", help="use only the N that tell most")
    parser.add_argument(
        "--height", type=_height, metavar="M", help="of the array's middle above the floor (m): tells also distances"
    )
    add_json(parser, "print one JSON document instead: also what was heard when")
    parser.add_argument("--separate", type=Path, metavar="FOLDER", help="write each source by itself into FOLDER")


def run(args: argparse.Namespace) -> int:
    """Listen to the files. Raises ConfigError."""
    from app.modules.perception.voices.array import load_array

    args.array = config_file(args.array, "array", "--array")
    array = load_array(args.array)
    if args.microphones is not None and args.microphones > len(array):
        raise ConfigError(f"--microphones: {args.array} has {len(array)}, not {args.microphones}")
    for path in args.files:
        if not path.exists():
            raise ConfigError(f"there is no file {path}")
        if path.is_dir():
            raise ConfigError(f"{path} is a folder; name the recordings in it: {path}/*.wav")
    if args.separate is not None:
        make_folder(args.separate, "--separate")
    documents = []
    names: set[str] = set()
    with shown("listen for voices") as progress:
        for done, path in enumerate(dict.fromkeys(args.files)):
            try:
                documents.append(_listen(path, array, args, names, _part(progress, done, len(args.files), path.name)))
            except _NoRecording as failure:
                print(f"{COMMAND}: {failure}", file=sys.stderr)
                documents.append({"file": str(path), "error": str(failure).removeprefix(f"{path}: "), "tracks": []})
    if args.json:
        print_json({"array": args.array, "files": documents})
    else:
        print_tables(documents)
    if any("error" in document for document in documents):
        return 2
    return 0 if any(document["tracks"] for document in documents) else 1


class _NoRecording(Exception):
    """A file that cannot be listened to; the message names it and says why."""


def _height(text: str) -> float:
    value = number(text)
    if value is None or not 0 <= value <= 10:
        raise argparse.ArgumentTypeError(f"must be a height from 0 to 10 (m), not {text!r}")
    return value


def _part(progress: Progress, before: int, files: int, name: str) -> Progress:
    """Progress within one file of several."""

    def tell(done: float, total: float, text: str = "") -> None:
        progress(before + (done / total if total else 1), files, text or name)

    return tell


def _listen(
    path: Path, array: MicrophoneArray, args: argparse.Namespace, names: set[str], progress: Progress
) -> dict[str, Any]:
    """One file's document. Raises _NoRecording."""
    import numpy as np
    import soundfile

    from app.modules.perception.voices.array import MicrophoneArray
    from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline

    try:
        check_plain(path)
        recording = soundfile.SoundFile(path)
    except soundfile.LibsndfileError as failure:
        reason = failure.error_string.rstrip(".")
        raise _NoRecording(f"{path}: cannot be read as a recording ({FORMATS}): {reason}") from None
    except OSError as failure:
        raise _NoRecording(f"{path}: cannot be read: {failure.strerror or failure}") from None
    except TypeError:  # what soundfile raises for .raw: nothing in it says how it is to be read
        raise _NoRecording(f"{path}: cannot be read as a recording: samples without a header; make it a WAV") from None
    with recording:
        channels, rate = recording.channels, recording.samplerate
        if channels != len(array):
            raise _NoRecording(
                f"{path}: has {channels} channel{'s' * (channels != 1)}, but {args.array} has {len(array)} "
                "microphones; there must be one channel for each"
            )
        if not recording.frames:
            raise _NoRecording(f"{path}: holds no sound")
        if rate < LEAST_RATE:
            raise _NoRecording(f"{path}: has {rate} samples a second; at least {LEAST_RATE} are needed")
        if rate > MOST_RATE:
            raise _NoRecording(f"{path}: says it has {rate} samples a second; at most {MOST_RATE} are taken")
        lifted = array.positions - array.middle + np.array([0.0, 0.0, args.height or 0.0])
        used = MicrophoneArray(lifted, body_m=array.body_m).subset(args.microphones or len(array))
        pipeline = VoicePipeline(used, rate, PipelineSettings(separation=args.separate is not None))
        tracks: dict[int, Heard] = {}
        timeline: list[dict[str, Any]] = []
        writer = None if args.separate is None else Writer(args.separate, unused(path.stem, names))
        try:
            for sources, separated in _blocks(recording, pipeline, progress, path):
                for source in sources.sources:
                    tracks.setdefault(source.track, Heard(sources.stamp)).add(sources.stamp, source)
                if args.json:
                    timeline.append(percept(sources, args.height is not None))
                if writer is not None and separated is not None:
                    writer.write(separated)
        finally:
            if writer is not None:
                writer.close()
        duration = recording.tell() / rate
    heard = {track: told for track, told in tracks.items() if told.active}
    if writer is not None:
        for track, told in heard.items():
            told.file = writer.files.get(track)
    document = {
        "file": str(path),
        "duration_s": round(duration, 3),
        "rate": rate,
        "microphones": len(used),
        "tracks": [summary(track, told, args.height is not None) for track, told in heard.items()],
    }
    return document | ({"timeline": timeline} if args.json else {})


def _blocks(
    recording: Any, pipeline: VoicePipeline, progress: Progress, path: Path
) -> Iterator[tuple[SoundSources, SeparatedSound | None]]:
    """All that is heard, block by block; the last one is filled up with silence. Raises _NoRecording."""
    import soundfile

    done = 0
    while True:
        try:
            block: NDArray[np.int16] = recording.read(pipeline.step, dtype="int16", always_2d=True)
        except soundfile.LibsndfileError as failure:
            raise _NoRecording(f"{path}: cannot be read beyond {done / pipeline.rate:.1f} s: {failure}") from None
        if not len(block):
            return
        yield pipeline.process(_filled(block, pipeline.step), done / pipeline.rate, done)
        done += len(block)
        progress(done, recording.frames)


def _filled(block: NDArray[np.int16], length: int) -> NDArray[np.int16]:
    import numpy as np

    return np.pad(block, ((0, length - len(block)), (0, 0)))

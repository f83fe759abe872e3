"""``hbba detect noises FILE…``: times of claps, bangs and calls in recordings."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.arguments import file_named, real, whole
from app.commands.detect.outputs import exit_code, find_files, make_folder, unused
from app.commands.detect.sounds import (
    BLOCK,
    FORMATS,
    SUFFIXES,
    NoRecording,
    blocks_of,
    listen_through,
    open_recording,
)
from app.commands.output import add_json, print_json
from app.commands.progress import Progress

if TYPE_CHECKING:
    import soundfile

    from app.commands.detect.noises_plot import Levels
    from app.modules.perception.loud_noises import LoudnessRule

COMMAND = "hbba detect noises"
#: Sample rate (Hz) for which the rule's constants were chosen; sound of another rate is resampled to it.
RATE = 48_000
LEAST_RATE = 8_000


def add_parser(kinds: Any) -> None:
    parser = kinds.add_parser(
        "noises",
        help="claps, bangs and calls in recordings",
        description="Find loud noises (claps, bangs, calls) in recordings, by the robot's own rule: what begins "
        "suddenly and is far louder than the background. Each channel is listened to; what several of them hear is "
        "one noise. Exit code 0 if a noise was found, 1 if none was, 2 if a file cannot be read or does not exist.",
    )
    parser.add_argument(
        "files",
        nargs="+",
        type=file_named,
        metavar="FILE",
        help=f"a recording ({FORMATS}) of any number of channels, or a folder of them",
    )
    parser.add_argument("--microphone", type=whole(0), metavar="N", help="listen to this channel alone, from 0")
    parser.add_argument(
        "--ratio",
        type=real(1.0, 1e6, above=True),
        default=20.0,
        metavar="R",
        help="so many times the background's energy is loud (default 20)",
    )
    parser.add_argument(
        "--floor",
        type=real(-120.0, 0.0),
        default=-32.0,
        metavar="DB",
        help="nothing below it is loud, in dB of full scale (default -32)",
    )
    parser.add_argument(
        "--hold-off",
        type=real(0.0, 60.0),
        default=0.25,
        metavar="S",
        help="quiet between two noises, in s (default 0.25)",
    )
    parser.add_argument(
        "--window",
        type=real(0.05, 600.0),
        default=200 * 512 / RATE,
        metavar="S",
        help="the background is the mean over so long, in s (default 2.13)",
    )
    parser.add_argument(
        "--history",
        type=real(0.0, 600.0),
        default=100 * 512 / RATE,
        metavar="S",
        help="no noise is found so long at first, in s (default 1.07)",
    )
    add_json(parser)
    parser.add_argument(
        "--draw", type=Path, metavar="FOLDER", help="write a plot of the level against the threshold into FOLDER"
    )


def run(args: argparse.Namespace) -> int:
    paths = find_files(args.files, SUFFIXES, "recording")
    if args.draw is not None:
        make_folder(args.draw, "--draw")
    names: set[str] = set()

    def listen(path: Path, progress: Progress) -> dict[str, Any]:
        return _listen(path, args, names, progress)

    documents = listen_through(paths, "listen for loud noises", COMMAND, "noises", listen)
    if args.json:
        settings = {
            "ratio": args.ratio,
            "floor_db": args.floor,
            "hold_off_s": args.hold_off,
            "window_s": round(args.window, 4),
            "history_s": round(args.history, 4),
        }
        print_json(settings | {"files": documents})
    else:
        _print_tables(documents)
    return exit_code(documents, "noises")


def _listen(path: Path, args: argparse.Namespace, names: set[str], progress: Progress) -> dict[str, Any]:
    """The document of one file. Raises NoRecording."""
    with open_recording(path) as recording:
        rate, channels = recording.samplerate, recording.channels
        if rate < LEAST_RATE:
            raise NoRecording(f"has {rate} samples a second; at least {LEAST_RATE} are needed")
        if args.microphone is not None and args.microphone >= channels:
            raise NoRecording(f"has {channels} channel{'s' * (channels != 1)}, so no --microphone {args.microphone}")
        from app.modules.perception.loud_noises import LoudnessRule

        rule = LoudnessRule.lasting(
            RATE,
            args.ratio,
            floor_db=args.floor,
            window_s=args.window,
            history_s=args.history,
            hold_off_s=args.hold_off,
        )
        chosen = list(range(channels)) if args.microphone is None else [args.microphone]
        levels = None
        if args.draw is not None:
            from app.commands.detect.noises_plot import Levels

            levels = Levels()
        noises, duration_s = _noises(recording, chosen, rule, levels, progress)
    if levels is not None:
        levels.draw(args.draw / f"{unused(path.stem, names)}.noises.png", path.name, noises)
    return {
        "file": str(path),
        "duration_s": round(duration_s, 3),
        "rate": rate,
        "channels": channels,
        "noises": noises,
    }


def _noises(
    recording: soundfile.SoundFile, chosen: list[int], rule: LoudnessRule, levels: Levels | None, progress: Progress
) -> tuple[list[dict[str, Any]], float]:
    """The noises with their times, and the recording's duration (s). Raises NoRecording."""
    import numpy as np

    from app.modules.perception.loud_noises import FRAME, BandEnergy, OnsetDetector, onset_of

    rate = recording.samplerate
    ears = [(microphone, BandEnergy(RATE), OnsetDetector(rule)) for microphone in chosen]
    at_rate = _Resampled(rate, len(chosen))
    rest = np.zeros((0, len(chosen)), np.int16)
    noises: list[dict[str, Any]] = []
    last, number_of_frame, done = -math.inf, 0, 0
    for block in blocks_of(recording, BLOCK, progress):
        done += len(block)
        samples = np.concatenate([rest, at_rate.process(block[:, chosen])])
        frames = len(samples) // FRAME
        rest = samples[frames * FRAME :]
        for frames_of_all in samples[: frames * FRAME].reshape(frames, FRAME, -1):
            time_s = max(0.0, number_of_frame * FRAME / RATE - at_rate.delay_s)
            for column, (microphone, band, detector) in enumerate(ears):
                frame = frames_of_all[:, column]
                energy, threshold = band.frame(frame), detector.threshold
                if levels is not None:
                    levels.add(time_s, energy, threshold)
                noise = onset_of(frame, energy, detector)
                if noise is None:
                    continue
                row = {
                    "time_s": round(time_s, 3),
                    "ratio": round(noise.ratio, 1),
                    "level_db": round(noise.level_db, 1),
                    "microphone": microphone,
                }
                if number_of_frame - last >= rule.hold_off:
                    noises.append(row)
                elif noise.ratio > noises[-1]["ratio"]:
                    noises[-1] = row | {"time_s": noises[-1]["time_s"]}
                last = number_of_frame
            number_of_frame += 1
    return noises, done / rate


class _Resampled:
    """Sound of ``rate`` brought to :data:`RATE`, ``delay_s`` later, as it comes."""

    def __init__(self, rate: int, channels: int) -> None:
        self._each: list[Any] = []
        self.delay_s = 0.0
        if rate != RATE:
            from app.modules.perception.voices.resampling import Resampler

            self._each = [Resampler(rate, RATE) for _ in range(channels)]
            self.delay_s = self._each[0].delay_s

    def process(self, block: Any) -> Any:
        """The next samples (N, C) int16, at the new rate."""
        import numpy as np

        if not self._each:
            return block
        columns = [one.process(block[:, k].astype(np.float32)) for k, one in enumerate(self._each)]
        return np.clip(np.rint(np.stack(columns, axis=1)), -32768, 32767).astype(np.int16)


def _print_tables(documents: list[dict[str, Any]]) -> None:
    for document in documents:
        if "error" in document:
            continue
        noises = document["noises"]
        print(f"{document['file']}: {document['duration_s']:.1f} s, {len(noises)} loud noise{'s' * (len(noises) != 1)}")
        if noises:
            print(f"  {'at s':>8}  {'background':>12}  {'level':>7}  microphone")
        for noise in noises:
            times = f"{noise['ratio']:.0f} times"
            level = f"{noise['level_db']:.0f} dB"
            print(f"  {noise['time_s']:8.2f}  {times:>12}  {level:>7}  {noise['microphone']:10d}")

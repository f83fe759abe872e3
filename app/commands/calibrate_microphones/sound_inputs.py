"""The sound in which claps are looked for: a sound file, a log, or the sound card."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.commands.arguments import find_log
from app.commands.calibrate_microphones.arrays import ConfiguredArray, array_at
from app.commands.detect.sounds import BLOCK, NoRecording, blocks_of, open_recording
from app.commands.progress import Progress, shown
from app.messages import Audio
from app.robots.devices.config import SoundInputConfig

#: Less is too coarse for time differences.
LEAST_RATE = 16_000
_LOGS = (".mcap", ".bag", ".db3")
_USUAL = "microphones"
_RATE = 48_000


@dataclass(frozen=True, slots=True, eq=False)
class Sound:
    """Sound of several channels at ``rate`` (Hz): ``blocks`` are samples (N, C) int16, each with the number of samples
    lost before it. ``array``: as configured. ``live``: whether it is heard now."""

    rate: int
    blocks: Iterator[tuple[NDArray[np.int16], int]]
    array: ConfiguredArray
    live: bool


@contextmanager
def opened(args: argparse.Namespace, configured: ConfiguredArray | None) -> Iterator[Sound]:
    """The sound that the arguments name. Raises ConfigError, NoRecording, LogError, InputUnavailable."""
    if args.file is None:
        if configured is None:
            raise ConfigError("name the array with --array or --robot: its positions are where the measuring begins")
        with _device(args, configured) as sound:
            yield sound
        return
    path = Path(args.file)
    if path.is_dir() or path.suffix in _LOGS or not path.exists():
        with _log(find_log(args.file), args, configured) as sound:
            yield sound
    elif configured is None:
        raise ConfigError(f"{path}: says nothing of where microphones are: name the array with --array or --robot")
    else:
        with _file(path, configured) as sound:
            yield sound


@contextmanager
def _file(path: Path, configured: ConfiguredArray) -> Iterator[Sound]:
    with open_recording(path) as recording, shown("listen for claps") as progress:
        _check(recording.channels, recording.samplerate, configured)
        blocks = ((block, 0) for block in blocks_of(recording, BLOCK, progress))
        yield Sound(recording.samplerate, blocks, configured, live=False)


@contextmanager
def _log(path: Path, args: argparse.Namespace, configured: ConfiguredArray | None) -> Iterator[Sound]:
    from app.logs.open import open_log

    log = open_log(path)
    try:
        with shown("listen for claps") as progress:
            channel = _channel(log.info.channels, args.channel)
            messages = (logged.message for logged in log.messages(channels=[channel]))
            first = next(messages, None)
            if first is None:
                raise NoRecording(f"holds no sound on the channel {channel}")
            found = configured or ConfiguredArray(
                array_at(first.p_BM, args.body, f"{path}: {channel}"), f"{channel} of it"
            )
            _check(first.samples.shape[1], first.rate, found)
            blocks = _of_messages(first, messages, progress, log.info.channels[channel].count)
            yield Sound(first.rate, blocks, found, live=False)
    finally:
        log.close()


def _channel(channels: Any, named: str | None) -> str:
    sounds = [name for name, channel in channels.items() if issubclass(channel.message_type, Audio)]
    if named is not None and named not in sounds:
        raise ConfigError(f"--channel: there is no sound on a channel {named!r}; {_those(sounds)}")
    if named is None and _USUAL not in sounds and len(sounds) != 1:
        raise ConfigError(f"--channel: which one holds the claps? {_those(sounds)}")
    return named or (_USUAL if _USUAL in sounds else sounds[0])


def _those(sounds: list[str]) -> str:
    return f"sound is on {', '.join(sounds)}" if sounds else "the log holds no sound"


def _of_messages(
    first: Audio, messages: Iterator[Audio], progress: Progress, count: int
) -> Iterator[tuple[NDArray[np.int16], int]]:
    yield first.samples, 0
    due = first.first_sample + len(first.samples)
    for number, audio in enumerate(messages, 2):
        if (audio.rate, audio.samples.shape[1]) != (first.rate, first.samples.shape[1]):
            raise NoRecording("changes its rate or its number of channels; cut it there (hbba log cut)")
        # A source that began again counts from 0 again.
        yield audio.samples, audio.first_sample - due if audio.first_sample >= due else audio.rate
        due = audio.first_sample + len(audio.samples)
        progress(number, count)


@contextmanager
def _device(args: argparse.Namespace, configured: ConfiguredArray) -> Iterator[Sound]:
    from app.robots.devices.sound import open_sound

    if configured.input is not None:
        config = configured.input
    elif configured.key == ("streams", _USUAL, "positions"):
        raise ConfigError(f"{configured.name}: a simulated body has no sound card; give a recording of its microphones")
    else:
        config = SoundInputConfig(channels=len(configured.array), rate=_RATE)
    update: dict[str, Any] = {"loop": False}
    update |= {} if args.rate is None else {"rate": args.rate}
    update |= {} if args.input is None else {"source": args.input}
    source = open_sound(SoundInputConfig.model_validate(config.model_dump() | update))
    try:
        _check(source.channels, source.rate, configured)
        yield Sound(source.rate, _of_device(source, config.frame_samples), configured, live=True)
    finally:
        source.close()


def _of_device(source: Any, count: int) -> Iterator[tuple[NDArray[np.int16], int]]:
    source.skip()
    while (samples := source.read(count)) is not None:
        # How many were lost is not known; that some were is enough.
        yield samples, source.rate if source.gap else 0


def _check(channels: int, rate: int, configured: ConfiguredArray) -> None:
    if channels != len(configured.array):
        raise NoRecording(
            f"has {channels} channel{'s' * (channels != 1)}, but {configured.name} has {len(configured.array)} "
            "microphones; there must be one channel for each"
        )
    if rate < LEAST_RATE:
        raise NoRecording(f"has {rate} samples a second; at least {LEAST_RATE} are needed")

"""Sound as WAV."""

from __future__ import annotations

import wave
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import fields, is_dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from app.log_tools.export.target import Format, Target, Write
from app.logs.log import LogError, LoggedChannel

#: A piece that begins so much later than the one before ended has others missing in between; less is jitter.
GAP_S = 0.02
#: Time (s) without sound after which a source has ended; a later one of its number is another.
GONE_S = 10.0
#: Of samples: the format's own lengths are of 32 bits, and count some bytes of header.
MOST_BYTES = 2**32 - 1024


def is_audio(message_type: type[Any]) -> bool:
    """Whether messages of this class hold sound: ``samples`` (N, C) int16 from ``stamp`` (s) on, ``rate`` (Hz).

    With ``tracks`` too (C of them), columns are sources that come and go, each with a number of its own.
    """
    return _has(message_type, {"stamp", "samples", "rate"})


class Wav(Format):
    """Writes ``<channel>.wav``, or ``<channel>/track-<number>.wav`` for each source of separated sound.

    Missing pieces become silence, so that the file has the duration of the sound; a source's file begins with its first
    sample. Another source that gets the same number 10 s later or more has a file of its own, ``track-<number>-2.wav``.
    """

    def accepts(self, message_type: type[Any]) -> bool:
        return is_audio(message_type)

    @contextmanager
    def writer(self, channel: LoggedChannel, target: Target) -> Iterator[Write]:
        """Write one file, or one for each track; rate and number of channels are those of the first message."""
        with ExitStack() as files:
            if _has(channel.message_type, {"tracks"}):
                yield files.enter_context(_Tracks(channel.name, target.subfolder(channel.name))).write
            else:
                target.check(f"{channel.name}.wav")
                sound = files.enter_context(_file(channel.name, target, f"{channel.name}.wav"))
                yield lambda message: sound.write(message.stamp, message.samples, message.rate)


class _Tracks:
    """A file for each source, closed when the source has gone: in hours there are more than can be open at once."""

    def __init__(self, channel: str, folder: Target) -> None:
        self._channel = channel
        self._folder = folder
        self._open: dict[int, tuple[ExitStack, _Sound]] = {}
        self._heard: dict[int, float] = {}
        self._files: Counter[int] = Counter()

    def __enter__(self) -> _Tracks:
        return self

    def __exit__(self, *failure: Any) -> None:
        left = ExitStack()
        for closing, _ in self._open.values():
            left.push(closing)
        left.__exit__(*failure)

    def write(self, message: Any) -> None:
        """Add a piece of each source's sound. Raises LogError."""
        for track in [track for track, heard in self._heard.items() if message.stamp - heard > GONE_S]:
            self._open.pop(track)[0].close()
            del self._heard[track]
        for column, track in enumerate(message.tracks):
            if track not in self._open:
                self._open[track] = self._opened(track)
            self._open[track][1].write(message.stamp, message.samples[:, column : column + 1], message.rate)
            self._heard[track] = message.stamp

    def _opened(self, track: int) -> tuple[ExitStack, _Sound]:
        self._files[track] += 1
        again = f"-{self._files[track]}" if self._files[track] > 1 else ""
        closing = ExitStack()
        file = _file(f"track {track} of {self._channel}", self._folder, f"track-{track:03d}{again}.wav")
        return closing, closing.enter_context(file)


class _Sound:
    """One WAV file being written to ``stream``."""

    def __init__(self, title: str, stream: BinaryIO) -> None:
        self._title = title
        self._stream = stream
        self._wave: wave.Wave_write | None = None
        self._first = 0.0
        self._rate = self._channels = 0
        self._frames = self._silence = 0

    @property
    def begun(self) -> bool:
        """Whether there is anything in it."""
        return self._wave is not None

    def write(self, stamp: float, samples: NDArray[np.int16], rate: int) -> None:
        """Add a piece (N, C). Raises LogError for another rate or number of channels than before, and for more than
        the format holds."""
        channels = samples.shape[1]
        if self._wave is None:
            self._wave = wave.open(self._stream, "wb")  # noqa: SIM115  # closed by `close`, header and all
            self._first, self._rate, self._channels = stamp, rate, channels
            self._wave.setnchannels(channels)
            self._wave.setsampwidth(2)
            self._wave.setframerate(rate)
        if (rate, channels) != (self._rate, self._channels):
            raise LogError(
                f"{self._title} changes from {self._channels} channels at {self._rate} Hz to {channels} at "
                f"{rate} Hz at {stamp - self._first:.3f} s; cut the log there"
            )
        missing = round((stamp - self._first) * rate) - self._frames
        missing = missing if missing > GAP_S * rate else 0
        if 2 * channels * (self._frames + missing + len(samples)) > MOST_BYTES:
            raise LogError(
                f"{self._title} is longer than the 4 GB that a WAV file holds: export a part of it, with --from and "
                f"--to no more than {MOST_BYTES // (2 * channels * rate) // 60} minutes apart"
            )
        for begin in range(0, missing, rate):
            self._wave.writeframesraw(bytes(2 * channels * min(rate, missing - begin)))
        self._frames, self._silence = self._frames + missing, self._silence + missing
        self._wave.writeframesraw(np.ascontiguousarray(samples, "<i2").tobytes())
        self._frames += len(samples)

    def close(self) -> None:
        """Write the header."""
        if self._wave is not None:
            self._wave.close()

    def summary(self) -> str:
        """A summary for people."""
        quiet = f", {self._silence / self._rate:.1f} s of it silence for what is missing" if self._silence else ""
        channels = "1 channel" if self._channels == 1 else f"{self._channels} channels"
        return f"{self._frames / self._rate:.1f} s, {channels} at {self._rate} Hz{quiet}"


@contextmanager
def _file(title: str, target: Target, name: str) -> Iterator[_Sound]:
    """A file that is there when all went well and something was written."""
    with target.file(name) as part, part.open("wb") as stream:
        sound = _Sound(title, stream)
        try:
            yield sound
        finally:
            sound.close()
        if not sound.begun:  # without a message it has no header to close with
            part.unlink()
            return
    target.written.append(f"{target.folder / name}: {sound.summary()}")


def _has(message_type: type[Any], names: set[str]) -> bool:
    return is_dataclass(message_type) and names <= {f.name for f in fields(message_type)}

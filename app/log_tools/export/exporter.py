"""One export: selects channels and times, and passes every message to the writer of its channel."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from app.log_tools.cut import no_such_channel
from app.log_tools.export.csv import Csv
from app.log_tools.export.kinds import KINDS
from app.log_tools.export.mp4 import Mp4
from app.log_tools.export.pcd import Pcd
from app.log_tools.export.png import Png
from app.log_tools.export.target import Format, Target, Write
from app.log_tools.export.wav import Wav
from app.logs.log import Log, LogError, LoggedChannel
from app.logs.output_file import Progress, disk_trouble, unwatched
from app.logs.stamps import SECOND

FORMATS: Mapping[str, Callable[[], Format]] = {"png": Png, "mp4": Mp4, "csv": Csv, "wav": Wav, "pcd": Pcd}


@dataclass(frozen=True, slots=True)
class Wish:
    """The request: messages that arrived from ``begin`` to ``end`` (robot's clock, s; None: all).

    ``channels`` None: all that ``kind`` can hold. Of each channel one message in ``every``, beginning with the first.
    """

    kind: str
    folder: Path
    channels: Collection[str] | None = None
    begin: float | None = None
    end: float | None = None
    every: int = 1
    force: bool = False


@dataclass(frozen=True, slots=True)
class Exported:
    """The result: one line for people for each file in ``folder``."""

    folder: Path
    written: tuple[str, ...]

    def lines(self) -> list[str]:
        """For people."""
        return list(self.written) or [f"{self.folder}: nothing was written; no message lies in that time"]


def export(log: Log, wish: Wish, progress: Progress = unwatched) -> Exported:
    """Write the files. Blocks; ``progress`` counts nanoseconds of the log.

    Raises LogError where a channel is not there or cannot be written so, for a damaged log, where files are there
    already or the disk is full. Whole files written until then stay, half ones do not.
    """
    if wish.kind == "wav" and wish.every != 1:
        raise LogError("sound with pieces left out is no sound: leave --every away")
    form = FORMATS[wish.kind]()
    channels = _chosen(log, wish, form)
    try:
        wish.folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise LogError(f"{wish.folder} is a file, no folder; -o names another") from None
    except OSError as failure:
        raise disk_trouble(failure, wish.folder) from failure
    begin, end = _span(log, wish)
    target = Target(wish.folder, wish.force, begin, end)
    rounds = 2 if form.surveys else 1
    try:
        if form.surveys:
            _pass(log, wish, {name: partial(form.survey, name) for name in channels}, _share(progress, 0, rounds))
        with ExitStack() as stack:
            writers = {name: stack.enter_context(form.writer(each, target)) for name, each in channels.items()}
            _pass(log, wish, writers, _share(progress, rounds - 1, rounds))
    except OSError as failure:
        raise disk_trouble(failure, wish.folder / "files") from failure
    return Exported(wish.folder, tuple(target.written))


def _pass(log: Log, wish: Wish, takers: Mapping[str, Write], progress: Progress) -> None:
    """Give every message that is wanted to the taker of its channel."""
    begin, end = _span(log, wish)
    length = max(1, round((end - begin) * SECOND))
    met: Counter[str] = Counter()
    for logged in log.messages(begin, tuple(takers)):
        if logged.at > end:
            break
        progress(min(length, max(0, round((logged.at - begin) * SECOND))), length)
        if met[logged.channel] % wish.every == 0:
            takers[logged.channel](logged.message)
        met[logged.channel] += 1
    progress(length, length)


def _span(log: Log, wish: Wish) -> tuple[float, float]:
    """The time (robot's clock, s) that is asked for."""
    info = log.info
    return info.begin if wish.begin is None else wish.begin, info.end if wish.end is None else wish.end


def _share(progress: Progress, part: int, parts: int) -> Progress:
    """The progress of one round of several of equal length."""
    return lambda done, total: progress(part * total + done, parts * total)


def _chosen(log: Log, wish: Wish, form: Format) -> dict[str, LoggedChannel]:
    """The channels to write, each by its name. Raises LogError."""
    info = log.info
    fitting = {
        name: channel
        if channel.rate_hz or not info.duration_s
        else replace(channel, rate_hz=channel.count / info.duration_s)
        for name, channel in info.channels.items()
        if form.accepts(channel.message_type)
    }
    if unknown := set(wish.channels or ()) - info.channels.keys():
        raise no_such_channel(info.path, unknown, info.channels.keys())
    if not fitting:
        lacks = "has no sound" if wish.kind == "wav" else f"has nothing that {wish.kind} could hold"
        raise LogError(f"{info.path}: the log {lacks} ({wish.kind}: {KINDS[wish.kind]})")
    for name in wish.channels or ():
        if name not in fitting:
            kind = info.channels[name].message_type.__name__
            could = ", ".join(sorted(fitting))
            raise LogError(f"{info.path}: {name} holds {kind}, which {wish.kind} does not; it could hold {could}")
    return fitting if wish.channels is None else {name: fitting[name] for name in wish.channels}

"""The reports of ``hbba log``: the list of recordings, the contents of one, the result of a repair."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from app.commands.output import aligned, print_json
from app.log_tools.repair import NOTHING, RepairReport, examine
from app.logs.catalog import Recording
from app.logs.importers.remap import Remap, Undecided
from app.logs.log import LogError, LogInfo
from app.logs.mcap.channel_sizes import channel_bytes
from app.logs.mcap.open_file import is_being_written
from app.logs.mcap.structure import is_mcap
from app.logs.open import open_log
from app.logs.output_file import Progress, unwatched

State = Literal["complete", "recording", "unfinished", "damaged"]

#: The meaning of a recording's state, and a remedy.
_ADVICE: Mapping[State, str] = {
    "complete": "",
    "recording": "is being recorded now; look again when that has ended",
    "unfinished": "was not closed: its program was killed, or its disk was full. `hbba log repair` makes it readable",
    "damaged": "is damaged. `hbba log repair` saves what is whole",
}


@dataclass(frozen=True, slots=True)
class ChannelContents:
    """A channel in a log: ``rate_hz`` measured, ``nominal_hz`` of the table; ``bytes`` before compression."""

    name: str
    type: str
    messages: int
    rate_hz: float | None
    nominal_hz: float | None
    bytes: int | None


@dataclass(frozen=True, slots=True)
class LogContents:
    """The contents of a log. Times in seconds of the robot's clock. ``problem`` says why ``state`` is not
    ``complete``."""

    path: str
    format: str
    state: State
    problem: str
    begin: float
    end: float
    duration_s: float
    bytes: int
    messages: int
    facts: Mapping[str, str] = field(default_factory=dict)
    channels: tuple[ChannelContents, ...] = ()
    files: tuple[Mapping[str, Any], ...] = ()
    ignored: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    #: Why a bag's topics are no channels yet, and a remap file that would make them some.
    undecided: str = ""


def look_into(path: Path, remap: Remap | None = None, progress: Progress = unwatched) -> LogContents:
    """All facts of a log. Raises LogError if it is no log, ConfigError if ``remap`` does not fit.

    Reads the end section of the file; the whole file only without one (``progress`` counts the bytes).
    """
    try:
        log = open_log(path, remap)
        try:
            info, manifest = log.info, log.manifest
        finally:
            log.close()
    except Undecided as doubt:
        return replace(_described(doubt.info), undecided=str(doubt).removeprefix(f"{doubt.info.path}: "))
    except LogError as failure:
        if not is_mcap(path):
            raise
        return _unreadable(path, failure, progress)
    sizes = channel_bytes(path) if is_mcap(path) else {}
    channels = tuple(
        ChannelContents(
            channel.name,
            channel.message_type.__name__,
            messages=channel.count,
            rate_hz=channel.count / info.duration_s if info.duration_s > 0 else None,
            nominal_hz=channel.rate_hz,
            bytes=sizes.get(channel.name),
        )
        for channel in sorted(info.channels.values(), key=lambda channel: channel.name)
    )
    return replace(
        _described(info),
        messages=sum(channel.messages for channel in channels),
        facts=dict(manifest.facts),
        channels=channels,
        files=tuple({"name": f.name, "media_type": f.media_type, "bytes": len(f.data)} for f in manifest.files),
    )


def _described(info: LogInfo) -> LogContents:
    return LogContents(
        path=str(info.path),
        format=info.format,
        state="complete",
        problem="",
        begin=info.begin,
        end=info.end,
        duration_s=info.duration_s,
        bytes=info.bytes,
        messages=0,
        ignored=dict(info.ignored),
        notes=info.notes,
    )


def _unreadable(path: Path, failure: LogError, progress: Progress) -> LogContents:
    """Facts of an MCAP file that does not open. Raises LogError if there are none, or if it is not damaged."""
    found = examine(path, progress)
    if found.healthy:
        raise failure
    state: State = "damaged" if found.finished else "unfinished"
    if is_being_written(path):
        state = "recording"
    elif not found.messages and not found.attachments:
        raise LogError(f"{path}: {NOTHING}")
    return LogContents(
        path=str(path),
        format="MCAP",
        state=state,
        problem=_ADVICE[state],
        begin=found.begin,
        end=found.end,
        duration_s=found.end - found.begin,
        bytes=found.bytes,
        messages=found.messages,
    )


def print_contents(contents: LogContents, *, as_json: bool) -> None:
    """To standard output."""
    if as_json:
        print_json(asdict(contents))
        return
    facts = contents.facts
    rows = [("format", contents.format)]
    rows += [(name, facts[name]) for name in ("robot", "program", "version", "commit", "host") if facts.get(name)]
    rows += [
        ("begin", date(contents.begin)),
        ("length", clock(contents.duration_s)),
        ("size", size(contents.bytes)),
    ]
    if contents.problem:
        rows += [("state", f"{contents.state}; readable are {contents.messages} records over the length above")]
    print(contents.path)
    for name, value in rows:
        print(f"  {name:<8} {value}")
    if contents.problem:
        print(f"\nThis log {contents.problem}.")
        return
    if contents.undecided:
        print("\nTopics")
        for topic, what in contents.ignored.items():
            print(f"  {topic}: {what}")
        print(f"\n{contents.undecided}")
        return
    head = ("channel", "type", "messages", "Hz", "nominal", "bytes")
    print("", *aligned([head, *_channel_rows(contents.channels)], {2, 3, 4, 5}), sep="\n")
    if contents.files:
        print("\nAttached")
        for attached in contents.files:
            print(f"  {attached['name']}  {size(attached['bytes'])}")
    if contents.notes:
        print("\nAssumed")
        for note in contents.notes:
            print(f"  {note}")
    if contents.ignored:
        print("\nNot read")
        for topic, reason in contents.ignored.items():
            print(f"  {topic}: {reason}")


def _channel_rows(channels: Iterable[ChannelContents]) -> list[tuple[str, ...]]:
    return [
        (
            channel.name,
            channel.type,
            str(channel.messages),
            "–" if channel.rate_hz is None else f"{channel.rate_hz:.4g}",
            "–" if channel.nominal_hz is None else f"{channel.nominal_hz:.4g}",
            "–" if channel.bytes is None else size(channel.bytes),
        )
        for channel in channels
    ]


def recordings_document(found: Sequence[Recording], folder: Path, free_bytes: int) -> dict[str, Any]:
    """The same list for programs, with the fields that REST gives."""
    recordings = [
        {
            "name": each.name,
            "bytes": each.bytes,
            "duration_s": each.duration_s,
            "began": each.begin,
            "state": each.state,
            "robot": each.robot,
        }
        for each in found
    ]
    return {"folder": str(folder), "free_bytes": free_bytes, "recordings": recordings}


def print_recordings(found: Sequence[Recording], folder: Path, free_bytes: int) -> None:
    """Print the recordings of ``folder``, on a disk with ``free_bytes`` left, to standard output."""
    if not found:
        print(f"There are no recordings in {folder} yet.")
        return
    rows = [
        (
            each.name,
            date(each.modified if each.begin is None else each.begin),
            "–" if each.duration_s is None else clock(each.duration_s),
            size(each.bytes),
            each.robot or "–",
            each.state,
        )
        for each in found
    ]
    print(*aligned([("name", "began", "length", "size", "robot", "state"), *rows], {2, 3}), sep="\n")
    print(f"\n{len(found)} in {folder}, {size(free_bytes)} free")


def repair_lines(report: RepairReport) -> list[str]:
    """The result of a repair, for people."""
    length = clock(report.end - report.begin)
    if report.healthy:
        return [f"{report.path}: there is nothing to repair: {report.messages} records over {length} are well"]
    recovered = f"{report.messages} records of {report.channels} topics over {length}"
    lines = [f"{report.out}: recovered {recovered}, and {report.attachments} attached files"]
    lost = [loss for loss in report.losses if not loss.index]
    if not lost:
        ended = "No message is missing: only the index at the end was."
        lines.append(ended if report.ended else "Nothing that is in the file is lost: only its end is not there.")
    lines += [
        f"  byte {loss.offset}: {loss.what}: {size(loss.bytes)} unreadable, {_missing(loss.seconds)}" for loss in lost
    ]
    if lost:
        share = 100 * report.unreadable_bytes / report.bytes
        lines.append(f"Unreadable in all: at most {size(report.unreadable_bytes)} ({share:.1f} % of the file)")
    if report.orphans:
        lines.append(f"{report.orphans} records were left out: their type is lost.")
    if not report.ended:
        lines.append(
            f"The recording ends at {length}, where the file does. Whether anything came after cannot be known: it was "
            "never written, or was cut off."
        )
    return lines


def _missing(seconds: float | None) -> str:
    if seconds is None:
        return "how much time is missing is not known"
    return "less than 1 ms is missing" if seconds < 0.001 else f"at most {seconds:.3f} s are missing"


def date(seconds: float) -> str:
    """Local date and time of ``seconds`` (Unix)."""
    return datetime.fromtimestamp(seconds).astimezone().strftime("%Y-%m-%d %H:%M:%S %Z")


def clock(seconds: float) -> str:
    """A length: ``12.3 s``, ``3:07.5``, ``1:02:03``."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    tenths = round(10 * seconds)
    minutes, tenths = divmod(tenths, 600)
    if minutes < 60:
        return f"{minutes}:{tenths / 10:04.1f}"
    return f"{minutes // 60}:{minutes % 60:02}:{tenths // 10:02}"


def size(count: int) -> str:
    """Bytes for people, decimal."""
    value, unit = float(count), "B"
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if value < 999.5 or unit == "TB":
            break
        value /= 1000
    return f"{count} B" if unit == "B" else f"{value:.3g} {unit}"

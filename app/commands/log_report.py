"""What ``hbba log`` says: the list of recordings, the contents of one, what a repair found."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from rich.console import Console
from rich.table import Table

from app.recording.catalog import Recording
from app.recording.library import RecordingLibrary
from app.recording.log import LogError
from app.recording.mcap_file import is_being_written
from app.recording.open import open_log
from app.recording.repair import RepairReport, examine
from app.recording.salvage import MAGIC
from app.recording.sizes import channel_bytes

State = Literal["complete", "recording", "unfinished", "damaged"]

#: What a recording's state means, and what to do.
_ADVICE: Mapping[State, str] = {
    "complete": "",
    "recording": "is being recorded now; look again when that has ended",
    "unfinished": "was not closed: its program was killed, or its disk was full. `hbba log repair` makes it readable",
    "damaged": "is damaged. `hbba log repair` saves what is whole",
}


@dataclass(frozen=True, slots=True)
class ChannelContents:
    """A channel in a log: ``rate_hz`` as it came, ``nominal_hz`` as it should; ``bytes`` before compression."""

    name: str
    type: str
    messages: int
    rate_hz: float | None
    nominal_hz: float | None
    bytes: int | None


@dataclass(frozen=True, slots=True)
class Contents:
    """What is in a log. Times in seconds of the robot's clock. ``problem`` says why ``state`` is not ``complete``."""

    path: str
    format: str
    state: State
    problem: str
    begin: float
    end: float
    duration_s: float
    bytes: int
    messages: int
    facts: Mapping[str, str]
    channels: tuple[ChannelContents, ...]
    files: tuple[Mapping[str, Any], ...]
    ignored: Mapping[str, str]


def look_into(path: Path, remap: Any = None) -> Contents:
    """Everything there is to say. Raises LogError where it is no log at all, ConfigError for a bad ``remap``."""
    try:
        log = open_log(path, remap)
    except LogError as failure:
        if not _is_mcap(path):
            raise
        return _unreadable(path, failure)
    try:
        info, manifest = log.info, log.manifest
    finally:
        log.close()
    sizes = channel_bytes(path) if _is_mcap(path) else {}
    channels = tuple(
        ChannelContents(
            channel.name,
            channel.message_type.__name__,
            channel.count,
            channel.count / info.duration_s if info.duration_s > 0 else None,
            channel.rate_hz,
            sizes.get(channel.name),
        )
        for channel in sorted(info.channels.values(), key=lambda channel: channel.name)
    )
    return Contents(
        path=str(path),
        format=info.format,
        state="complete",
        problem="",
        begin=info.begin,
        end=info.end,
        duration_s=info.duration_s,
        bytes=info.bytes,
        messages=sum(channel.messages for channel in channels),
        facts=dict(manifest.facts),
        channels=channels,
        files=tuple({"name": f.name, "media_type": f.media_type, "bytes": len(f.data)} for f in manifest.files),
        ignored=dict(info.ignored),
    )


def _is_mcap(path: Path) -> bool:
    if not path.is_file():
        return False
    try:
        with path.open("rb") as stream:
            return stream.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def _unreadable(path: Path, failure: LogError) -> Contents:
    """What can be told of an MCAP file that does not open. Raises ``failure`` where it is well, but not for us."""
    found = examine(path)
    if found.healthy:
        raise failure
    state: State = "damaged" if found.finished else "unfinished"
    if is_being_written(path):
        state = "recording"
    return Contents(
        path=str(path),
        format="MCAP",
        state=state,
        problem=_ADVICE[state],
        begin=found.begin,
        end=found.end,
        duration_s=found.end - found.begin,
        bytes=found.bytes,
        messages=found.messages,
        facts={},
        channels=(),
        files=(),
        ignored={},
    )


def print_contents(contents: Contents, *, as_json: bool) -> None:
    """To standard output."""
    if as_json:
        print(json.dumps(asdict(contents), indent=2, ensure_ascii=False))
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
    console = Console(soft_wrap=True)
    print()
    console.print(_channel_table(contents.channels))
    if contents.files:
        print("\nAttached")
        for attached in contents.files:
            print(f"  {attached['name']}  {size(attached['bytes'])}")
    if contents.ignored:
        print("\nNot read")
        for topic, reason in contents.ignored.items():
            print(f"  {topic}: {reason}")


def _channel_table(channels: Iterable[ChannelContents]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("channel")
    table.add_column("type")
    for name in ("messages", "Hz", "nominal", "bytes"):
        table.add_column(name, justify="right")
    for channel in channels:
        table.add_row(
            channel.name,
            channel.type,
            str(channel.messages),
            "–" if channel.rate_hz is None else f"{channel.rate_hz:.4g}",
            "–" if channel.nominal_hz is None else f"{channel.nominal_hz:g}",
            "–" if channel.bytes is None else size(channel.bytes),
        )
    return table


def print_recordings(recordings: Iterable[Recording], library: RecordingLibrary) -> None:
    """The list, to standard output."""
    found = list(recordings)
    if not found:
        print(f"There are no recordings in {library.folder} yet.")
        return
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for name, justify in (("name", "left"), ("began", "left"), ("length", "right"), ("size", "right")):
        table.add_column(name, justify="right" if justify == "right" else "left")
    table.add_column("robot")
    table.add_column("state")
    for each in found:
        table.add_row(
            each.name,
            date(each.modified if each.begin is None else each.begin),
            "–" if each.duration_s is None else clock(each.duration_s),
            size(each.bytes),
            each.robot or "–",
            _state(each, library),
        )
    Console(soft_wrap=True).print(table)
    print(f"\n{len(found)} in {library.folder}, {size(library.free_bytes())} free")


def _state(recording: Recording, library: RecordingLibrary) -> State:
    if recording.complete:
        return "complete"
    try:
        return "recording" if is_being_written(library.path(recording.name)) else "unfinished"
    except OSError:
        return "unfinished"


def repair_lines(report: RepairReport) -> list[str]:
    """What a repair found and did, for people."""
    length = clock(report.end - report.begin)
    if report.healthy:
        return [f"{report.path}: there is nothing to repair: {report.messages} records over {length} are well"]
    recovered = f"{report.messages} records of {report.channels} topics over {length}"
    lines = [f"{report.out}: recovered {recovered}, and {report.attachments} attached files"]
    lost = [loss for loss in report.losses if not loss.index]
    if not lost:
        lines.append("No message is missing: only the index at the end was.")
    lines += [
        f"  byte {loss.offset}: {loss.what}: {size(loss.bytes)} unreadable, {_missing(loss.seconds)}" for loss in lost
    ]
    if lost:
        share = 100 * report.unreadable_bytes / report.bytes
        lines.append(f"Missing in all: {size(report.unreadable_bytes)} ({share:.2g} % of the file)")
    if report.orphans:
        lines.append(f"{report.orphans} records were left out: nothing tells any more what they are.")
    return lines


def _missing(seconds: float | None) -> str:
    return "how much time is missing is not known" if seconds is None else f"at most {seconds:.3f} s are missing"


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

"""Cuts a piece out of an MCAP log: its records unchanged, and before them the state at its begin."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from mcap.reader import SeekingReader
from mcap.records import Channel, Message
from mcap.summary import Summary

from app.base.plain_file import open_plain
from app.logs import layout
from app.logs.log import LogError
from app.logs.mcap.bounds import BoundedReader, check_chunks
from app.logs.mcap.structure import DAMAGE, MAGIC
from app.logs.output_file import McapCopy, Progress, check_new, durable, replacing, unwatched
from app.logs.ros.converters import converter
from app.logs.ros.record import MAIN
from app.logs.stamps import SECOND, from_ns, to_ns
from app.messages import Desires, Divisors, IntentionReport, Landmarks, ModuleRecord

#: Messages that stay true until the next on their channel; a log's own word (``layout.LATCHED``) goes before.
STATES = frozenset(kind.__name__ for kind in (Desires, IntentionReport, Divisors, Landmarks, ModuleRecord))
#: Topics of other programs that are written once and stay valid, in spite of their quality of service.
STANDING_TOPICS = frozenset({"/tf_static", "/robot_description"})


@dataclass(frozen=True, slots=True)
class CutReport:
    """Result of a cut: ``begin`` and ``end`` requested, within the log (robot's clock, s).

    ``messages`` are records of the piece, ``standing`` the state records from before ``begin`` that were put at its
    begin.
    """

    out: Path
    begin: float
    end: float
    messages: int
    standing: int
    bytes: int


def cut(
    path: Path,
    out: Path,
    begin: float | None = None,
    end: float | None = None,
    channels: Collection[str] | None = None,
    *,
    force: bool = False,
    progress: Progress = unwatched,
) -> CutReport:
    """Copy the records of ``path`` that arrived from ``begin`` to ``end`` (robot's clock, s, both included) to ``out``.

    ``channels`` (None: all) are channels of a recording of ours, or topics. Payloads, attachments and metadata are
    copied as they are. For channels of states (desires, intention, divisors, landmarks, modules; latched topics of
    other programs) the last message before ``begin`` comes first, as if it had arrived then. Works on any program's
    finished MCAP file. Blocks. Raises LogError for a channel that is not there, a time outside, a damaged or
    unfinished log, or where ``out`` cannot be written.
    """
    check_new(out, force)
    if out.exists() and out.samefile(path):
        raise LogError(f"{path}: a log cannot be cut into itself; -o names another file")
    with _opened(path) as (stream, summary):
        first, last = _span(path, summary)
        begin_ns = first if begin is None else max(first, to_ns(begin))
        end_ns = last if end is None else min(last, to_ns(end))
        if begin_ns > last or end_ns < first or end_ns < begin_ns:
            raise LogError(
                f"{path}: nothing lies between the times named; the log lasts {(last - first) / SECOND:.3f} s"
            )
        wanted = _wanted(path, summary, channels)
        with replacing(out, force) as part, part.open("wb") as target:
            stream.seek(0)
            reader = BoundedReader(stream, validate_crcs=True)
            try:
                header = reader.get_header()
                copy = McapCopy(target, header.profile, header.library)
                for metadata in reader.iter_metadata():
                    copy.metadata(metadata.name, metadata.metadata)
                for file in reader.iter_attachments():
                    copy.attachment(file.log_time, file.create_time, file.name, file.media_type, file.data)
                for channel in wanted.values():
                    copy.declare(channel, summary.schemas[channel.schema_id] if channel.schema_id else None)
                standing = list(_standing(reader, wanted, begin_ns))
                for message in standing:
                    copy.message(message.channel_id, begin_ns, message.data, message.publish_time, message.sequence)
                count = 0
                topics = sorted({channel.topic for channel in wanted.values()})
                if topics:
                    for _, channel, message in reader.iter_messages(
                        topics, starting_at=begin_ns, ending_before=end_ns + 1
                    ):
                        progress(message.log_time - begin_ns, max(1, end_ns - begin_ns))
                        copy.message(channel.id, message.log_time, message.data, message.publish_time, message.sequence)
                        count += 1
                copy.finish()
            except DAMAGE as failure:
                raise _damaged(path, failure) from failure
            progress(1, 1)
            durable(target)
    return CutReport(
        out, from_ns(begin_ns), end=from_ns(end_ns), messages=count, standing=len(standing), bytes=out.stat().st_size
    )


def span(path: Path) -> tuple[float, float]:
    """When the first and the last message of a finished MCAP file arrived (robot's clock, s). Raises LogError."""
    with _opened(path) as (_, summary):
        first, last = _span(path, summary)
    return from_ns(first), from_ns(last)


def _standing(reader: SeekingReader, wanted: dict[int, Channel], begin: int) -> Iterator[Message]:
    """State messages still valid at ``begin``, in the order they arrived."""
    found: list[Message] = []
    for channel in wanted.values():
        if not _is_state(channel):
            continue
        earlier = reader.iter_messages(channel.topic, ending_before=begin, reverse=True)
        last: dict[str, Message] = {}
        for _, source, message in earlier:
            if source.id != channel.id:
                continue
            last.setdefault(_subject(channel, message), message)
            if not _has_subjects(channel):
                break
        found += last.values()
    yield from sorted(found, key=lambda message: message.log_time)


def _is_state(channel: Channel) -> bool:
    metadata = channel.metadata
    if layout.LATCHED in metadata:
        return metadata[layout.LATCHED] == "true"
    if metadata.get(layout.MESSAGE) in STATES or channel.topic in STANDING_TOPICS:
        return True
    # ROS 2's word for a latched topic, as `ros2 bag record` writes it: 1 or the name.
    offered = metadata.get("offered_qos_profiles", "")
    return "durability: 1" in offered or "durability: transient_local" in offered


def _has_subjects(channel: Channel) -> bool:
    """Whether each message is about one of several subjects, each of which has a state of its own."""
    # Several publishers latch one static transform each on one topic.
    return channel.metadata.get(layout.MESSAGE) == ModuleRecord.__name__ or channel.topic == "/tf_static"


def _subject(channel: Channel, message: Message) -> str:
    if channel.metadata.get(layout.MESSAGE) == ModuleRecord.__name__:
        record = converter(channel.metadata[layout.CHANNEL], ModuleRecord).decode({MAIN: message.data})
        return record.module if isinstance(record, ModuleRecord) else ""
    return f"{message.log_time} {message.sequence}" if channel.topic == "/tf_static" else ""


def _wanted(path: Path, summary: Summary, channels: Collection[str] | None) -> dict[int, Channel]:
    """Channels of the file by id: those named, by our name or by topic, with all topics that carry them."""
    if channels is None:
        return dict(summary.channels)
    names = {
        number: {channel.topic, channel.metadata.get(layout.CHANNEL, channel.topic)}
        for number, channel in summary.channels.items()
    }
    known = set().union(*names.values()) if names else set()
    if unknown := sorted(set(channels) - known):
        ours = {
            channel.metadata.get(layout.CHANNEL, channel.topic)
            for channel in summary.channels.values()
            if layout.DERIVED not in channel.metadata
        }
        raise no_such_channel(path, unknown, ours)
    return {number: summary.channels[number] for number, mine in names.items() if mine & set(channels)}


def no_such_channel(path: Path, unknown: Collection[str], known: Collection[str]) -> LogError:
    """That a log has no such channel, and which it has."""
    missing = ", ".join(sorted(unknown))
    return LogError(f"{path}: there is no channel {missing}; there are {', '.join(sorted(known)) or 'none'}")


def _span(path: Path, summary: Summary) -> tuple[int, int]:
    statistics = summary.statistics
    if statistics is not None and statistics.message_count:
        return statistics.message_start_time, statistics.message_end_time
    if summary.chunk_indexes:
        return (
            min(index.message_start_time for index in summary.chunk_indexes),
            max(index.message_end_time for index in summary.chunk_indexes),
        )
    raise LogError(f"{path}: the log has no messages")


@contextmanager
def _opened(path: Path) -> Iterator[tuple[IO[bytes], Summary]]:
    """The file and its summary. Raises LogError where it is none, unfinished or damaged."""
    try:
        with open_plain(path) as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise LogError(f"{path}: is not MCAP inside, and only MCAP files can be cut")
            try:
                stream.seek(0)
                summary = BoundedReader(stream).get_summary()
            except DAMAGE as failure:
                raise LogError(
                    f"{path}: was not closed, or is damaged; make it whole with: hbba log repair {path}"
                ) from failure
            if summary is None:
                raise LogError(f"{path}: has no summary; make one with: hbba log repair {path}")
            check_chunks(path, stream, summary)
            yield stream, summary
    except OSError as failure:
        raise LogError(f"{path}: cannot be read: {failure.strerror or failure}") from failure


def _damaged(path: Path, failure: BaseException) -> LogError:
    why = f"{type(failure).__name__}: {failure}"
    return LogError(f"{path}: is damaged ({why}); save what is whole with: hbba log repair {path}")

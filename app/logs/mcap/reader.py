"""Reading our own recordings: MCAP files laid out as ``app.logs.layout`` says."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import cached_property
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.reader import SeekingReader
from mcap.records import Chunk, ChunkIndex, Statistics
from mcap.summary import Summary

from app.base.plain_file import open_plain
from app.logs import layout as mcap_layout
from app.logs.log import LogError, Logged, LoggedChannel, LogInfo
from app.logs.manifest import AttachedFile, Manifest
from app.logs.mcap.bounds import BoundedReader, check_chunks, records_of
from app.logs.mcap.damage import LogDamaged, missing, place
from app.logs.mcap.structure import DAMAGE, MAGIC, RECORD_HEAD, is_closed
from app.logs.ros.decoder import DecodableContents, Decoder, StoredTopic, contents
from app.logs.stamps import from_ns, to_ns

FORMAT = "HBBA MCAP"

#: Of a file that is only read, offsets beyond its end are damage too.
_DAMAGE = (*DAMAGE, OSError)


class McapLog:
    """A recording of this program, opened for reading; implements ``app.logs.log.Log``."""

    def __init__(self, path: Path) -> None:
        """Open ``path`` and read its summary.

        Raises LogError where there is no such file, or it is no recording of ours, unfinished or damaged.
        """
        self._path = path
        try:
            self._file = open_plain(path)  # closed by close()
        except OSError as error:
            raise LogError(f"{path} cannot be read: {error.strerror}") from error
        try:
            self._reader, self._summary = self._open()
            self._contents = self._topics()
            self.info = self._describe()
        except _DAMAGE as error:
            self._file.close()
            raise self._damaged("its summary", error) from error
        except BaseException:
            self._file.close()
            raise

    @cached_property
    def manifest(self) -> Manifest:
        """The files and facts attached. Raises LogError where they are damaged."""
        try:
            files = tuple(
                AttachedFile(attachment.name, attachment.media_type, attachment.data)
                for attachment in self._reader.iter_attachments()
            )
            facts = {}
            for metadata in self._reader.iter_metadata():
                if metadata.name == mcap_layout.FACTS:
                    facts.update(metadata.metadata)
        except _DAMAGE as error:
            raise self._damaged("what is attached", error) from error
        return Manifest(files, facts)

    def messages(self, begin: float | None = None, channels: Collection[str] | None = None) -> Iterator[Logged]:
        """Messages that arrived at ``begin`` or later, of these channels (None: all), in order of arrival.

        Chunks before ``begin``, and those without a topic that is wanted, are not read. Raises KeyError for a channel
        that the log does not have, LogDamaged for a chunk that cannot be read, LogError for other damage.
        """
        known = self._contents.channels
        decoder = Decoder(known.values() if channels is None else [known[name] for name in channels])
        return self._messages(decoder, None if begin is None else to_ns(begin))

    def close(self) -> None:
        self._file.close()

    def _messages(self, decoder: Decoder, begin_ns: int | None) -> Iterator[Logged]:
        if not decoder.topics:
            return
        records = self._reader.iter_messages(decoder.topics, starting_at=begin_ns)
        log_time = self._statistics.message_start_time if begin_ns is None else begin_ns
        while True:
            try:
                _, channel, record = next(records)
            except StopIteration:
                return
            except _DAMAGE as error:
                raise self._damage(decoder.topics, log_time, error) from error
            log_time = record.log_time
            try:
                made = decoder.add(channel.topic, record.data)
            except ValueError as error:
                raise self._damaged(f"{channel.topic} at {self._place(log_time)}", error) from error
            if made is not None:
                yield Logged(from_ns(log_time), *made)

    def _open(self) -> tuple[SeekingReader, Summary]:
        if self._file.read(len(MAGIC)) != MAGIC:
            raise LogError(f"{self._path} is no MCAP file")
        unfinished = LogError(
            f"{self._path} has no end: it is still being written, or its program was killed."
            f" `hbba log repair {self._path}` makes it readable"
        )
        if not is_closed(self._file):
            raise unfinished
        self._file.seek(0)
        reader = BoundedReader(self._file, validate_crcs=True)
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            raise unfinished
        check_chunks(self._path, self._file, summary)
        return reader, summary

    def _topics(self) -> DecodableContents:
        topics = []
        for channel in self._summary.channels.values():
            schema = self._summary.schemas.get(channel.schema_id)
            name, text = ("", b"") if schema is None else (schema.name, schema.data)
            definition = text.decode("utf-8", "replace")
            topics.append(StoredTopic(channel.topic, name, definition, channel.metadata))
        ours = any(mcap_layout.CHANNEL in topic.metadata for topic in topics)
        if not ours and not self._reader.get_header().library.startswith(mcap_layout.NAME):
            raise LogError(f"{self._path} is an MCAP file, but no recording of this program")
        return contents(topics)

    def _describe(self) -> LogInfo:
        counts: dict[str, int] = {}
        for channel_id, count in self._statistics.channel_message_counts.items():
            topic = self._summary.channels[channel_id].topic
            counts[topic] = counts.get(topic, 0) + count
        channels = {
            name: LoggedChannel(name, channel.message_type, counts.get(channel.main_topic, 0), channel.rate_hz)
            for name, channel in self._contents.channels.items()
        }
        begin, end = self._statistics.message_start_time, self._statistics.message_end_time
        size = self._path.stat().st_size
        return LogInfo(
            self._path,
            FORMAT,
            begin=from_ns(begin),
            end=from_ns(end),
            channels=channels,
            bytes=size,
            ignored=self._contents.ignored,
        )

    @property
    def _statistics(self) -> Statistics:
        statistics = self._summary.statistics
        if statistics is None:
            raise LogError(f"{self._path} has a summary without statistics; `hbba log repair {self._path}` makes them")
        return statistics

    def _damage(self, topics: Collection[str], since_ns: int, error: BaseException) -> LogError:
        """Which of the chunks that hold ``topics``, from ``since_ns`` on, is the damaged one."""
        wanted = {number for number, channel in self._summary.channels.items() if channel.topic in topics}
        for index in sorted(self._summary.chunk_indexes, key=lambda index: index.message_start_time):
            held = index.message_index_offsets.keys()
            if index.message_end_time >= since_ns and (not held or held & wanted) and not self._is_whole(index):
                begin, end = from_ns(index.message_start_time), from_ns(index.message_end_time)
                damage = LogDamaged("", begin, end)
                said = f"{self._path} is damaged: {missing(damage, self.info)}"
                return LogDamaged(f"{said}. `hbba log repair {self._path}` saves what is whole", begin, end)
        return self._damaged(f"what follows {self._place(since_ns)}", error)

    def _is_whole(self, index: ChunkIndex) -> bool:
        try:
            self._file.seek(index.chunk_start_offset + RECORD_HEAD.size)
            records_of(Chunk.read(ReadDataStream(self._file)), validate_crc=True)
        except _DAMAGE:
            return False
        return True

    def _place(self, log_time: int) -> str:
        return place(from_ns(log_time) - self.info.begin)

    def _damaged(self, what: str, error: BaseException) -> LogError:
        why = f"{type(error).__name__}: {error}"
        return LogError(
            f"{self._path} is damaged; {what} cannot be read ({why})."
            f" `hbba log repair {self._path}` saves what is whole"
        )

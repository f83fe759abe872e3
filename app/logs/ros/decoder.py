"""Decodes the topics of a file to messages on channels: the reverse of the encoder."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rosbags.typesys import TypesysError, get_types_from_msg

from app.base.errors import ConfigError
from app.base.extensions import may_be_imported_for_a_log
from app.logs import layout as mcap_layout
from app.logs.ros import typestore
from app.logs.ros.converters import Options, converter
from app.logs.ros.generated import PACKAGE, class_of, package_of, rest_has_defaults
from app.logs.ros.record import MAIN, Converter
from app.logs.ros.record_templates import STAMP
from app.runtime.channel_table import ChannelSpec

log = logging.getLogger("hbba.recording")


@dataclass(frozen=True, slots=True)
class StoredTopic:
    """A topic in a file: ``definition`` is the ``ros2msg`` text of its ``type``."""

    name: str
    type: str
    definition: str
    metadata: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class DecodableChannel:
    """A channel that can be read: its message class, nominal rate (Hz, None unknown) and topics by part.

    ``main_type`` is the ROS type of its main part, ``definition`` that part's, where the class, or one within it, has
    got more fields since (None: it is today's).
    """

    name: str
    message_type: type[Any]
    rate_hz: float | None
    topics: Mapping[str, str]
    main_type: str
    definition: str | None = None

    @property
    def main_topic(self) -> str:
        """The topic that has one record for each message."""
        return self.topics[MAIN]


@dataclass(frozen=True, slots=True)
class DecodableContents:
    """The readable content of a file: ``channels`` by name; topics ``ignored``, and why."""

    channels: Mapping[str, DecodableChannel]
    ignored: Mapping[str, str] = field(default_factory=dict)


def contents(topics: Iterable[StoredTopic]) -> DecodableContents:
    """Sort the topics of a file into channels that this program can read and topics it cannot."""
    ignored: dict[str, str] = {}
    of_channel: dict[str, list[StoredTopic]] = {}
    for topic in topics:
        channel = topic.metadata.get(mcap_layout.CHANNEL)
        if channel is not None:
            of_channel.setdefault(channel, []).append(topic)
        elif mcap_layout.DERIVED not in topic.metadata:
            ignored[topic.name] = "another program wrote it"
    channels: dict[str, DecodableChannel] = {}
    for name, stored in of_channel.items():
        try:
            channels[name] = _channel(name, stored)
        except _Unreadable as reason:
            ignored.update({topic.name: str(reason) for topic in stored})
    return DecodableContents(channels, ignored)


class Decoder:
    """Puts messages of some channels together from their records, given in the order they were written."""

    def __init__(self, channels: Iterable[DecodableChannel]) -> None:
        self._lanes: dict[str, tuple[_Lane, str]] = {}
        for channel in channels:
            options = Options(main_type=channel.main_type, definition=channel.definition)
            lane = _Lane(channel.name, converter(channel.name, channel.message_type, options))
            for part, topic in channel.topics.items():
                self._lanes[topic] = (lane, part)

    @property
    def topics(self) -> frozenset[str]:
        """The topics whose records it needs."""
        return frozenset(self._lanes)

    def add(self, topic: str, data: bytes) -> tuple[str, Any] | None:
        """Take a record; returns channel and message once that is complete.

        A message with a missing part is skipped, and the first of a channel is logged. Raises ValueError for invalid
        bytes.
        """
        lane, part = self._lanes[topic]
        stamp = data[STAMP : STAMP + 8]
        if part != MAIN:
            if stamp != lane.stamp:
                lane.stamp, lane.parts = stamp, {}
            lane.parts[part] = data
            return None
        # Each converter's main record is the last of its message: parts of another stamp have lost theirs.
        parts = lane.parts if stamp == lane.stamp else {}
        lane.stamp, lane.parts = b"", {}
        parts[MAIN] = data
        message = lane.converter.decode(parts)
        if message is None:
            lane.lose()
            return None
        return lane.channel, message


class _Lane:
    """The parts received so far of the next message on one channel."""

    __slots__ = ("channel", "converter", "lossy", "parts", "stamp")

    def __init__(self, channel: str, codec: Converter) -> None:
        self.channel = channel
        self.converter = codec
        self.stamp = b""
        self.parts: dict[str, bytes] = {}
        self.lossy = False

    def lose(self) -> None:
        if not self.lossy:
            self.lossy = True
            log.warning("messages of %s that have lost a part (their image, their rays) are left out", self.channel)


class _Unreadable(Exception):
    """Why a channel cannot be read, in words."""


def _channel(name: str, stored: list[StoredTopic]) -> DecodableChannel:
    class_name = stored[0].metadata.get(mcap_layout.MESSAGE, "")
    if ":" in class_name and not may_be_imported_for_a_log(class_name):
        package = class_name.partition(":")[0].partition(".")[0]
        raise _Unreadable(f"{class_name!r} is a message of a package {package!r}, which is not installed for hbba")
    try:
        cls = ChannelSpec(type=class_name).message_type
    except KeyError:
        raise _Unreadable(f"this program has no message {class_name!r}") from None
    except ConfigError as failure:
        raise _Unreadable(failure.message) from None
    main_types = [topic.type for topic in stored if topic.metadata.get(mcap_layout.PART, MAIN) == MAIN]
    options = Options(main_type=main_types[0] if main_types else None)
    parts = {topic.part: topic for topic in converter(name, cls, options).topics if topic.part is not None}
    by_part: dict[str, str] = {}
    definition: str | None = None
    for topic in stored:
        part = topic.metadata.get(mcap_layout.PART, MAIN)
        if part not in parts:
            raise _Unreadable(f"this program's {class_name} has no part {part!r}")
        if topic.type != parts[part].type:
            raise _Unreadable(f"this program keeps that part of {class_name} as {parts[part].type}, not {topic.type}")
        if change := _change(topic, cls):
            if part != MAIN or not _has_only_grown(topic, cls):
                raise _Unreadable(f"{class_name} has changed since: {change}")
            definition = topic.definition
        by_part[part] = topic.name
    if MAIN not in by_part:
        raise _Unreadable(f"the topic {parts[MAIN].name}, which says what the others mean, is not in the file")
    return DecodableChannel(
        name, cls, rate_hz=_rate(stored), topics=by_part, main_type=parts[MAIN].type, definition=definition
    )


def _rate(stored: list[StoredTopic]) -> float | None:
    try:
        return float(stored[0].metadata[mcap_layout.RATE_HZ])
    except (KeyError, ValueError):
        return None


def _change(topic: StoredTopic, cls: type[Any]) -> str:
    """Differences between our own types in a topic's definition and those of this version; "" without any."""
    try:
        then = get_types_from_msg(topic.definition, topic.type)
    except TypesysError as error:
        return f"its definition cannot be read ({error})"
    today = typestore.store().fielddefs
    for name, (_, fields) in then.items():
        if not name.startswith(_generated_packages(cls)):
            continue
        short = name.rsplit("/", 1)[1]
        if name not in today:
            return f"it held a {short}"
        before, after = dict(fields), dict(today[name][1])
        if gone := before.keys() - after.keys():
            return f"{short} no longer has {', '.join(sorted(gone))}"
        if new := after.keys() - before.keys():
            return f"{short} now also has {', '.join(sorted(new))}"
        if list(fields) != list(today[name][1]):
            return f"{short} has other types or another order of its fields"
    return ""


def _generated_packages(cls: type[Any]) -> tuple[str, str]:
    """The prefixes of generated types' names: the program's own, and those of the package of ``cls``."""
    return f"{PACKAGE}/", f"{package_of(cls)}/"


def _has_only_grown(topic: StoredTopic, cls: type[Any]) -> bool:
    """Whether fields with defaults were added since to ``cls`` or classes within it, and nothing else has changed."""
    if topic.type != f"{package_of(cls)}/msg/{cls.__name__}":
        return False
    try:
        then = get_types_from_msg(topic.definition, topic.type)
    except TypesysError:
        return False
    today = typestore.store().fielddefs
    for name, (_, fields) in then.items():
        if not name.startswith(_generated_packages(cls)):
            continue
        written, now = list(fields), list(today[name][1])
        if written == now:
            continue
        grown, names = class_of(name), {field for field, _ in written}
        if grown is None or written != [pair for pair in now if pair[0] in names]:
            return False
        if not rest_has_defaults(grown, [field in names for field, _ in now]):
            return False
    return True

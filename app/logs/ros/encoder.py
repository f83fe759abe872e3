"""Encodes messages on channels as records on topics, for a writer of logs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.logs import layout as mcap_layout
from app.logs.ros import typestore
from app.logs.ros.converters import Options, converter
from app.logs.ros.record import MAIN, Converter, Record
from app.logs.stamps import to_ns
from app.runtime.channel_table import ChannelSpec


class Encoder:
    """Encodes messages for one file; it leaves out data that the file holds already. For one thread at a time."""

    def __init__(self, channels: Mapping[str, ChannelSpec], jpeg_quality: int = 90) -> None:
        """``channels``: the program's table, or the rows to be recorded; ``jpeg_quality`` 1 to 100."""
        self._channels = channels
        self._quality = jpeg_quality
        self._converters: dict[str, Converter] = {}
        self._metadata: dict[str, dict[str, str]] = {}

    def encode(self, channel: str, message: Any) -> list[Record]:
        """The records of ``message``, to be written in this order with the same ``log_time``.

        Raises KeyError for a channel that is not in the table, UnrecordableType for a message that ROS has no types
        for, and ValueError for one that is not what its class says.
        """
        known = self._converters.get(channel) or self._open(channel)
        return known.encode(message, to_ns(message.stamp))

    def definition(self, type: str) -> str:
        """``ros2msg`` text of a record's type, with every type it uses. Raises KeyError for one that no record has."""
        return typestore.definition(type)

    def channel_metadata(self, topic: str) -> dict[str, str]:
        """Metadata of the MCAP channel of ``topic`` (see ``app.logs.layout``), a topic of some record."""
        return self._metadata[topic]

    def _open(self, channel: str) -> Converter:
        spec = self._channels[channel]
        opened = converter(channel, spec.message_type, Options(spec.rate_hz, self._quality))
        for topic in opened.topics:
            metadata = {mcap_layout.DERIVED: "true"}
            if topic.part is not None:
                metadata = {mcap_layout.CHANNEL: channel, mcap_layout.MESSAGE: spec.message}
                if topic.part != MAIN:
                    metadata[mcap_layout.PART] = topic.part
                if spec.rate_hz is not None:
                    metadata[mcap_layout.RATE_HZ] = f"{spec.rate_hz:g}"
                if spec.latched:
                    metadata[mcap_layout.LATCHED] = "true"
            self._metadata[topic.name] = metadata
        self._converters[channel] = opened
        return opened

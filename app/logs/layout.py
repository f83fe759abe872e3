"""The layout of a recording as an MCAP file, shared by writer, reader, repair and cut.

Profile ``ros2``: CDR payloads, ``ros2msg`` schemas. One MCAP channel for each topic. ``log_time`` is the arrival
(robot's clock), the same for all records that one message becomes; ``publish_time`` is the capture. The records of a
message are written in the order the encoder gives them, the main one last of its parts: where it is, all are.
``Manifest.files`` are attachments under their names; ``Manifest.facts`` is the metadata record :data:`FACTS`.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

PROFILE = "ros2"
MESSAGE_ENCODING = "cdr"
SCHEMA_ENCODING = "ros2msg"

#: Bytes of records in one chunk before compression: about a frame of RGB-D, so that little is lost and much is packed.
CHUNK_SIZE = 768 * 1024

#: Keys of an MCAP channel's metadata. ``CHANNEL`` and ``MESSAGE``: the channel and message class that it carries.
CHANNEL = "hbba_channel"
MESSAGE = "hbba_message"
#: Which part of a message the topic carries; absent on the topic that has one record for every message.
PART = "hbba_part"
RATE_HZ = "rate_hz"
#: "true" if the newest message stays valid until the next: a reader that begins in the middle needs the last one
#: before.
LATCHED = "latched"
#: "true" on a topic that is only drawn from messages, for viewers, and not read back; it has none of the others.
DERIVED = "hbba_derived"

#: Name of the metadata record that holds ``Manifest.facts``.
FACTS = "hbba"


#: Prefix of the library's name in the file's header.
NAME = "hbba"


def library() -> str:
    """The writing program, as the file's header names it."""
    try:
        return f"{NAME} {version('hbba')}"
    except PackageNotFoundError:
        return NAME

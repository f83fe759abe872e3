"""Bags written by other programs' tools, out of messages written as plain dictionaries.

ROS 1: rosbags' writer. ROS 2 in SQLite: Python's own sqlite3, in the tables that rosbag2 makes. ROS 2 in MCAP:
mcap-ros2-support, which serialises by itself.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer as McapWriter
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer as Bag1Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

ROS1 = get_typestore(Stores.ROS1_NOETIC)
for _name in ("tf/msg/tfMessage", "tf2_msgs/msg/TFMessage"):
    ROS1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", _name))
ROS2 = get_typestore(Stores.ROS2_HUMBLE)

Fields = Mapping[str, Any]


@dataclass(frozen=True)
class Sent:
    """A message as it was recorded: ``at`` (ns), ``type`` as ROS 2 writes it; fields that are not named are zero."""

    at: int
    topic: str
    type: str
    fields: Fields


def header(stamp: int, frame: str) -> Fields:
    """A header of ``stamp`` (ns)."""
    return {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": frame}


def write_ros1(path: Path, messages: Iterable[Sent], compression: str = "") -> Path:
    """A ROS 1 bag."""
    writer = Bag1Writer(path)
    if compression:
        writer.set_compression(Bag1Writer.CompressionFormat[compression.upper()])
    with writer:
        connections: dict[str, Any] = {}
        for sent in messages:
            if sent.topic not in connections:
                connections[sent.topic] = writer.add_connection(sent.topic, sent.type, typestore=ROS1)
            data = ROS1.serialize_ros1(made(ROS1, sent.type, sent.fields), sent.type)
            writer.write(connections[sent.topic], sent.at, bytes(data))
    return path


def write_ros2_sqlite(folder: Path, messages: Iterable[Sent]) -> Path:
    """A ROS 2 bag of the Humble kind: a folder with metadata.yaml and a database without definitions of its types."""
    folder.mkdir()
    database = sqlite3.connect(folder / "run_0.db3")
    database.executescript(
        "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
        " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,"
        " data BLOB NOT NULL);"
        "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
        "INSERT INTO schema VALUES (3, 'humble');"
    )
    topics: dict[str, tuple[int, str]] = {}
    counts: dict[str, int] = {}
    times = []
    for sent in messages:
        if sent.topic not in topics:
            topics[sent.topic] = (len(topics) + 1, sent.type)
            database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (len(topics), sent.topic, sent.type))
        data = bytes(ROS2.serialize_cdr(made(ROS2, sent.type, sent.fields), sent.type))
        row = (topics[sent.topic][0], sent.at, data)
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", row)
        counts[sent.topic] = counts.get(sent.topic, 0) + 1
        times.append(sent.at)
    database.commit()
    database.close()
    rows = "\n".join(
        f"    - topic_metadata: {{name: {name}, type: {kind}, serialization_format: cdr, offered_qos_profiles: ''}}\n"
        f"      message_count: {counts[name]}"
        for name, (_, kind) in topics.items()
    )
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n"
        "  version: 5\n"
        "  storage_identifier: sqlite3\n"
        f"  duration: {{nanoseconds: {max(times) - min(times)}}}\n"
        f"  starting_time: {{nanoseconds_since_epoch: {min(times)}}}\n"
        f"  message_count: {len(times)}\n"
        f"  topics_with_message_count:\n{rows}\n"
        "  compression_format: ''\n"
        "  compression_mode: ''\n"
        "  relative_file_paths: [run_0.db3]\n"
    )
    return folder


def write_ros2_mcap(path: Path, messages: Iterable[Sent]) -> Path:
    """A ROS 2 bag's MCAP file."""
    with open(path, "wb") as file, McapWriter(file, chunk_size=256 * 1024, compression=CompressionType.LZ4) as writer:
        schemas: dict[str, Any] = {}
        for sent in messages:
            if sent.type not in schemas:
                text = ROS2.generate_msgdef(sent.type, ros_version=2)[0]
                schemas[sent.type] = writer.register_msgdef(sent.type, text)
            writer.write_message(sent.topic, schemas[sent.type], plain(ROS2, sent.type, sent.fields), log_time=sent.at)
    return path


def made(store: Typestore, kind: str, fields: Fields) -> Any:
    """The rosbags object of ``kind``; what ``fields`` do not say is zero or empty."""
    return store.types[kind](*(_value(store, name, node, fields) for name, node in store.fielddefs[kind][1]))


def plain(store: Typestore, kind: str, fields: Fields) -> dict[str, Any]:
    """The same as nested dictionaries."""
    return {name: _plain(_value(store, name, node, fields)) for name, node in store.fielddefs[kind][1]}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tobytes() if value.dtype == np.uint8 else value.tolist()
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return {n: _plain(getattr(value, n)) for n in value.__dataclass_fields__ if not n.startswith("__")}
    return value


def _value(store: Typestore, name: str, node: Any, fields: Fields) -> Any:
    given = fields.get(name, fields.get(name.lower()))  # ROS 1 writes CameraInfo's D, K, R, P large
    kind, detail = node
    if kind is Nodetype.BASE:
        return given if given is not None else "" if detail[0] == "string" else 0
    if kind is Nodetype.NAME:
        return made(store, detail, given or {})
    (inner, inner_detail), length = detail
    values: Any = given if given is not None else [0] * length if inner is Nodetype.BASE else []
    if inner is Nodetype.BASE and inner_detail[0] != "string":
        return np.asarray(values, dtype=inner_detail[0].replace("octet", "uint8"))
    return list(values) if inner is Nodetype.BASE else [made(store, inner_detail, value) for value in values]

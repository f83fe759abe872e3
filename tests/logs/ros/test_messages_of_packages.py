"""Messages of other packages: recorded by their own fields, and read by a program that has the package."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from app.logs import layout
from app.logs.ros.decoder import DecodableContents, Decoder, StoredTopic, contents
from app.logs.ros.encoder import Encoder
from app.logs.ros.record import Record
from app.runtime.channel_table import ChannelSpec
from tests.distributions import install

SOURCE = """\
from dataclasses import dataclass

from app.base.geometry import Pose2


@dataclass(frozen=True, slots=True)
class Gust:
    stamp: float
    speed_mps: float


@dataclass(frozen=True, slots=True)
class Twist:
    stamp: float
    gusts: tuple[Gust, ...]
    X_OK: Pose2
"""


def recorded(package: str) -> tuple[DecodableContents, list[Record]]:
    """What a log of one message ``<package>:Twist`` holds, as the program reads it; and the records."""
    spec = ChannelSpec(type=f"{package}:Twist")
    twist = spec.message_type
    module = sys.modules[package]
    encoder = Encoder({"wind": spec})
    records = encoder.encode("wind", twist(5.0, (module.Gust(4.5, 12.0),), module.Pose2(1.0, 2.0, 3.0)))
    topics = [
        StoredTopic(r.topic, r.type, encoder.definition(r.type), encoder.channel_metadata(r.topic)) for r in records
    ]
    return contents(topics), records


def test_a_message_of_a_package_is_recorded_and_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, "hbba-kites", {"kites_m.py": SOURCE}, messages={"kites_m": "kites_m"})
    monkeypatch.syspath_prepend(str(tmp_path))
    found, (record,) = recorded("kites_m")
    assert record.type == "kites_m_msgs/msg/Twist", "another's Twist is not the program's"
    (channel,) = found.channels.values()
    read = Decoder([channel]).add(record.topic, record.data)
    assert read is not None
    assert read[0] == "wind"
    assert (read[1].gusts[0].speed_mps, read[1].X_OK.y) == (12.0, 2.0)
    assert type(read[1]) is channel.message_type


def test_a_log_does_not_have_just_any_module_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, "kites", {"kites_q.py": SOURCE})
    monkeypatch.syspath_prepend(str(tmp_path))
    recorded("kites_q")
    del sys.modules["kites_q"]
    metadata = {layout.CHANNEL: "wind", layout.MESSAGE: "kites_q:Twist"}
    topic = StoredTopic("/wind", "kites_q_msgs/msg/Twist", "", metadata)
    found = contents([topic])
    assert found.ignored == {
        "/wind": "'kites_q:Twist' is a message of a package 'kites_q', which is not installed for hbba"
    }
    assert "kites_q" not in sys.modules

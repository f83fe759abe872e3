"""What a writer asks of the encoder."""

from __future__ import annotations

import pytest

from app.logs import layout as mcap_layout
from app.logs.ros.encoder import Encoder
from app.logs.ros.record import Record
from app.messages import Landmarks, Odometry
from tests.logs.mcap.mcap_files import CHANNELS, drive, spec


def test_every_record_has_a_definition_and_its_topic_says_where_it_comes_from() -> None:
    encoder = Encoder(CHANNELS)
    for logged in drive(0.1):
        for record in encoder.encode(logged.channel, logged.message):
            assert isinstance(record, Record)
            assert encoder.definition(record.type)
            metadata = encoder.channel_metadata(record.topic)
            if record.topic in ("/tf", "/kinect/camera_info", "/scan/points"):
                assert metadata == {mcap_layout.DERIVED: "true"}
            else:
                row = CHANNELS[logged.channel]
                assert metadata[mcap_layout.CHANNEL] == logged.channel
                assert metadata[mcap_layout.MESSAGE] == row.message
                assert metadata[mcap_layout.RATE_HZ] == f"{row.rate_hz:g}"
    assert encoder.channel_metadata("/kinect/depth")[mcap_layout.PART] == "depth"
    assert mcap_layout.PART not in encoder.channel_metadata("/kinect/info")


def test_a_channel_of_events_has_no_rate() -> None:
    encoder = Encoder({"landmarks": spec("Landmarks")})
    encoder.encode("landmarks", Landmarks(1.0, ()))
    assert encoder.channel_metadata("/landmarks") == {
        mcap_layout.CHANNEL: "landmarks", mcap_layout.MESSAGE: "Landmarks"
    }  # fmt: skip


def test_each_encoder_writes_everything_that_a_file_needs() -> None:
    messages = [logged for logged in drive(0.1) if logged.channel == "scan"]
    for _ in range(2):
        encoder = Encoder(CHANNELS)
        topics = {r.topic for logged in messages[:1] for r in encoder.encode("scan", logged.message)}
        assert topics == {"/scan", "/scan/points", "/tf", "/scan/info"}


def test_an_unknown_channel_is_a_mistake() -> None:
    with pytest.raises(KeyError):
        Encoder(CHANNELS).encode("sonar", drive(0.1)[0].message)


def test_stamps_of_records_are_those_of_capture() -> None:
    odometry = next(logged.message for logged in drive(0.1) if isinstance(logged.message, Odometry))
    records = Encoder(CHANNELS).encode("odometry", odometry)
    assert {record.stamp_ns for record in records} == {round(odometry.stamp) * 1_000_000_000}

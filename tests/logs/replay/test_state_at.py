from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.logs.log import Logged
from app.logs.replay.state_at import RecordedState, taken_at
from app.messages import Desires, Landmarks, Odometry
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_log, lab_messages, numbered

#: Arrivals of one channel: bursts and gaps of any length.
ARRIVALS = st.lists(st.floats(0.001, 400.0), min_size=1, max_size=60).map(
    lambda gaps: [BEGIN + sum(gaps[: i + 1]) for i in range(len(gaps))]
)


@pytest.fixture(scope="module")
def lived() -> list[Logged]:
    """Four seconds of the lab."""
    return lab_messages(4.0)


def log_of(arrivals: list[float]) -> MemoryLog:
    """A log with messages on ``odometry`` then, and one on another channel at either end."""
    messages = [Logged(at, "odometry", numbered(1)[0].message) for at in arrivals]
    frame = [Logged(at, "other", numbered(1)[0].message) for at in (BEGIN, max(arrivals) + 1)]
    return MemoryLog(sorted([*messages, *frame], key=lambda logged: logged.at))


@given(ARRIVALS, st.floats(-10, 30_000))
@settings(deadline=None)
def test_the_last_before_any_moment_is_found(arrivals: list[float], offset: float) -> None:
    log = log_of(arrivals)
    position = BEGIN + offset
    expected = max((at for at in arrivals if at <= position), default=None)
    found = RecordedState(log).last("odometry", position)
    assert (None if found is None else found.at) == expected


@given(st.integers(1, 6), st.floats(0, 1))
@settings(deadline=None)
def test_looking_back_over_a_long_gap_decodes_little(minutes: int, fraction: float) -> None:
    # Images until the camera was closed, and long nothing.
    images = [Logged(BEGIN + i / 15, "kinect", numbered(1)[0].message) for i in range(15 * 60)]
    log = MemoryLog([*images, Logged(BEGIN + 60 + 60 * minutes, "other", numbered(1)[0].message)])
    found = RecordedState(log).last("kinect", BEGIN + 60 + 60 * minutes * fraction)
    assert found is images[-1]
    assert log.decoded["kinect"] < 30


def test_looking_back_at_a_frequent_channel_decodes_little() -> None:
    log = MemoryLog(numbered(10_000, 0.01))
    found = RecordedState(log).last("odometry", log.info.end)
    assert found is not None
    assert found.at == log.info.end
    assert log.decoded["odometry"] < 200


def test_a_channel_that_is_not_there_has_no_last() -> None:
    assert RecordedState(log_of([BEGIN + 1])).last("scan", BEGIN + 2) is None


def test_the_scene_is_what_stood_there_with_the_motion_around_it() -> None:
    log = lab_log(4.0)
    channels = {"kinect", "scan", "odometry", "joints", "link_status"}
    position = BEGIN + 2.5
    scene = RecordedState(log).scene(position, channels)
    assert scene == sorted(scene, key=lambda logged: logged.at)
    assert all(logged.at <= position for logged in scene)
    for channel in channels - {"odometry", "joints"}:
        (only,) = [logged for logged in scene if logged.channel == channel]
        assert only.at == max(m.at for m in log.messages(None, {channel}) if m.at <= position)
    (image,) = [logged for logged in scene if logged.channel == "kinect"]
    motion = [logged.at for logged in scene if logged.channel == "odometry"]
    # Every pose from before the image to now: the image's own can be interpolated.
    assert motion == [m.at for m in log.messages(motion[0], {"odometry"}) if m.at <= position]
    assert motion[0] < image.message.stamp < motion[-1]


def test_an_old_image_brings_the_motion_of_its_own_time() -> None:
    log = lab_log(4.0)
    messages = [m for m in log.messages() if m.channel != "kinect" or m.at < BEGIN + 1.0]
    scene = RecordedState(MemoryLog(messages)).scene(BEGIN + 3.9, {"kinect", "odometry"})
    (image,) = [logged for logged in scene if logged.channel == "kinect"]
    motion = [logged.message.stamp for logged in scene if logged.channel == "odometry"]
    assert BEGIN + 0.9 < image.at < BEGIN + 1.0
    assert min(motion) < image.message.stamp < sorted(motion)[1] + 0.2
    assert math.isclose(max(motion), BEGIN + 3.9, abs_tol=0.021)


def test_before_the_beginning_there_is_nothing() -> None:
    assert RecordedState(lab_log(1.0)).scene(BEGIN - 1, {"kinect", "odometry"}) == []


def test_what_was_desired_is_the_last_record_however_long_ago() -> None:
    (record,) = RecordedState(lab_log(4.0)).of_types((Desires,), BEGIN + 2.9)
    assert record.at == BEGIN + 2.0


def test_the_next_message_is_after_not_at_the_position() -> None:
    past = RecordedState(MemoryLog(numbered(5)))
    assert past.next_at("odometry", BEGIN) == BEGIN + 0.1
    assert past.next_at("odometry", BEGIN + 0.4) is None


@given(late_s=st.floats(0.0, 1.5))
@settings(deadline=None)
def test_a_late_image_brings_the_motion_of_when_it_was_taken(lived: list[Logged], late_s: float) -> None:
    messages = [Logged(m.at + late_s, m.channel, m.message) if m.channel == "kinect" else m for m in lived]
    log = MemoryLog(sorted(messages, key=lambda logged: logged.at))
    scene = RecordedState(log).scene(BEGIN + 3.0, {"kinect", "odometry"})
    (image,) = [logged for logged in scene if logged.channel == "kinect"]
    before = [m.at for m in scene if m.channel == "odometry" and m.message.stamp <= image.message.stamp]
    assert before
    assert before[0] > image.message.stamp - 0.2


def test_stamps_of_another_clock_are_not_believed() -> None:
    image = next(lab_log(1.0).messages(None, {"kinect"}))
    assert taken_at(image) == image.message.stamp
    assert taken_at(Logged(image.at + 1e6, "kinect", image.message)) == image.at + 1e6
    assert taken_at(Logged(image.at - 10, "kinect", image.message)) == image.at - 10


def test_of_a_frequent_channel_some_messages_are_looked_up() -> None:
    log = MemoryLog(numbered(100, 0.05))
    found = RecordedState(log).now_and_then(Odometry, BEGIN + 1.0, BEGIN + 3.0, 0.5)
    stamps = [BEGIN + 1.0 + 0.5 * number for number in range(5)]
    assert [message.stamp for message in found] == pytest.approx(stamps, abs=0.051)
    assert RecordedState(log).now_and_then(Landmarks, BEGIN, BEGIN + 3.0, 0.5) == []

"""What viewers may show, and for which channels that means work."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from app.messages import Image, LaserScan, Odometry, TimelineEvent
from app.modules.viewers.topics import ShownTopics

CHANNELS: dict[str, type[Any]] = {"scan": LaserScan, "odometry": Odometry, "kinect": Image, "events": TimelineEvent}
TOPICS = sorted(ShownTopics(CHANNELS).types)


def test_the_topics_are_those_of_a_recording_without_what_only_completes_them() -> None:
    types = ShownTopics(CHANNELS).types
    assert types["/scan"] == "sensor_msgs/msg/LaserScan"
    assert types["/kinect/color/compressed"] == "sensor_msgs/msg/CompressedImage"
    assert types["/events"] == "hbba_msgs/msg/TimelineEvent"
    assert types["/tf"] == "tf2_msgs/msg/TFMessage"
    assert not [topic for topic in types if topic.endswith("/info")]


def test_transforms_alone_do_not_make_the_cameras_work() -> None:
    topics = ShownTopics(CHANNELS)
    assert topics.subscribe(1, "/tf") == {"scan", "odometry"}
    assert not topics.encoded("kinect")
    assert topics.subscribe(1, "/kinect/color/compressed") == {"kinect"}
    assert topics.encoded("kinect")


def test_a_channel_is_worked_for_until_its_last_viewer_leaves() -> None:
    topics = ShownTopics(CHANNELS)
    assert topics.subscribe(1, "/scan") == {"scan"}
    assert topics.subscribe(2, "/scan/points") == set()
    assert topics.unsubscribe(1, "/scan") == set()
    assert topics.unsubscribe(2, "/scan/points") == {"scan"}
    assert topics.unsubscribe(2, "/scan/points") == set()


@given(st.lists(st.tuples(st.booleans(), st.integers(1, 3), st.sampled_from(TOPICS))))
def test_what_changes_adds_up_to_what_is_worked_for(steps: list[tuple[bool, int, str]]) -> None:
    topics, working = ShownTopics(CHANNELS), set[str]()
    for arrives, viewer, topic in steps:
        if arrives:
            began = topics.subscribe(viewer, topic)
            assert not began & working
            working |= began
        else:
            ended = topics.unsubscribe(viewer, topic)
            assert ended <= working
            working -= ended
        assert working == {name for name in CHANNELS if topics.encoded(name)}

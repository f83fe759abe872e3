"""Which topics viewers may show, and which channels are worked for because some viewer shows one of theirs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from app.logs.ros.converters import converter
from app.logs.ros.frames import TF
from app.logs.ros.generated import UnrecordableType
from app.logs.ros.record import RecordTopic
from app.messages import EncodedImage, Image, PointCloud

#: Their transforms alone are not worth rendering and encoding them: /tf has these once one of their pictures is shown.
LARGE = (Image, EncodedImage, PointCloud)
#: Topics that only complete others, for reading a recording back.
_COMPLETING = "/info"


def recorded(channel: str, message_type: type[Any]) -> tuple[RecordTopic, ...]:
    """The topics of a channel in a recording. Raises UnrecordableType."""
    return converter(channel, message_type).topics


class ShownTopics:
    """The topics of ``channels`` (message classes by channel), and the viewers that show them."""

    def __init__(
        self, channels: Mapping[str, type[Any]], drawn: Callable[[str, type[Any]], tuple[RecordTopic, ...]] = recorded
    ) -> None:
        """``drawn``: the topics of a channel; raises UnrecordableType for a class of messages that has none."""
        #: ROS type by topic.
        self.types: dict[str, str] = {}
        self._channels: dict[str, set[str]] = {}
        self._topics: dict[str, set[str]] = {}
        self._large = frozenset(name for name, message_type in channels.items() if message_type in LARGE)
        self._viewers: dict[str, set[int]] = {}
        for name, message_type in channels.items():
            try:
                topics = drawn(name, message_type)
            except UnrecordableType:
                continue
            for topic in topics:
                if not topic.name.endswith(_COMPLETING):
                    self.types[topic.name] = topic.type
                    self._channels.setdefault(topic.name, set()).add(name)
                    self._topics.setdefault(name, set()).add(topic.name)

    def channels_of(self, topic: str) -> frozenset[str]:
        """The channels that are worked for while ``topic`` is shown."""
        channels = self._channels.get(topic, set())
        return frozenset(channels - self._large if topic == TF.name else channels)

    def topics_of(self, channel: str) -> frozenset[str]:
        """The topics that ``channel`` is drawn on."""
        return frozenset(self._topics.get(channel, ()))

    def subscribe(self, viewer: int, topic: str) -> frozenset[str]:
        """Note that ``viewer`` shows ``topic``; the channels that are now worked for and were not before."""
        before = self._encoded_of(topic)
        self._viewers.setdefault(topic, set()).add(viewer)
        return self.channels_of(topic) - before

    def unsubscribe(self, viewer: int, topic: str) -> frozenset[str]:
        """Note that ``viewer`` does not show ``topic`` any more; the channels that nothing is to be done for now."""
        before = self._encoded_of(topic)
        self._viewers.get(topic, set()).discard(viewer)
        return before - self._encoded_of(topic)

    def encoded(self, channel: str) -> bool:
        """Whether a viewer shows a topic for which ``channel`` is worked for."""
        return any(
            self._viewers.get(topic) and channel in self.channels_of(topic) for topic in self._topics.get(channel, ())
        )

    def _encoded_of(self, topic: str) -> frozenset[str]:
        return frozenset(name for name in self.channels_of(topic) if self.encoded(name))

"""What is asked of rosbridge for one topic, and when it is asked again: a class stepped by its caller. Times in s."""

from __future__ import annotations

import math
from typing import Any

from app.robots.ros2.config import CAMERAS, CLOCK, INFO, TRANSFORMS, Ros2Config
from app.robots.ros2.rosbridge.values import plain_name

#: A topic that is silent for so long is subscribed to again; later, each time, after twice as long.
_FIRST_S, _LONGEST_S = 2.0, 16.0
#: The name of the subscription to transforms that stay.
STATIC = "tf_static"
#: Times between messages that come at their rate, beyond which a topic is silent.
_PERIODS = 3.0
_CLOCK_HZ, _INFO_HZ = 50.0, 1.0
#: Time for which a message may be kept; beyond the tolerance of the clock it would be refused.
_LONGEST_MS = 100.0


class Subscription:
    """The subscription ``name`` to ``topic``, which gives messages of ``kind`` at ``rate_hz``; where that is None,
    every one of them is needed."""

    def __init__(self, name: str, topic: str, kind: str, rate_hz: float | None) -> None:
        self.name, self.topic, self.type = name, topic, kind
        self._rate_hz = rate_hz
        #: When it was asked for, None while it is not.
        self.asked: float | None = None
        #: Whether a type was named: without one, rosbridge refuses a topic that is not there yet.
        self.has_type = False
        self._came = -math.inf
        self._patience_s = _FIRST_S

    @property
    def is_picture(self) -> bool:
        """Whether it is of a camera."""
        return self.name.partition(".")[0] in CAMERAS

    def asking(self, now: float, is_ros1: bool | None) -> dict[str, Any]:
        """The message that asks for it. Without a type, where it is unknown how ROS calls it, rosbridge finds it."""
        self.asked, self.has_type = now, is_ros1 is not None
        message: dict[str, Any] = {"op": "subscribe", "id": self.id, "topic": self.topic}
        if self._rate_hz is not None:
            # The newest is enough, at most twice as often as the mapping says. rosbridge keeps it meanwhile.
            message |= {"throttle_rate": int(min(500.0 / self._rate_hz, _LONGEST_MS)), "queue_length": 1}
        if is_ros1 is not None:
            message["type"] = plain_name(self.type) if is_ros1 else self.type
        return message

    def unsubscription(self) -> dict[str, Any]:
        """The message that ends it."""
        return {"op": "unsubscribe", "id": self.id, "topic": self.topic}

    def came(self, now: float) -> None:
        """Note a message."""
        self._came = now
        self._patience_s = _FIRST_S

    def is_silent(self, now: float) -> bool:
        """Whether a message should have come since it was asked for and since the last one."""
        return now - max(self._came, self.asked or -math.inf) > max(1.0, self._period_s)

    def is_due(self, now: float) -> bool:
        """Whether to ask again: nothing came for so long. Each time doubles that."""
        if self.name == STATIC and self._came > -math.inf:
            return False  # it comes once
        if self.asked is None or now - max(self._came, self.asked) <= max(self._patience_s, self._period_s):
            return False
        self._patience_s = min(2 * self._patience_s, _LONGEST_S)
        return True

    def hurry(self) -> None:
        """Be asked for again at once, unless something came already."""
        if self.asked is not None and self._came < self.asked:
            self.asked = None

    @property
    def _period_s(self) -> float:
        return 0.0 if self._rate_hz is None else _PERIODS / self._rate_hz

    @property
    def id(self) -> str:
        """By which rosbridge knows it."""
        return f"hbba {self.name}"


def subscriptions(config: Ros2Config) -> dict[str, Subscription]:
    """Those of the mapping, by name, and that to ``/tf_static``."""

    def rate_hz(name: str, kind: str) -> float | None:
        stream, _, part = name.partition(".")
        if kind == TRANSFORMS or stream == "joints":  # several publishers, of which none gives all
            return None
        if part == INFO or name == CLOCK:
            return _INFO_HZ if part else _CLOCK_HZ
        return config.mapped[stream].rate_hz

    found = {
        name: Subscription(name, topic, kind, rate_hz(name, kind))
        for name, (topic, kind) in config.subscriptions.items()
    }
    return found | {STATIC: Subscription(STATIC, config.full_name(STATIC), TRANSFORMS, None)}

"""The last messages of a recording at any position: the state to show after a seek."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from app.logs.log import Log, Logged
from app.logs.mcap.damage import skipping
from app.messages import JointState, Landmarks, Localization, OccupancyGrid, Odometry, Places, Zones

#: The body's motion belongs to the images and scans taken meanwhile: every such message is used, not the last alone.
MOTION = (Odometry, JointState)
#: Messages that accumulate since the beginning: a module that restarts cannot compute them.
ACCUMULATED = (Landmarks, OccupancyGrid, Localization, Zones, Places)

#: The body's motion begins this long (s) before the first image or scan, so that poses can be interpolated.
LEAD_S = 0.1
#: A message that arrives later than this after its capture (s) has a stamp of another clock.
LONGEST_DELAY_S = 2.0
#: Time searched first: this many periods of the slowest channel, within these limits (s).
PERIODS = 2.5
SHORTEST_S = 0.15
LONGEST_S = 0.6


def taken_at(logged: Logged) -> float:
    """When a message was captured (s), on the clock of the log's arrivals: another's stamps are not to be believed."""
    stamp = float(logged.message.stamp)
    return stamp if 0.0 <= logged.at - stamp <= LONGEST_DELAY_S else logged.at


class RecordedState:
    """The last messages of ``log`` before a position; damaged parts are skipped where the log says where they end.

    Its methods read the file: call them off the event loop, one at a time.
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self._channels = log.info.channels

    def scene(self, position: float, channels: Collection[str]) -> list[Logged]:
        """Messages that show the state at ``position`` (s), in the order of arrival.

        The last message of each of ``channels`` that arrived at or before ``position``; of the body's motion, all since
        shortly before the first of these. Raises LogError.
        """
        wanted = [name for name in channels if name in self._channels and self._channels[name].count]
        moving = [name for name in wanted if self._channels[name].message_type in MOTION]
        seen = [name for name in wanted if name not in moving]
        since = position - self._span_s(wanted) - LEAD_S
        recent = list(self._between(since, position, wanted))
        last = {logged.channel: logged for logged in recent if logged.channel in seen}
        motion = [logged for logged in recent if logged.channel in moving]
        begin = min((taken_at(logged) for logged in last.values()), default=position) - LEAD_S
        if begin < since:
            motion.extend(self._between(begin, since, moving))
        for name in seen:
            if name not in last and (found := self.last(name, since)) is not None:
                last[name] = found
                motion.extend(self._between(taken_at(found) - LEAD_S, min(found.at + LEAD_S, since), moving))
        still = [name for name in moving if all(logged.channel != name for logged in recent)]
        motion.extend(found for name in still if (found := self.last(name, since)) is not None)
        # Two looks may overlap.
        once = {(m.at, m.channel, m.message.stamp): m for m in motion if m.at >= begin or m.at < since}
        return sorted([*once.values(), *last.values()], key=lambda logged: logged.at)

    def of_types(self, types: Collection[type[Any]], position: float) -> list[Logged]:
        """The last message at or before ``position`` (s) of every channel of these ``types``. Raises LogError."""
        names = [name for name, channel in self._channels.items() if channel.message_type in types]
        return [last for name in names if (last := self.last(name, position)) is not None]

    def now_and_then(self, message_type: type[Any], begin: float, end: float, period_s: float) -> list[Any]:
        """Messages of the channels of ``message_type`` between ``begin`` and ``end`` (s), at most one of each in
        ``period_s``, in order of arrival. Raises LogError."""
        names = [name for name, channel in self._channels.items() if channel.message_type is message_type]
        due: dict[str, float] = {}
        found = []
        for logged in self._between(begin, end, names):
            if logged.at >= due.get(logged.channel, begin):
                due[logged.channel] = logged.at + period_s
                found.append(logged.message)
        return found

    def last(self, channel: str, position: float) -> Logged | None:
        """The last message of ``channel`` at or before ``position`` (s), None without one.

        Probes further and further back, then bisects: few messages are decoded, wherever the last one is.
        """
        if channel not in self._channels or not self._channels[channel].count:
            return None
        step_s, late = SHORTEST_S, position
        while (found := self._first(channel, late - step_s, late)) is None:
            late -= step_s
            step_s *= 2
            if late < self._log.info.begin:
                return None
        early = found.at
        # `found` is the first in (late - step, late], which holds the last one too.
        while late - early > LONGEST_S:
            middle = (early + late) / 2
            later = self._first(channel, middle, late)
            if later is None:
                late = middle
            else:
                found, early = later, later.at
        for found in self._between(early, late, (channel,)):  # noqa: B007  # the last one counts
            pass
        return found

    def next_at(self, channel: str, position: float) -> float | None:
        """When the first message of ``channel`` after ``position`` (s) arrived, None where none did."""
        for logged in self._messages(position, (channel,)):
            if logged.at > position:
                return logged.at
        return None

    def _span_s(self, channels: Collection[str]) -> float:
        duration_s = self._log.info.duration_s
        periods = (duration_s / self._channels[name].count for name in channels)
        return min(max(PERIODS * max(periods, default=0.0), SHORTEST_S), LONGEST_S)

    def _first(self, channel: str, begin: float, end: float) -> Logged | None:
        return next(self._between(begin, end, (channel,)), None)

    def _between(self, begin: float, end: float, channels: Collection[str]) -> Iterator[Logged]:
        """Messages that arrived from ``begin`` to ``end``, both included."""
        if not channels:
            return
        for logged in self._messages(begin, channels):
            if logged.at > end:
                return
            yield logged

    def _messages(self, begin: float, channels: Collection[str]) -> Iterator[Logged]:
        # The body reports damage when it reaches it.
        return skipping(self._log, begin, channels, lambda _: None)

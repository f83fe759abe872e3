"""A bad network between two ends, as a model on values: delay, jitter, loss and rate of ordered streams.

The streams are those of TCP: nothing is lost and nothing overtakes. A packet that the network loses is sent again, and
all that follows it in its stream waits. Both directions are alike; all streams of a direction share its rate.

    message ─▶ its share of the rate ─▶ half the delay ± half the jitter ─▶ packets sent again ─▶ after the one before
"""

from __future__ import annotations

import math
import random
import re
from dataclasses import dataclass

#: Bytes of a stream that fit one packet, and what the headers of a packet add (IPv4, TCP with time stamps).
PACKET_BYTES = 1400
HEADER_BYTES = 52
#: A loss is noticed when the packets after it are acknowledged: a round trip, a quarter of one that packets may be out
#: of order (RFC 8985), and the time (s) until there is one after it.
REORDERING = 1.25
NEXT_PACKET_S = 0.02
LONGEST_DELAY_S = 5.0
MOST_LOSS = 0.5
SLOWEST_BPS = 64e3
FASTEST_BPS = 10e9

_UNITS = {
    "delay": {"ms": 1e-3, "s": 1.0},
    "jitter": {"ms": 1e-3, "s": 1.0},
    "loss": {"%": 1e-2},
    "rate": {"kbit": 1e3, "Mbit": 1e6, "Gbit": 1e9},
}
_ALLOWED = "delay=300ms,jitter=50ms,loss=2%,rate=4Mbit, each of which may be left out, or off"


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """``delay_s`` is added to a round trip, half of it each way, ± ``jitter_s``, uniformly distributed; ``loss`` is the
    share of packets that are sent again; ``rate_bps`` are bits a second each way, None: as many as come.

    Raises ValueError, in one sentence for people, for what cannot be.
    """

    delay_s: float = 0.0
    jitter_s: float = 0.0
    loss: float = 0.0
    rate_bps: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 <= self.delay_s <= LONGEST_DELAY_S:
            raise ValueError(f"delay goes from 0 to {LONGEST_DELAY_S:g} s, not {self.delay_s:g} s")
        if not 0.0 <= self.jitter_s <= self.delay_s:
            raise ValueError(
                f"jitter goes from 0 to the delay, {1e3 * self.delay_s:g} ms, not {1e3 * self.jitter_s:g} ms"
            )
        if not 0.0 <= self.loss <= MOST_LOSS:
            raise ValueError(f"loss goes from 0 to {100 * MOST_LOSS:g} %, not {100 * self.loss:g} %")
        if self.rate_bps is not None and not SLOWEST_BPS <= self.rate_bps <= FASTEST_BPS:
            raise ValueError(f"rate goes from 64 kbit to 10 Gbit (a second), not {1e-3 * self.rate_bps:g} kbit")

    @property
    def shapes(self) -> bool:
        """Whether it changes anything."""
        return self.delay_s > 0.0 or self.loss > 0.0 or self.rate_bps is not None

    @property
    def resend_s(self) -> float:
        """The time (s) until a lost packet has been sent again."""
        return REORDERING * self.delay_s + NEXT_PACKET_S

    @property
    def words(self) -> str:
        """The settings for people; empty where nothing is changed."""
        parts = []
        if self.delay_s:
            jitter = f" ± {1e3 * self.jitter_s:g}" if self.jitter_s else ""
            parts.append(f"{1e3 * self.delay_s:g}{jitter} ms round trip")
        if self.loss:
            parts.append(f"{100 * self.loss:g} % of packets sent again")
        if self.rate_bps is not None:
            parts.append(f"{1e-6 * self.rate_bps:g} Mbit/s")
        return ", ".join(parts)


def parse_link(text: str) -> LinkSettings:
    """The settings that a person wrote, as ``delay=300ms,jitter=50ms,loss=2%,rate=4Mbit``, or ``off``.

    Raises ValueError, in one sentence for people.
    """
    if text.strip() == "off":
        return LinkSettings()
    found: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = (each.strip() for each in part.partition("="))
        if name not in _UNITS or not equals:
            raise ValueError(f"{part.strip()!r} says nothing of a link: {_ALLOWED}")
        if name in found:
            raise ValueError(f"{name} is given twice")
        found[name] = _quantity(name, value)
    return LinkSettings(
        found.get("delay", 0.0), found.get("jitter", 0.0), loss=found.get("loss", 0.0), rate_bps=found.get("rate")
    )


def _quantity(name: str, text: str) -> float:
    units = _UNITS[name]
    match = re.fullmatch(r"(\d+(?:\.\d+)?|\.\d+)\s*(\S+)", text)
    if match is None or match[2] not in units:
        raise ValueError(f"{name} is a number with its unit ({' or '.join(units)}), not {text!r}: {_ALLOWED}")
    return float(match[1]) * units[match[2]]


@dataclass(slots=True)
class Stream:
    """One ordered stream in one direction: when its last message ``arrived`` at the other end (s)."""

    arrived: float = -math.inf


@dataclass(frozen=True, slots=True)
class Passage:
    """When a message has left its sender whole, and when it arrives (s)."""

    departs: float
    arrives: float


class Direction:
    """One direction of the link, which all its streams share; times are in seconds of any steady clock."""

    def __init__(self, draw: random.Random) -> None:
        self._draw = draw
        #: From then on it carries nothing yet.
        self._free = -math.inf

    def free_at(self, now: float) -> float:
        """When all that was sent until ``now`` will have left."""
        return max(now, self._free)

    def send(self, settings: LinkSettings, stream: Stream, now: float, size: int) -> Passage:
        """Send ``size`` bytes on ``stream`` at ``now``, which must not be less than at the call before."""
        packets = max(1, math.ceil(size / PACKET_BYTES))
        departs = now
        if settings.rate_bps is not None:
            departs = self.free_at(now) + 8.0 * (size + packets * HEADER_BYTES) / settings.rate_bps
            self._free = departs
        transit = 0.5 * (settings.delay_s + settings.jitter_s * self._draw.uniform(-1.0, 1.0))
        arrives = max(stream.arrived, departs + transit + self._resending(settings, packets))
        stream.arrived = arrives
        return Passage(departs, arrives)

    def _resending(self, settings: LinkSettings, packets: int) -> float:
        """How long (s) the last of ``packets`` to be repaired waits: those lost together are sent again together."""
        rounds = 0
        while settings.loss > 0.0 and packets > 0:
            packets = sum(self._draw.random() < settings.loss for _ in range(packets))
            rounds += packets > 0
        return rounds * settings.resend_s

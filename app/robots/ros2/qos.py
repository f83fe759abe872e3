"""Quality of service, matched to what the other side offers or asks for: pure functions.

A reader that asks for more than a writer offers hears nothing, and no error says so (ROS 2's table of compatible
policies: reliability, durability, deadline, lease of liveliness).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Qos:
    """What a writer offers or a reader asks for: whether lost messages are sent again, and late readers get the last
    ones; ``deadline_s``: the longest time between two messages, None without one."""

    reliable: bool = True
    transient_local: bool = False
    deadline_s: float | None = None


def reader(offered: Iterable[Qos]) -> Qos:
    """What to ask for, so that every writer that offers is heard; of a topic without a writer: the least."""
    writers = list(offered)
    return Qos(
        reliable=bool(writers) and all(writer.reliable for writer in writers),
        transient_local=bool(writers) and all(writer.transient_local for writer in writers),
    )


def writer(asked: Iterable[Qos]) -> Qos:
    """What to offer, so that every reader that asks hears us: always reliable, for any reader takes that."""
    readers = list(asked)
    deadlines = [reader.deadline_s for reader in readers if reader.deadline_s is not None]
    return Qos(
        reliable=True,
        transient_local=any(reader.transient_local for reader in readers),
        deadline_s=min(deadlines, default=None),
    )

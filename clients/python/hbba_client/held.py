"""A desire that lasts as long as a block: the times and requests of it, pure, for both robots."""

from __future__ import annotations

from typing import Any

from .records import DesireChange, NewDesire

#: Renewed so many times within its time to live: one lost renewal does not end it.
RENEWALS = 3
#: The longest that the program waits for an outcome at one request (s).
LONGEST_WAIT_S = 60.0


def new_desire(
    desire_class: str,
    params: dict[str, Any],
    *,
    intensity: float,
    utility: float,
    security: bool,
    ttl: float,
) -> NewDesire:
    """The desire to create. Raises ValueError for a ``ttl`` that cannot be."""
    if not ttl > 0:
        raise ValueError(f"ttl is the seconds that the desire outlives its client, more than 0, not {ttl}")
    return NewDesire(
        class_=desire_class, intensity=intensity, utility=utility, security=security, params=params, ttl=ttl
    )


def renewal(ttl: float) -> DesireChange:
    """The change that lets the desire go on for ``ttl`` seconds from now."""
    return DesireChange(ttl=ttl)

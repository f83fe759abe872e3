"""Persons as a tracker publishes them."""

from __future__ import annotations

import math

import numpy as np

from app.messages import Person, Persons, PersonState, read_only


def person(
    x: float,
    y: float,
    *,
    track: int = 1,
    number: int | None = 1,
    state: PersonState = "confirmed",
    v: tuple[float, float] = (0.0, 0.0),
    face: bool = False,
    seen: float = math.inf,
) -> Person:
    """A person at ``x``, ``y`` (m); ``number``: the identity; ``seen`` (s): when last."""
    return Person(
        track,
        number,
        state,
        p_OP=(x, y, 1.57),
        v_O=v,
        covariance=read_only(0.01 * np.eye(2)),
        face=7 if face else None,
        voice=None,
        legs=not face,
        speaking=False,
        last_seen=seen,
    )


def persons(stamp: float, *all_of_them: Person) -> Persons:
    """The message of ``stamp`` (s)."""
    return Persons(stamp, all_of_them)

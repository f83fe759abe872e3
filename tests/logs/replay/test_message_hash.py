"""Fingerprints: equal for equal messages alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.logs.replay.message_hash import MessageHash, fingerprint
from app.messages import Exploitation, Odometry, Twist

VALUES: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary(),
    lambda inner: st.tuples(inner) | st.tuples(inner, inner) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


def same(one: Any, other: Any) -> bool:
    """Equal, and of equal kinds; 0.0 and -0.0 are two."""
    return repr(one) == repr(other)


def ordered(value: Any) -> Any:
    """With every mapping's keys sorted, as order in a mapping says nothing."""
    if isinstance(value, dict):
        return {key: ordered(value[key]) for key in sorted(value)}
    return tuple(ordered(item) for item in value) if isinstance(value, tuple) else value


@given(VALUES, VALUES)
def test_equal_if_and_only_if_the_values_are(one: Any, other: Any) -> None:
    assert (fingerprint(one) == fingerprint(other)) == same(ordered(one), ordered(other))


def test_messages_and_arrays() -> None:
    odometry = Odometry(1.0, Pose2(1, 2, 3), 0.0, 0.0)
    assert fingerprint(odometry) == fingerprint(Odometry(1.0, Pose2(1, 2, 3), 0.0, 0.0))
    assert fingerprint(odometry) != fingerprint(Odometry(math.nextafter(1.0, 2), Pose2(1, 2, 3), 0.0, 0.0))
    assert fingerprint(Exploitation(1.0, None, Twist(1, 2, 3))) != fingerprint(Exploitation(1.0, "", Twist(1, 2, 3)))
    array = np.arange(6, dtype=np.uint8)
    assert fingerprint(array) != fingerprint(array.reshape(2, 3))
    assert fingerprint(array) != fingerprint(array.astype(np.int8))
    assert fingerprint(array.reshape(2, 3).T) == fingerprint(np.ascontiguousarray(array.reshape(2, 3).T))


def test_the_order_of_messages_counts() -> None:
    digests = [MessageHash(), MessageHash()]
    for digest, order in zip(digests, ((1, 2), (2, 1)), strict=True):
        for number in order:
            digest.add(number)
    assert digests[0].count == digests[1].count == 2
    assert digests[0].hex() != digests[1].hex()


def test_what_has_no_certain_bytes_is_refused() -> None:
    with pytest.raises(TypeError, match="set has no certain bytes"):
        fingerprint({1, 2})

"""Buckets that fill again with time, one for each client."""

from __future__ import annotations

import pytest

from app.console.access.rate_limit import MOST_CLIENTS, RateLimit
from app.console.problems import Problem


class Clock:
    """Seconds, as a test sets them."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_so_many_at_once_and_then_one_by_one() -> None:
    clock = Clock()
    limit = RateLimit(clock, burst=3, per_s=0.5)
    assert [limit.wait_s("ann") for _ in range(3)] == [0, 0, 0]
    assert limit.wait_s("ann") == 2.0
    assert limit.wait_s("bob") == 0, "each has a bucket of its own"
    clock.now += 1.5
    assert limit.wait_s("ann") == pytest.approx(0.5), "a refusal takes nothing"
    clock.now += 0.5
    assert limit.wait_s("ann") == 0
    clock.now += 3600
    assert [limit.wait_s("ann") for _ in range(4)] == [0, 0, 0, 2.0], "it is never fuller than full"


def test_a_refusal_says_when_to_try_again() -> None:
    limit = RateLimit(Clock(), burst=1, per_s=0.1)
    limit.take("ann")
    with pytest.raises(Problem, match="in 10 s") as refused:
        limit.take("ann")
    assert (refused.value.status, refused.value.headers) == (429, {"Retry-After": "10"})


def test_only_so_many_clients_are_kept() -> None:
    limit = RateLimit(Clock(), burst=1, per_s=1)
    for client in range(MOST_CLIENTS + 10):
        limit.wait_s(client)
    assert len(limit) == MOST_CLIENTS

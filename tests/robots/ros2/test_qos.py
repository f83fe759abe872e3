"""Quality of service: whatever is offered is heard, whatever is asked for is offered."""

from __future__ import annotations

import itertools

import pytest

from app.robots.ros2.qos import Qos, reader, writer

ALL = [Qos(*policies) for policies in itertools.product((True, False), (True, False), (None, 0.1, 0.5))]


def heard(offered: Qos, asked: Qos) -> bool:
    """ROS 2's rule: the writer offers at least what the reader asks for."""
    in_time = asked.deadline_s is None or (offered.deadline_s is not None and offered.deadline_s <= asked.deadline_s)
    return offered.reliable >= asked.reliable and offered.transient_local >= asked.transient_local and in_time


@pytest.mark.parametrize("count", [1, 2])
def test_every_writer_is_heard(count: int) -> None:
    for offered in itertools.combinations_with_replacement(ALL, count):
        asked = reader(offered)
        assert all(heard(one, asked) for one in offered)


@pytest.mark.parametrize("count", [1, 2])
def test_every_reader_hears_us(count: int) -> None:
    for asked in itertools.combinations_with_replacement(ALL, count):
        offered = writer(asked)
        assert all(heard(offered, one) for one in asked)


def test_what_is_lost_is_asked_for_again_where_all_would_send_it() -> None:
    assert reader([Qos(reliable=True)]).reliable
    assert not reader([Qos(reliable=True), Qos(reliable=False)]).reliable
    assert reader([Qos(transient_local=True)]).transient_local


def test_without_anybody_the_least_is_asked_for_and_no_more_than_reliability_offered() -> None:
    assert reader([]) == Qos(reliable=False)
    assert writer([]) == Qos(reliable=True)

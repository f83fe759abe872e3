"""A bad link on values: order is kept, the rate is never exceeded, the delay is within its bounds."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.network_link import HEADER_BYTES, PACKET_BYTES, Direction, LinkSettings, Stream, parse_link

SIZES = st.integers(0, 200_000)
GAPS = st.floats(0.0, 0.3)
#: Messages: the gap before each (s), its size, its stream.
MESSAGES = st.lists(st.tuples(GAPS, SIZES, st.integers(0, 2)), min_size=1, max_size=60)


@st.composite
def settings_of_links(draw: st.DrawFn) -> LinkSettings:
    """Any link."""
    delay_s = draw(st.floats(0.0, 1.0))
    return LinkSettings(
        delay_s,
        delay_s * draw(st.floats(0.0, 1.0)),
        loss=draw(st.sampled_from([0.0, 0.02, 0.5])),
        rate_bps=draw(st.sampled_from([None, 64e3, 4e6, 1e9])),
    )


def carried(
    settings: LinkSettings, messages: list[tuple[float, int, int]]
) -> list[tuple[float, int, int, float, float]]:
    """Of each message: when it was sent, its size and stream, when it has left, and when it arrives."""
    direction, streams, now = Direction(random.Random(7)), [Stream() for _ in range(3)], 100.0
    found = []
    for gap, size, stream in messages:
        now += gap
        passage = direction.send(settings, streams[stream], now, size)
        found.append((now, size, stream, passage.departs, passage.arrives))
    return found


@given(settings_of_links(), MESSAGES)
def test_a_stream_keeps_its_order(settings: LinkSettings, messages: list[tuple[float, int, int]]) -> None:
    found = carried(settings, messages)
    for stream in range(3):
        arrivals = [arrives for *_, own, _, arrives in found if own == stream]
        assert arrivals == sorted(arrivals)


@given(settings_of_links(), MESSAGES)
def test_nothing_arrives_before_half_the_least_delay(
    settings: LinkSettings, messages: list[tuple[float, int, int]]
) -> None:
    for sent, _, _, departs, arrives in carried(settings, messages):
        assert departs >= sent
        assert arrives >= departs + 0.5 * (settings.delay_s - settings.jitter_s) - 1e-9


@given(settings_of_links(), MESSAGES)
def test_without_loss_the_delay_is_within_its_bounds(
    settings: LinkSettings, messages: list[tuple[float, int, int]]
) -> None:
    lossless = LinkSettings(settings.delay_s, settings.jitter_s, rate_bps=settings.rate_bps)
    for *_, departs, arrives in carried(lossless, messages):
        # A message that was quick waits for the one before, which left earlier: no longer than the slowest takes.
        assert arrives - departs <= 0.5 * (settings.delay_s + settings.jitter_s) + 1e-9


@given(MESSAGES, st.sampled_from([64e3, 4e6, 1e9]))
def test_over_no_window_more_leaves_than_the_rate_allows(messages: list[tuple[float, int, int]], rate: float) -> None:
    found = carried(LinkSettings(rate_bps=rate), messages)
    for first in range(len(found)):
        bits = 0.0
        begins = found[first][3]
        for _, size, _, departs, _ in found[first + 1 :]:
            bits += 8.0 * size
            assert bits <= rate * (departs - begins) + 1e-3


def test_a_stream_that_repairs_a_loss_does_not_hold_up_another() -> None:
    settings, direction = LinkSettings(0.3, loss=0.5), Direction(random.Random(1))
    broken, whole = Stream(), Stream()
    late = max(direction.send(settings, broken, 1.0, 100_000).arrives for _ in range(5))
    assert late > 1.15 + settings.resend_s
    quick = min(direction.send(settings, whole, 1.0 + k, 10).arrives - k for k in range(20))
    assert quick == pytest.approx(1.15)


def test_losses_come_as_often_as_asked_for() -> None:
    settings, direction = LinkSettings(0.2, loss=0.02), Direction(random.Random(3))
    late = 0
    for number in range(10_000):
        late += direction.send(settings, Stream(), float(number), 100).arrives > number + 0.1 + 1e-6
    assert 150 <= late <= 250


def test_packets_have_headers() -> None:
    direction = Direction(random.Random(0))
    passage = direction.send(LinkSettings(rate_bps=1e6), Stream(), 0.0, PACKET_BYTES + 1)
    assert passage.departs == pytest.approx(8e-6 * (PACKET_BYTES + 1 + 2 * HEADER_BYTES))


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        ("delay=300ms,jitter=50ms,loss=2%,rate=4Mbit", LinkSettings(0.3, 0.05, loss=0.02, rate_bps=4e6)),
        ("rate=512kbit", LinkSettings(rate_bps=512e3)),
        (" delay = 1.5s ", LinkSettings(1.5)),
        ("off", LinkSettings()),
    ],
)
def test_what_a_person_writes(text: str, settings: LinkSettings) -> None:
    assert parse_link(text) == settings


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "'' says nothing of a link: delay=300ms"),
        ("lag=3ms", "'lag=3ms' says nothing of a link"),
        ("delay=300", r"delay is a number with its unit \(ms or s\), not '300'"),
        ("delay=10ms,delay=20ms", "delay is given twice"),
        ("delay=9s", "delay goes from 0 to 5 s, not 9 s"),
        ("delay=10ms,jitter=20ms", "jitter goes from 0 to the delay, 10 ms, not 20 ms"),
        ("loss=80%", "loss goes from 0 to 50 %, not 80 %"),
        ("rate=1kbit", "rate goes from 64 kbit to 10 Gbit"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        parse_link(text)


def test_the_settings_in_words() -> None:
    assert parse_link("delay=300ms,jitter=50ms,loss=2%,rate=4Mbit").words == (
        "300 ± 50 ms round trip, 2 % of packets sent again, 4 Mbit/s"
    )
    assert LinkSettings().words == ""

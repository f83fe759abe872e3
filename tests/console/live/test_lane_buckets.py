"""The lanes' past in buckets."""

from __future__ import annotations

import json
import math

import msgspec
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from app.console.live.lane_buckets import aggregated, bucket_starts
from app.console.live.lane_history import LaneHistory
from app.messages import LaneRow, Lanes
from tests.console.live.test_lane_history import CLASSES, ROWS, USUAL

STEPS = st.lists(st.floats(0.48, 30), max_size=80)
RATES = st.one_of(st.just(math.nan), st.floats(0, 1))


@given(STEPS, st.integers(1, 50), st.data())
def test_no_sample_is_lost_and_none_made_up(steps: list[float], points: int, data: st.DataObject) -> None:
    stamps = 1.7e9 + np.cumsum(steps)
    begin, end = (1.7e9, 1.7e9) if not steps else (float(stamps[0]), float(stamps[-1]))
    values = np.array(data.draw(st.lists(RATES, min_size=len(stamps), max_size=len(stamps))))
    starts = bucket_starts(stamps, begin, end, points)
    found = aggregated(values, starts)
    assert len(starts) <= points
    assert len(starts) == len(stamps) or points < len(stamps)
    groups = np.split(values, starts)[1:]
    assert sum(map(len, groups)) == len(values)
    for group, low, high, last in zip(groups, *found, strict=True):
        there = group[~np.isnan(group)]
        assert len(group)
        if len(there) == 0:
            assert np.isnan([low, high, last]).all()
        else:
            assert (low, high, last) == (there.min(), there.max(), there[-1])
            assert low <= last <= high


@given(st.lists(st.tuples(ROWS, ROWS), min_size=1, max_size=60), st.integers(1, 20), st.integers(1, 60))
def test_a_closing_is_never_lost(noted: list[tuple[LaneRow, LaneRow]], points: int, most: int) -> None:
    history = LaneHistory(CLASSES, most)
    kept = []
    for number, pair in enumerate(noted):
        rows = tuple(structs.replace(row, cls=cls) for cls, row in zip(CLASSES, pair, strict=True))
        kept.append(Lanes(100.0 + 0.5 * number, rows))
        history.add(kept[-1])
    kept = kept[-most:]
    end = kept[-1].stamp
    past = history.between(0.0, end).in_buckets(points)
    whole = history.between(0.0, end).in_buckets(len(noted))
    assert len(past.stamps) <= points
    assert past.oldest == kept[0].stamp
    assert whole.bucket_s == 0
    assert whole.stamps == whole.ends == tuple(lanes.stamp for lanes in kept)
    for number, row in enumerate(past.rows):
        was = [lanes.rows[number] for lanes in kept]
        for begin, stop in zip(past.stamps, past.ends, strict=True):
            closed = [r for lanes, r in zip(kept, was, strict=True) if begin <= lanes.stamp <= stop and r.divisor > 1e9]
            said = [c for c in row.changes if begin <= c.stamp <= stop]
            held = [c for c in row.changes if c.stamp <= begin][-1:]
            assert not closed or any(math.isinf(change.divisor) for change in held + said)
        # What holds at the end of each bucket is exact.
        for stop in past.ends:
            change = [change for change in row.changes if change.stamp <= stop][-1]
            then = next(r for lanes, r in zip(kept, was, strict=True) if lanes.stamp == stop)
            assert (change.intensity, change.divisor, change.text) == (then.intensity, then.divisor, then.text)
        assert [c.stamp for c in row.changes] == sorted(c.stamp for c in row.changes)


def test_an_hour_is_kept_and_is_small() -> None:
    """Of 24 classes; one is closed for half a second, forty minutes ago."""
    classes = [f"Class{number}" for number in range(24)]
    history = LaneHistory(classes)
    row = structs.replace(USUAL, rate=0.5)
    for number in range(8000):
        shut = structs.replace(row, divisor=math.inf, divisors={}, state="unfulfilled", text="it costs too much")
        now = shut if number == 3200 else row
        history.add(Lanes(0.5 * number, tuple(structs.replace(now, cls=cls) for cls in classes)))
    past = history.between(400.0, 4000.0).in_buckets(600)
    text = msgspec.json.encode(past)
    assert len(past.stamps) == 600
    assert past.oldest == 400.0
    assert past.bucket_s == 6.0
    assert len(text) < 300_000
    changes = json.loads(text)["rows"][0]["changes"]
    assert [(change["stamp"], change["state"]) for change in changes] == [
        (400.0, "fulfilled"),
        (1600.0, "unfulfilled"),
        (1600.5, "fulfilled"),
    ]


def test_nothing_is_known_of_another_time() -> None:
    history = LaneHistory(CLASSES)
    assert history.between(0.0, 10.0).in_buckets(5).stamps == ()
    history.add(Lanes(100.0, ()))
    past = history.between(0.0, 10.0).in_buckets(5)
    assert (past.oldest, past.stamps, past.ends) == (100.0, (), ())
    assert all(row.changes == row.rate == () for row in past.rows)


def test_a_clock_set_back_begins_another_past() -> None:
    history = LaneHistory(CLASSES)
    for stamp in (100.0, 101.0, 50.0, 51.0):
        history.add(Lanes(stamp, ()))
    assert history.between(0.0, 200.0).in_buckets(9).stamps == (50.0, 51.0)

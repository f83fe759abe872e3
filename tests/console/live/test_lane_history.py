"""The past of the lanes as a new page gets it."""

from __future__ import annotations

import json
import math
from typing import Any

import msgspec
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from app.console.live.lane_history import HELD, LaneHistory
from app.messages import LaneRow, Lanes

CLASSES = ("Explore", "Telepresence")
USUAL = LaneRow(
    cls="",
    intensity=8.0,
    utility=1.0,
    rate=0.1234,
    divisor=1.0,
    divisors={"SomeDetector.images": 1.0, "SomeDetector.panorama": 1.0, "SomeDetector.scans": 2.0},
    state="fulfilled",
    text="",
)
ROWS = st.builds(
    lambda intensity, rate, divisor, text: LaneRow(
        cls="",
        intensity=intensity,
        utility=intensity,
        rate=rate,
        divisor=divisor,
        divisors={} if math.isinf(divisor) else {"Camera.images": divisor},
        state="undesired" if intensity is None else "fulfilled",
        text=text,
    ),
    st.one_of(st.none(), st.just(8.0)),
    st.one_of(st.none(), st.floats(0, 1)),
    st.sampled_from([1.0, 2.0, 3.0, math.inf]),
    st.sampled_from(["it fits", "it costs too much"]),
)


def spelled_out(frame: str) -> list[tuple[float, list[dict[str, Any]]]]:
    """The frame spelled out as the page does: each sample's stamp and rows."""
    message = json.loads(frame)
    assert message["type"] == "lanes_history"
    samples = []
    for number, stamp in enumerate(message["stamps"]):
        rows = []
        for row in message["rows"]:
            assert len(row["rate"]) == len(message["stamps"])
            spell = [spell for spell in row["spells"] if spell["at"] <= number][-1]
            rows.append({"class": row["class"], "rate": row["rate"][number], **{name: spell[name] for name in HELD}})
        samples.append((stamp, rows))
    return samples


@given(st.lists(st.tuples(ROWS, ROWS), max_size=40), st.integers(1, 12))
def test_the_newest_samples_are_sent_as_they_were_and_no_more_are_kept(
    noted: list[tuple[LaneRow, LaneRow]], most: int
) -> None:
    history = LaneHistory(CLASSES, most)
    samples = []
    for number, pair in enumerate(noted):
        rows = tuple(structs.replace(row, cls=cls) for cls, row in zip(CLASSES, pair, strict=True))
        lanes = Lanes(100.0 + 0.5 * number, rows)
        samples.append((lanes.stamp, [json.loads(msgspec.json.encode(row)) for row in lanes.rows]))
        history.add(lanes)
        # Those of a moment later are left out.
        history.add(Lanes(lanes.stamp + 0.05, ()))
        assert all(len(spells) <= most for spells in history._spells.values())
    assert spelled_out(history.frame()) == samples[-most:]


def test_the_frame_is_never_too_large_and_keeps_the_newest() -> None:
    """Ten minutes of a reason that is another each time, which is more than fits."""
    history = LaneHistory(CLASSES)
    for number in range(1300):
        row = structs.replace(USUAL, divisors={}, text=f"{number} {'why ' * 40}")
        history.add(Lanes(0.5 * number, tuple(structs.replace(row, cls=cls) for cls in CLASSES)))
    frame = history.frame()
    assert len(frame) <= 200_000
    samples = spelled_out(frame)
    assert len(samples) >= 300
    assert samples[-1][0] == 0.5 * 1299
    assert samples[-1][1][0]["text"].startswith("1299 ")


def test_a_usual_past_is_small() -> None:
    """Twelve classes, a reason that changes twice a minute."""
    classes = [f"Class{number}" for number in range(12)]
    history = LaneHistory(classes)
    for number in range(1200):
        text = f"fulfilled at its best ({number // 60}) by some-strategy-of-a-usual-length"
        row = structs.replace(USUAL, rate=round(number / 1200, 4), text=text)
        history.add(Lanes(1.7e9 + 0.5 * number, tuple(structs.replace(row, cls=cls) for cls in classes)))
    frame = history.frame()
    assert len(json.loads(frame)["stamps"]) == 1200
    assert len(frame) < 200_000


def test_before_the_first_sample_there_is_no_past() -> None:
    assert spelled_out(LaneHistory(CLASSES).frame()) == []

"""Pictures for one viewer: as good as the link bears with a view that is 200 ms old at most. On a modelled link."""

from __future__ import annotations

import random
from dataclasses import dataclass

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose3
from app.base.network_link import Direction, LinkSettings, Stream
from app.console.live.picture_budget import MOST_UNDER_WAY, RUNGS, VIDEO_RUNGS, Form, PictureBudget, drawn, round_trip
from app.console.live.picture_coder import recoded
from app.messages import EncodedImage

PERIOD_S = 1 / 15
#: From capture until the console has the picture, and from its arrival until it is drawn (s).
CAPTURE_S, DRAW_S = 0.04, 0.015
FULL_BYTES = 38_000
#: All else on the same link: lanes, status, a cloud (bytes a second).
OTHER_BPS = 83_000


@dataclass
class Seen:
    """A run: ages (s) of the pictures when drawn, their rungs, and how many came a second."""

    ages: list[float]
    rungs: list[int]
    rate: float


def watched(settings: LinkSettings, seconds: float, *, adapts: bool = True, vp9: bool = False) -> Seen:
    """A viewer for so long, with pictures 15 times a second and all else of the page on the same link."""
    draw = random.Random(4)
    down, up, stream, back = Direction(draw), Direction(draw), Stream(), Stream()
    budget = round_trip(PictureBudget(), settings.delay_s + 0.01, 0.0)
    under_way: list[tuple[float, float, float]] = []  # acknowledged at, taken at, drawn at
    waiting: float | None = None
    ages: list[float] = []
    rungs: list[int] = []
    tick_s = 0.005
    for tick in range(int(seconds / tick_s)):
        now = tick * tick_s
        if tick % 10 == 0:
            down.send(settings, Stream(), now, int(OTHER_BPS * 10 * tick_s))
        if tick % round(PERIOD_S / tick_s) == 0:
            waiting = now - CAPTURE_S
        while under_way and under_way[0][0] <= now:
            acknowledged, taken, _ = under_way.pop(0)
            budget = drawn(budget, acknowledged - taken, acknowledged, vp9=vp9) if adapts else budget
        if waiting is not None and len(under_way) < budget.most_under_way:
            form = budget.form(640, None, vp9=vp9)
            size = int(FULL_BYTES * 0.7**budget.rung)
            if form.bits is not None:
                size = int(form.bits / 8 * 0.75 * (form.width or 640) ** 2)
            seen = down.send(settings, stream, now, size).arrives + DRAW_S
            under_way.append((up.send(settings, back, max(seen, now), 60).arrives, now, seen))
            ages.append(seen - waiting)
            rungs.append(budget.rung)
            waiting = None
    return Seen(ages, rungs, len(ages) / seconds)


def p95(ages: list[float]) -> float:
    return float(np.percentile(ages, 95))


def test_at_4_mbit_the_view_is_200_ms_old_at_most() -> None:
    seen = watched(LinkSettings(0.04, 0.01, rate_bps=4e6), 60.0)
    assert p95(seen.ages) <= 0.2
    assert seen.rate > 8


def test_at_1_mbit_pictures_are_smaller_and_stay_young() -> None:
    adapted = watched(LinkSettings(0.04, 0.01, rate_bps=1.2e6), 60.0)
    as_they_come = watched(LinkSettings(0.04, 0.01, rate_bps=1.2e6), 60.0, adapts=False)
    assert max(adapted.rungs) > 2
    assert p95(adapted.ages) < 0.6 * p95(as_they_come.ages)


def test_video_is_whole_and_young_where_jpegs_are_late() -> None:
    settings = LinkSettings(0.04, 0.01, rate_bps=4e6)
    video, jpeg = watched(settings, 240.0, vp9=True), watched(settings, 240.0)
    assert p95(video.ages) <= min(0.16, 0.85 * p95(jpeg.ages))
    assert video.rate > 1.4 * jpeg.rate
    # Of full width nearly always; and JPEGs as they come are tried ever more seldom.
    assert np.mean([rung in (1, 2) for rung in video.rungs]) > 0.9
    tries = np.flatnonzero(np.diff(video.rungs) == -1)
    assert 2 <= len([at for at in tries if video.rungs[at + 1] == 0]) <= 8


def test_video_at_1_mbit_has_more_pictures_than_jpeg() -> None:
    settings = LinkSettings(0.04, 0.01, rate_bps=1.2e6)
    video, jpeg = watched(settings, 60.0, vp9=True), watched(settings, 60.0)
    assert video.rate > jpeg.rate
    assert p95(video.ages) < p95(jpeg.ages)


def test_a_link_that_recovers_has_jpegs_again() -> None:
    budget, now, rungs = PictureBudget(), 0.0, []
    for _ in range(3000):
        now += PERIOD_S
        budget = drawn(budget, 0.3 if now < 20.0 and budget.rung == 0 else 0.01, now, vp9=True)
        rungs.append(budget.rung)
    assert 0 not in rungs[60:70]
    assert set(rungs[-600:]) == {0}


def test_a_fast_link_has_pictures_as_they_come() -> None:
    for vp9 in (False, True):
        assert set(watched(LinkSettings(0.02, rate_bps=50e6), 20.0, vp9=vp9).rungs) == {0}


def test_a_long_link_has_as_many_pictures_a_second_as_a_short_one() -> None:
    long = watched(LinkSettings(0.3, 0.05, rate_bps=50e6), 20.0)
    assert long.rate > 12
    assert p95(long.ages) <= CAPTURE_S + DRAW_S + 0.175 + 0.05


@given(st.lists(st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 5.0)), max_size=80))
def test_a_budget_stays_within_its_rungs(lags: list[tuple[float, float]]) -> None:
    budget, now = PictureBudget(), 0.0
    for lag_s, gap_s in lags:
        now += gap_s
        before = budget
        budget = drawn(round_trip(budget, 0.1 * lag_s, now), lag_s, now)
        assert 0 <= budget.rung < len(RUNGS)
        assert budget.rung >= before.rung - 1
        assert 1 <= budget.most_under_way <= MOST_UNDER_WAY


def test_what_the_page_shows_small_is_sent_small() -> None:
    assert PictureBudget().form(640, None) == Form()
    assert PictureBudget().form(640, 640) == Form()
    assert PictureBudget().form(640, 1280) == Form()
    assert PictureBudget().form(640, 300) == Form(320, 70)
    assert PictureBudget().form(640, 640, vp9=True) == Form()
    assert PictureBudget().form(640, 300, vp9=True) == Form(320, 70)
    assert PictureBudget(rung=1).form(640, 300, vp9=True) == Form(320, bits=0.17)
    assert PictureBudget(rung=1).form(640, 640, vp9=True) == Form(640, bits=0.17)
    assert PictureBudget(rung=4).form(640, 640, vp9=True) == Form(480, bits=0.12)
    assert len(VIDEO_RUNGS) == len(RUNGS) - 1
    worst = PictureBudget(rung=len(RUNGS) - 1).form(640, 640)
    assert worst.width is not None
    assert worst.width <= 200


@pytest.mark.parametrize("width", [320, 160, 500, 640, 2000])
def test_a_picture_keeps_its_shape_and_stamp(width: int) -> None:
    pixels = np.zeros((480, 640, 3), np.uint8)
    pixels[:, 320:] = 255
    jpeg = cv2.imencode(".jpg", pixels)[1].tobytes()
    image = EncodedImage(5.0, "camera", jpeg, 640, 480, Pose3.identity())
    small = recoded(image, Form(width, 60))
    assert (small.stamp, small.width) == (5.0, min(width, 640))
    assert small.height == pytest.approx(0.75 * small.width, abs=1)
    shown = cv2.imdecode(np.frombuffer(small.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert shown is not None
    assert shown.shape == (small.height, small.width)
    assert shown[:, : small.width // 3].mean() < 10 < 245 < shown[:, -small.width // 3 :].mean()


def test_a_damaged_picture_is_passed_on() -> None:
    image = EncodedImage(5.0, "camera", b"no JPEG", 640, 480, Pose3.identity())
    assert recoded(image, Form(320, 60)) is image

"""GazeAtSalient by itself: one region after the other, and what it reports of each."""

from __future__ import annotations

import math

import pytest

from app.base.geometry import Pose2
from app.messages import Fixation, Odometry, SalientRegion, SalientRegions
from app.modules.saliency_gains import SaliencyGains
from app.runtime.clock import in_virtual_time
from tests.modules.behaviors.gaze.head_bench import bench_of, commanded, desire, off_axis_deg
from tests.modules.fakes import Bench, drain

GAINS = SaliencyGains().model_dump()
EYE = "kinect_optical_frame"
MIDDLE = (0.08, 0.0, 1.3)


def bench() -> Bench:
    return bench_of(
        "gaze_at_salient:GazeAtSalient",
        {"odometry": Odometry, "regions": SalientRegions},
        outputs={"fixations": Fixation},
        eye=EYE,
        hold_s=1.0,
    )


def regions(stamp: float, *azimuths: float) -> SalientRegions:
    found = tuple(
        SalientRegion(azimuth, 0.1, 0.5, motion=0.5, color=0.0, contrast=0.0, faces=0.0, sounds=0.0)
        for azimuth in azimuths
    )
    return SalientRegions(stamp, MIDDLE, found)


def point(azimuth: float) -> list[float]:
    """The point that is looked at, in base_link."""
    ahead = 2.5 * math.cos(0.1)
    return [MIDDLE[0] + ahead * math.cos(azimuth), ahead * math.sin(azimuth), MIDDLE[2] + 2.5 * math.sin(0.1)]


@in_virtual_time
async def test_the_most_salient_is_looked_at_then_reported_then_the_next() -> None:
    async with bench() as b:
        desire(b, **GAINS)
        fixed = b.listen("fixations")
        assert await commanded(b, 0.3, Pose2()) == [], "nothing stands out yet"
        b.feed("regions", regions(b.clock.now(), 0.8, -0.8))
        looked = await commanded(b, 0.8, Pose2())
        assert off_axis_deg(looked[-1], point(0.8)) < 0.1
        assert drain(fixed) == []
        await commanded(b, 1.0, Pose2())
        (fixation,) = drain(fixed)
        assert (fixation.azimuth, fixation.elevation) == pytest.approx((0.8, 0.1), abs=0.01)
        assert await commanded(b, 0.5, Pose2()) == [], "it waits for what stands out now"
        b.feed("regions", regions(b.clock.now(), -0.8))
        assert off_axis_deg((await commanded(b, 0.5, Pose2()))[-1], point(-0.8)) < 0.1


@in_virtual_time
async def test_a_region_stays_where_it_is_while_the_robot_turns() -> None:
    async with bench() as b:
        desire(b, **GAINS)
        fixed = b.listen("fixations")
        await commanded(b, 0.2, Pose2())
        b.feed("regions", regions(b.clock.now(), 0.8))
        await commanded(b, 0.3, Pose2())
        turned = await commanded(b, 0.3, Pose2(0.0, 0.0, 0.5))
        assert off_axis_deg(turned[-1], point(0.3)) < 0.5
        await commanded(b, 1.0, Pose2(0.0, 0.0, 0.5))
        (fixation,) = drain(fixed)
        assert fixation.azimuth == pytest.approx(0.3, abs=0.01)


@in_virtual_time
async def test_without_a_desire_the_head_is_left_alone() -> None:
    async with bench() as b:
        b.graph.filters.apply({"Tested.command": 1})
        b.feed("regions", regions(b.clock.now(), 0.8))
        assert await commanded(b, 1.0, Pose2()) == []

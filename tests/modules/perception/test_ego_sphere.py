"""EgoSphere by itself: what its messages say of pictures, percepts and fixations, in the robot's axes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.messages import (
    Face,
    Faces,
    Fixation,
    Image,
    LoudNoise,
    Odometry,
    SaliencyMap,
    SalientRegion,
    SalientRegions,
    SoundSource,
    SoundSources,
    read_only,
)
from app.modules.perception.ego_sphere import loudness
from app.runtime.clock import in_virtual_time
from tests.modules.behaviors.gaze.head_bench import EYE, MODEL, URDF
from tests.modules.fakes import Bench, FakeLink, drain
from tests.modules.perception.saliency.pictures import FISHEYE, Disc, camera_at, picture

P_BH = MODEL.pose(EYE).translation
GREY, YELLOW = (90, 90, 90), (230, 220, 30)


def bench(**settings: float) -> Bench:
    link = FakeLink()
    link.description = replace(link.description, model_path=URDF)
    return Bench(
        "app.modules.perception.ego_sphere:EgoSphere",
        inputs={
            "images": Image,
            "panorama": Image,
            "faces": Faces,
            "sources": SoundSources,
            "noises": LoudNoise,
            "fixations": Fixation,
            "odometry": Odometry,
        },
        outputs={"regions": SalientRegions, "saliency": SaliencyMap},
        settings={"eye": EYE, **settings},
        link=link,
        attended=("panorama", "regions", "saliency"),
    )


def watch(b: Bench, **gains: float) -> None:
    """Attention lets it watch."""
    b.graph.configure("Tested", gains)
    b.graph.filters.apply({"Tested.panorama": 1, "Tested.regions": 1, "Tested.saliency": 1})


async def after(b: Bench, seconds: float, X_OB: Pose2) -> None:
    """Odometry for a time."""
    for _ in range(round(seconds / 0.05)):
        b.feed("odometry", Odometry(b.clock.now(), X_OB, 0.0, 0.0))
        await b.clock.sleep(0.05)


def panorama(stamp: float, X_OB: Pose2, *discs: Disc) -> Image:
    """Of a camera where the head is, that looks ahead; discs are in odom's axes."""
    X_OC = camera_at(X_OB.theta, (X_OB.x, X_OB.y, 0.0))
    X_BC = Pose3(X_OB.to_pose3().rotation.T @ X_OC.rotation, P_BH)
    return Image(stamp, "panorama", read_only(picture(FISHEYE, X_OC, discs)), None, FISHEYE, X_BC)


def faces(stamp: float, *at: tuple[float, float, float]) -> Faces:
    marks, spread = read_only(np.zeros((5, 2), np.float32)), read_only(np.eye(3))
    found = tuple(
        Face(track, 0.9, (0, 0, 9, 9), marks, p_BF=p_BF, covariance=spread, range_m=2.0, range_sigma_m=0.1)
        for track, p_BF in enumerate(at)
    )
    return Faces(stamp, "kinect", width=640, height=480, X_BC=Pose3.identity(), faces=found)


def sound(stamp: float, azimuth: float, level_db: float, active: bool = True) -> SoundSources:
    direction = (math.cos(azimuth), math.sin(azimuth), 0.0)
    p_BA = (0.0, 0.0, float(P_BH[2]))
    made = SoundSource(1, direction, 0.5, level_db, active=active, speech=0.1, range_m=math.nan, range_sigma_m=math.nan)
    return SoundSources(stamp, p_BA, (made,))


def newest(subscription: Any) -> tuple[SalientRegion, ...]:
    message: SalientRegions = drain(subscription)[-1]
    assert message.p_BH == pytest.approx(P_BH.tolist())
    return message.regions


@in_virtual_time
async def test_what_moves_is_the_first_region_by_its_motion_where_the_robot_is_now() -> None:
    async with bench() as b:
        watch(b)
        given, X_OB = b.listen("regions"), Pose2(1.0, 2.0, 0.4)
        await after(b, 0.1, X_OB)
        for moved in (0.5, 0.6):
            b.feed("panorama", panorama(b.clock.now() - 0.05, X_OB, Disc(moved, 0.1, YELLOW), Disc(-0.5, 0.0, GREY)))
            await after(b, 0.2, X_OB)
        first = newest(given)[0]
        assert first.azimuth == pytest.approx(0.6 - 0.4, abs=0.1)
        assert first.motion > first.color + first.contrast
        await after(b, 0.2, Pose2(1.0, 2.0, 0.9))
        assert newest(given)[0].azimuth == pytest.approx(0.6 - 0.9, abs=0.1), "the robot turned, the room did not"


@in_virtual_time
async def test_the_map_has_its_most_where_the_first_region_is() -> None:
    async with bench() as b:
        watch(b)
        given, cells, X_OB = b.listen("regions"), b.listen("saliency"), Pose2(0.0, 0.0, 2.0)
        await after(b, 0.1, X_OB)
        b.feed("faces", faces(b.clock.now() - 0.02, (1.0, 2.0, 1.6)))
        await after(b, 0.3, X_OB)
        first, map_ = newest(given)[0], drain(cells)[-1]
        row, column = np.unravel_index(np.argmax(map_.cells), map_.cells.shape)
        rows, columns = map_.cells.shape
        assert math.pi - (column + 0.5) * map_.step == pytest.approx(first.azimuth, abs=map_.step)
        assert (rows / 2 - row - 0.5) * map_.step == pytest.approx(first.elevation, abs=map_.step)
        assert columns * map_.step == pytest.approx(2 * math.pi)
        assert map_.cells.max() == pytest.approx(255 * first.saliency / map_.full, abs=12)


@in_virtual_time
async def test_a_face_is_where_it_is_from_the_head_with_the_pose_of_its_instant() -> None:
    async with bench() as b:
        watch(b)
        given = b.listen("regions")
        for step in range(10):
            stamp = b.clock.now()
            await after(b, 0.05, Pose2(0.0, 0.0, 0.1 * step))
        b.feed("faces", faces(stamp, (2.0, 0.0, float(P_BH[2]))))
        await after(b, 0.3, Pose2(0.0, 0.0, 0.9))
        (region,) = newest(given)
        assert (region.azimuth, region.elevation) == pytest.approx((0.0, 0.0), abs=0.02)
        assert region.faces == pytest.approx(region.saliency)


@in_virtual_time
async def test_a_loud_noise_makes_the_sound_count_double_and_silent_sources_do_not_count() -> None:
    async with bench() as b:
        watch(b)
        given, X_OB = b.listen("regions"), Pose2()
        saliencies = []
        for noise in (False, True):
            await after(b, 10.0, X_OB)
            drain(given)
            if noise:
                b.feed("noises", LoudNoise(b.clock.now() - 0.1, 30.0, -50.0))
            b.feed("sources", sound(b.clock.now() - 0.02, -2.5, -50.0))
            await after(b, 0.4, X_OB)
            (region,) = newest(given)
            assert region.azimuth == pytest.approx(-2.5, abs=0.03), "behind, where no camera looks"
            saliencies.append(region.saliency)
        assert saliencies[1] == pytest.approx(2 * saliencies[0], rel=0.1)
        await after(b, 10.0, X_OB)
        drain(given)
        b.feed("sources", sound(b.clock.now() - 0.02, 1.0, -20.0, active=False))
        await after(b, 0.4, X_OB)
        assert newest(given) == ()


@in_virtual_time
async def test_gains_of_a_desire_and_what_other_strategies_raise_decide_who_is_first() -> None:
    async with bench() as b:
        given, X_OB = b.listen("regions"), Pose2()

        async def first(**parameters: float) -> SalientRegion:
            watch(b, **parameters)
            await after(b, 10.0, X_OB)
            b.feed("faces", faces(b.clock.now() - 0.02, (2.0, 1.0, 1.5)))
            b.feed("sources", sound(b.clock.now() - 0.02, -1.0, -30.0))
            await after(b, 0.3, X_OB)
            return newest(given)[0]

        assert (await first()).azimuth < 0
        assert (await first(raised_faces=2.0)).azimuth > 0
        assert (await first(raised_faces=2.0, sounds=4.0)).azimuth < 0
        assert (await first(sounds=0.0)).azimuth > 0


@in_virtual_time
async def test_what_was_looked_at_is_left_for_a_while() -> None:
    async with bench(recovery_s=2.0) as b:
        watch(b)
        given, X_OB = b.listen("regions"), Pose2(0.0, 0.0, 0.7)

        async def seen() -> tuple[SalientRegion, ...]:
            b.feed("faces", faces(b.clock.now() - 0.02, (2.0, 1.0, 1.5)))
            await after(b, 0.3, X_OB)
            return newest(given)

        await after(b, 0.1, X_OB)
        (region,) = await seen()
        b.feed("fixations", Fixation(b.clock.now() - 0.02, region.azimuth, region.elevation))
        await after(b, 0.1, X_OB)
        near = [each for each in await seen() if abs(each.azimuth - region.azimuth) < 0.1]
        assert sum(each.saliency for each in near) < 0.3 * region.saliency
        await after(b, 5.0, X_OB)
        assert (await seen())[0].saliency > 0.8 * region.saliency


@in_virtual_time
async def test_while_nothing_desires_it_nothing_is_published_and_it_begins_empty() -> None:
    async with bench(decay_s=60.0) as b:
        watch(b)
        given, X_OB = b.listen("regions"), Pose2()
        await after(b, 0.1, X_OB)
        b.feed("faces", faces(b.clock.now() - 0.02, (2.0, 1.0, 1.5)))
        await after(b, 0.3, X_OB)
        assert len(newest(given)) == 1
        b.graph.filters.apply({"Tested.regions": math.inf, "Tested.saliency": math.inf})
        await after(b, 1.0, X_OB)
        assert len(drain(given)) <= 1, "at most one that was on its way"
        watch(b)
        await after(b, 0.5, X_OB)
        assert newest(given) == ()


@pytest.mark.parametrize(("level_db", "counts"), [(-90, 0.1), (-47.5, 0.5), (-30, 1.0), (0, 1.0)])
def test_the_louder_the_more_it_counts(level_db: float, counts: float) -> None:
    assert loudness(level_db) == pytest.approx(counts)

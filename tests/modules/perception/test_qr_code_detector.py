from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.messages import Image, Landmark, Landmarks, LaserScan, Odometry, QRCodes
from app.modules.perception.qr_code_detector import QRCodeDetector
from app.modules.perception.qr_codes import detect
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain
from tests.modules.perception.rendering import X_BC, facing, kinect_image
from tests.scenery.posters import PANORAMA, picture

STOP = facing(3.0, 0.4, 1.4)


def bench() -> Bench:
    return Bench(
        "app.modules.perception.qr_code_detector:QRCodeDetector",
        inputs={"images": Image, "odometry": Odometry},
        outputs={"codes": QRCodes, "landmarks": Landmarks},
    )


def pose(seconds: float) -> Pose2:
    """The robot drives a gentle curve past the poster."""
    return Pose2(0.4 * seconds, 0.1 * seconds, 0.05 * seconds)


def test_a_moving_robot_with_late_odometry_places_a_code_by_the_images_own_stamp() -> None:
    async def main() -> None:
        async with bench() as b:
            codes, landmarks = b.listen("codes"), b.listen("landmarks")
            start = b.clock.now()
            late = 0.2  # s; the newest pose known when a code is found is wrong by 0.08 m
            published = 0
            for shot in range(20):
                at = shot * 0.25
                b.feed("images", kinect_image(start + at, pose(at), {"stop": STOP}, seed=shot))
                while b.clock.now() < start + at + 0.25:
                    stamp = 0.01 * published - late
                    b.feed("odometry", Odometry(start + stamp, pose(stamp), 0.4, 0.05))
                    published += 1
                    await b.clock.sleep_until(start + stamp + late + 0.01)
            seen = [m for m in drain(codes) if m.codes]
            assert len(seen) >= 10
            assert seen[0].frame == "kinect_optical_frame"
            (landmark,) = drain(landmarks)[-1].landmarks
            assert landmark.text == "stop"
            assert math.dist(landmark.p_FQ, tuple(STOP.translation)) < 0.02
            assert landmark.sightings >= 10
            assert landmark.sigma_m < 0.05

    run_virtual(main())


def test_images_without_a_code_give_an_empty_message_and_no_landmark() -> None:
    async def main() -> None:
        async with bench() as b:
            codes, landmarks = b.listen("codes"), b.listen("landmarks")
            image = kinect_image(b.clock.now(), Pose2(), {})
            b.feed("images", image)
            message = await codes.receive()
            assert message.codes == ()
            assert message.X_BC is image.X_BC
            assert (message.height, message.width) == image.color.shape[:2]
            await b.clock.sleep(1.0)
            assert drain(landmarks) == []

    run_virtual(main())


def test_a_code_whose_pose_never_comes_is_seen_but_not_placed(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        async with bench() as b:
            codes, landmarks = b.listen("codes"), b.listen("landmarks")
            for _ in range(2):
                b.feed("images", kinect_image(b.clock.now(), Pose2(), {"stop": facing(1.5, 0, 1.3)}))
                assert [c.text for c in (await codes.receive()).codes] == ["stop"]
                await b.clock.sleep(1.0)
            assert drain(landmarks) == []

    run_virtual(main())
    assert len([r for r in caplog.records if "are not placed" in r.message]) == 1


def test_landmarks_are_reported_when_added_or_moved_and_outlive_a_restart() -> None:
    still = {"stop": facing(1.5, 0, 1.3)}

    async def main() -> None:
        async with bench() as b:
            codes, landmarks = b.listen("codes"), b.listen("landmarks")

            async def look(x: float) -> list[Landmarks]:
                now = b.clock.now()
                b.feed("odometry", Odometry(now - 0.01, Pose2(x), 0, 0))
                b.feed("odometry", Odometry(now + 0.01, Pose2(x), 0, 0))
                b.feed("images", kinect_image(now, Pose2(), still, noise=0, depth_noise=False))
                await codes.receive()
                await b.clock.sleep(0.05)
                return drain(landmarks)

            assert len(await look(0.0)) == 1, "a new one is news"
            assert await look(0.0) == [], "the same again is not"
            (moved,) = await look(0.5)
            assert moved.landmarks[0].sightings == 3
            x = moved.landmarks[0].p_FQ[0] - still["stop"].translation[0]
            assert await look(x) == []
            await b.clock.sleep(1.0)
            (again,) = await look(x)
            assert again.landmarks[0].sightings == 5
            # A message that cannot be an image makes the module fail; its next life goes on where this one was.
            b.feed("images", None)
            await b.clock.sleep(2.0)
            assert b.supervisor.states["Tested"].restarts == 1
            (later,) = await look(0.1)
            assert [(m.text, m.sightings) for m in later.landmarks] == [("stop", 6)]

    run_virtual(main())


def test_the_desire_decides_on_the_second_try() -> None:
    text = "hbba:tour/stop-2/robot-lab"
    images = (kinect_image(0.0, Pose2(), {text: facing(2.6, 0.013 * i, 1.3 + 0.017 * i)}, seed=i) for i in range(4))
    hard = next(image for image in images if not detect(image, upscale=False))

    async def main() -> None:
        async with bench() as b:
            codes = b.listen("codes")
            read = []
            for parameters in ({"upscale": False}, {"upscale": True}, {}):
                b.slot.configure(parameters)
                b.feed("images", hard)
                read.append(len((await codes.receive()).codes))
            assert read == [0, 1, 1]

    run_virtual(main())


# --- The panoramic camera and the laser ------------------------------------------------------------------------------

#: Beside the robot's way, 0.9 m to the left of it, looking at it.
DOOR = Pose3.from_translation_rpy((0.6, 0.9, 1.25), (0.0, 0.0, math.pi / 2)) @ Pose3.from_translation_rpy(
    (0.0, 0.0, 0.0), (-math.pi / 2, 0.0, -math.pi / 2)
)
X_BL = Pose3.from_translation_rpy((0.2, 0.0, 0.4))


def panorama_image(stamp: float, X_OB: Pose2, seed: int = 0) -> Image:
    X_CQ = (X_OB.to_pose3() @ X_BC).inverse() @ DOOR
    return Image(stamp, "panorama_optical_frame", picture(PANORAMA, {"door": X_CQ}, seed=seed), None, PANORAMA, X_BC)


def wall_scan(stamp: float, X_OB: Pose2, wall_y: float = 0.9) -> LaserScan:
    """An endless wall along y = ``wall_y`` of odom, seen by the laser at ``X_OB`` with a noise of 1 cm."""
    angles = -math.pi / 2 + math.pi / 719 * np.arange(720)
    towards = np.sin(angles + X_OB.theta)
    _, y, _ = X_OB.to_pose3().transform(X_BL.translation)
    with np.errstate(divide="ignore"):
        ranges = np.where(towards > 0.02, (wall_y - y) / towards, np.inf)
    ranges = (ranges + np.random.default_rng(round(stamp * 1000) % 2**32).normal(0, 0.01, 720)).astype(np.float32)
    return LaserScan(stamp, "laser", ranges, ranges, -math.pi / 2, math.pi / 719, 0.1, 30.0, 0.0125, X_BL)


def whole_bench() -> Bench:
    return Bench(
        "app.modules.perception.qr_code_detector:QRCodeDetector",
        inputs={"images": Image, "panorama": Image, "scans": LaserScan, "odometry": Odometry},
        outputs={"codes": QRCodes, "landmarks": Landmarks},
    )


def known(b: Bench) -> tuple[Landmark, ...]:
    """The landmarks that the module knows, published or not."""
    module = b.slot.context.instance
    assert isinstance(module, QRCodeDetector)
    return module._map.landmarks


async def drive_past(b: Bench, shots: int, scan_delay_s: float = 0.0, wall_y: float = 0.9) -> float:
    """Five panoramas a second beside the wall, scans and odometry at their rates; returns when it began."""
    start = b.clock.now()
    for turn in range(shots * 20):
        at = 0.01 * turn
        b.feed("odometry", Odometry(start + at, pose(at), 0.4, 0.05))
        if turn % 2 == 1:
            seen_at = at - 0.02 - scan_delay_s
            b.feed("scans", wall_scan(start + seen_at, pose(seen_at), wall_y))
        if turn % 20 == 5:
            b.feed("panorama", panorama_image(start + at, pose(at), seed=turn))
        await b.clock.sleep_until(start + at + 0.01)
    return start


def test_a_panoramas_code_hangs_where_its_ray_meets_the_wall_that_the_laser_sees() -> None:
    async def main() -> None:
        async with whole_bench() as b:
            codes, landmarks = b.listen("codes"), b.listen("landmarks")
            start = await drive_past(b, 4)
            seen = [m for m in drain(codes) if m.codes]
            assert len(seen) >= 3
            for message in seen:
                assert message.frame == "panorama_optical_frame"
                (code,) = message.codes
                assert code.p_BQ is not None
                expected = pose(message.stamp - start).inverse().to_pose3().transform(DOOR.translation)
                assert math.dist(code.p_BQ, tuple(expected)) < 0.05
            assert len(drain(landmarks)) == 1
            (landmark,) = known(b)
            assert landmark.sightings == len(seen)
            assert math.dist(landmark.p_FQ, tuple(DOOR.translation)) < 0.03
            assert 0.01 < landmark.sigma_m < 0.05

    run_virtual(main())


@pytest.mark.parametrize(
    ("scan_delay_s", "wall_y"),
    [pytest.param(0.3, 0.9, id="scans too old"), pytest.param(0.0, 3.5, id="a wall too far for a code of that size")],
)
def test_without_a_scan_that_fits_a_code_is_seen_but_not_placed(scan_delay_s: float, wall_y: float) -> None:
    async def main() -> None:
        async with whole_bench() as b:
            codes, landmarks = b.listen("codes"), b.listen("landmarks")
            await drive_past(b, 3, scan_delay_s, wall_y)
            seen = [code for message in drain(codes) for code in message.codes]
            assert seen
            assert all(code.p_BQ is None for code in seen)
            assert drain(landmarks) == []

    run_virtual(main())


def test_both_cameras_move_one_landmark_and_time_does_not_go_back() -> None:
    async def main() -> None:
        async with whole_bench() as b:
            landmarks = b.listen("landmarks")
            X_OB = Pose2(0.0, 0.0, 0.8)

            now = b.clock.now()
            for at in (-0.05, 0.0, 0.05, 0.1):
                b.feed("odometry", Odometry(now + at, X_OB, 0, 0))
            b.feed("scans", wall_scan(now, X_OB))
            b.feed("images", kinect_image(now + 0.04, X_OB, {"door": DOOR}))
            await b.clock.sleep(0.2)
            b.feed("panorama", panorama_image(now, X_OB))
            await b.clock.sleep(1.2)
            b.feed("panorama", panorama_image(now + 0.01, X_OB))
            await b.clock.sleep(0.2)
            published = drain(landmarks)
            stamps = [message.stamp for message in published]
            assert stamps == sorted(stamps)
            (landmark,) = known(b)
            assert landmark.sightings == 3
            assert math.dist(landmark.p_FQ, tuple(DOOR.translation)) < 0.03

    run_virtual(main())

from __future__ import annotations

import math

import pytest

from app.geometry import Pose2
from app.messages import Image, Landmarks, Odometry, QRCodes
from app.modules.perception.qr_codes import detect
from app.runtime.clock import run_virtual

from ..fakes import Bench, drain
from .rendering import facing, kinect_image

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
            told = 0
            for shot in range(20):
                at = shot * 0.25
                b.feed("images", kinect_image(start + at, pose(at), {"stop": STOP}, seed=shot))
                while b.clock.now() < start + at + 0.25:
                    stamp = 0.01 * told - late
                    b.feed("odometry", Odometry(start + stamp, pose(stamp), 0.4, 0.05))
                    told += 1
                    await b.clock.sleep_until(start + stamp + late + 0.01)
            seen = [m for m in drain(codes) if m.codes]
            assert len(seen) >= 10
            assert seen[0].frame == "kinect_optical_frame"
            (landmark,) = drain(landmarks)[-1].landmarks
            assert landmark.text == "stop"
            assert math.dist(landmark.p_OQ, tuple(STOP.translation)) < 0.02
            assert landmark.sightings >= 10
            assert landmark.sigma_m < 0.05

    run_virtual(main())


def test_images_without_a_code_give_an_empty_message_and_no_landmark() -> None:
    async def main() -> None:
        async with bench() as b:
            codes, landmarks = b.listen("codes"), b.listen("landmarks")
            b.feed("images", kinect_image(b.clock.now(), Pose2(), {}))
            assert (await codes.receive()).codes == ()
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


def test_landmarks_are_told_when_added_or_moved_and_outlive_a_restart() -> None:
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
            x = moved.landmarks[0].p_OQ[0] - still["stop"].translation[0]
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

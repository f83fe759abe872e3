from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.messages import Face, Faces, Image, Odometry, Person, Persons, TorsoColors
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain
from tests.scenery.face_scenes import FaceCard, facing, kinect_image, panorama_image

PILOT, VISITOR = facing("pilot", (2.0, 0.4, 1.6)), facing("visitor", (1.8, -0.5, 1.5))
CAMERAS = ("images", "panorama")


def bench(cameras: tuple[str, ...] = CAMERAS, attended: tuple[str, ...] = ()) -> Bench:
    return Bench(
        "app.modules.perception.face_detector:FaceDetector",
        inputs={**dict.fromkeys(cameras, Image), "odometry": Odometry},
        outputs={"faces": Faces},
        attended=attended,
    )


def legs_of_a_person(track: int, stamp: float, at: tuple[float, float]) -> Person:
    return Person(
        track,
        None,
        "unsure",
        p_OP=(*at, 1.57),
        v_O=(0.0, 0.0),
        covariance=0.01 * np.eye(2),
        face=None,
        voice=None,
        legs=True,
        speaking=False,
        last_seen=stamp,
    )


def be_at(b: Bench, stamp: float, X_OB: Pose2) -> None:
    """Odometry on both sides of ``stamp``, so that the pose at it is known."""
    for at in (stamp - 0.005, stamp + 0.005):
        b.feed("odometry", Odometry(at, X_OB, 0.0, 0.0))


def error_m(face: Face, card: FaceCard, X_OB: Pose2) -> float:
    p_OF = X_OB.to_pose3().transform(np.array(face.p_BF))
    return math.dist(p_OF.tolist(), card.place)


def of(faces: Faces, card: FaceCard, X_OB: Pose2) -> Face | None:
    """The face seen where ``card`` is, by its azimuth."""
    x, y, _ = X_OB.to_pose3().inverse().transform(np.array(card.place)).tolist()

    def beside(face: Face) -> float:
        return abs(math.atan2(face.p_BF[1], face.p_BF[0]) - math.atan2(y, x))

    return min((face for face in faces.faces if beside(face) < 0.1), key=beside, default=None)


def test_faces_are_placed_by_depth_and_by_height_and_keep_their_numbers_over_both_cameras_while_the_robot_turns() -> (
    None
):
    async def main() -> None:
        async with bench() as b:
            seen = b.listen("faces")
            numbers: dict[str, set[int]] = {"pilot": set(), "visitor": set()}
            start = b.clock.now()
            for shot in range(10):
                # 0.8 rad/s: both faces cross half of the Kinect's image, and leave it at last.
                at, X_OB = start + 0.1 * shot, Pose2(0.0, 0.0, -0.3 + 0.08 * shot)
                be_at(b, at, X_OB)
                camera = "images" if shot % 2 else "panorama"
                image = (kinect_image if shot % 2 else panorama_image)(at, X_OB, [PILOT, VISITOR], seed=shot)
                b.feed(camera, image)
                faces = await seen.receive()
                assert (faces.stamp, faces.frame) == (at, image.frame)
                for card in (PILOT, VISITOR):
                    face = of(faces, card, X_OB)
                    if face is None:
                        assert camera == "images", "the Kinect alone does not see both all the time"
                        continue
                    numbers[card.name].add(face.track)
                    deviation = np.array(face.p_BF) - X_OB.to_pose3().inverse().transform(np.array(card.place))
                    assert deviation @ np.linalg.solve(face.covariance, deviation) < 16, "within four deviations"
                    if camera == "images":
                        assert error_m(face, card, X_OB) < 0.04
                        assert face.range_sigma_m < 0.05
                    elif shot > 2:
                        # The Kinect has measured their heights, so the panorama's distances are good too.
                        assert error_m(face, card, X_OB) < 0.12
            assert [len(n) for n in numbers.values()] == [1, 1]
            assert numbers["pilot"] | numbers["visitor"] == {1, 2}

    run_virtual(main())


@pytest.mark.parametrize("camera", CAMERAS)
def test_either_camera_may_be_missing(camera: str) -> None:
    make = {"images": kinect_image, "panorama": panorama_image}[camera]

    async def main() -> None:
        async with bench((camera,)) as b:
            seen = b.listen("faces")
            at = b.clock.now()
            be_at(b, at, Pose2())
            image = make(at, Pose2(), [PILOT])
            b.feed(camera, image)
            message = await seen.receive()
            assert message.X_BC is image.X_BC
            assert (message.height, message.width) == image.color.shape[:2]
            (face,) = message.faces
            assert face.track == 1
            assert face.range_m == pytest.approx(math.dist(PILOT.place, (0.1, 0, 1.25)), abs=2 * face.range_sigma_m)
            assert (face.range_sigma_m > 0.2) == (camera == "panorama")
            assert not face.landmarks.flags.writeable
            assert not face.covariance.flags.writeable

    run_virtual(main())


def test_what_is_below_each_face_is_published_by_its_track() -> None:
    async def main() -> None:
        b = Bench(
            "app.modules.perception.face_detector:FaceDetector",
            inputs={"panorama": Image, "odometry": Odometry},
            outputs={"faces": Faces, "torsos": TorsoColors},
        )
        # Of a card the Kinect sees by its depth that no torso is below it.
        async with b:
            seen, colors = b.listen("faces"), b.listen("torsos")
            at = b.clock.now()
            be_at(b, at, Pose2())
            b.feed("panorama", panorama_image(at, Pose2(), [PILOT]))
            faces, torsos = await seen.receive(), await colors.receive()
            assert (torsos.stamp, torsos.frame) == (faces.stamp, faces.frame)
            assert torsos.tracks == tuple(face.track for face in faces.faces)
            assert torsos.histograms.sum(axis=1) == pytest.approx([1.0])

    run_virtual(main())


def test_what_is_above_the_legs_of_a_person_is_published_by_the_persons_track() -> None:
    async def main() -> None:
        b = Bench(
            "app.modules.perception.face_detector:FaceDetector",
            inputs={"panorama": Image, "odometry": Odometry, "persons": Persons},
            outputs={"faces": Faces, "torsos": TorsoColors},
        )
        async with b:
            colors = b.listen("torsos")
            at = b.clock.now()
            be_at(b, at, Pose2())
            b.feed("persons", Persons(at, (legs_of_a_person(12, at, (2.0, 0.5)),)))
            await b.clock.sleep(0.01)
            b.feed("panorama", panorama_image(at, Pose2(), []))
            torsos = await colors.receive()
            assert (torsos.tracks, torsos.persons) == ((), (12,))
            assert torsos.histograms.sum(axis=1) == pytest.approx([1.0])

    run_virtual(main())


def test_a_closed_camera_is_not_looked_at() -> None:
    async def main() -> None:
        async with bench(attended=("images", "panorama")) as b:
            seen = b.listen("faces")
            b.graph.filters.apply({"Tested.images": 1})
            at = b.clock.now()
            be_at(b, at, Pose2())
            b.feed("panorama", panorama_image(at, Pose2(), [PILOT]))
            b.feed("images", kinect_image(at, Pose2(), [PILOT]))
            await b.clock.sleep(0.5)
            assert [faces.frame for faces in drain(seen)] == ["kinect"]

    run_virtual(main())


def test_no_face_is_reported_too() -> None:
    async def main() -> None:
        async with bench() as b:
            seen = b.listen("faces")
            b.feed("images", kinect_image(b.clock.now(), Pose2(), []))
            assert (await seen.receive()).faces == ()

    run_virtual(main())


def test_strategy_and_desire_decide_how_finely_and_how_surely() -> None:
    far = facing("visitor", (4.2, 0.0, 1.5))

    async def main() -> None:
        async with bench() as b:
            seen = b.listen("faces")
            found = []
            for parameters in ({}, {"fine": False}, {"fine": True, "min_score": 0.99}):
                b.slot.configure(parameters)
                at = b.clock.now()
                be_at(b, at, Pose2())
                b.feed("images", kinect_image(at, Pose2(), [far]))
                found.append(len((await seen.receive()).faces))
            assert found == [1, 0, 0]

    run_virtual(main())


def test_without_odometry_faces_are_followed_in_the_image(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        async with bench() as b:
            seen = b.listen("faces")
            for shot in range(3):
                b.feed("images", kinect_image(b.clock.now(), Pose2(), [PILOT, VISITOR], seed=shot))
                faces = (await seen.receive()).faces
                assert sorted(face.track for face in faces) == [1, 2]
                assert all(face.range_sigma_m < 0.05 for face in faces)

    run_virtual(main())
    assert len([r for r in caplog.records if "odometry does not reach" in r.message]) == 1


def test_after_a_restart_numbers_go_on() -> None:
    async def main() -> None:
        async with bench() as b:
            seen = b.listen("faces")

            async def look(*faces: FaceCard) -> list[int]:
                at = b.clock.now()
                be_at(b, at, Pose2())
                b.feed("images", kinect_image(at, Pose2(), list(faces)))
                return sorted(face.track for face in (await seen.receive()).faces)

            assert await look(PILOT, VISITOR) == [1, 2]
            assert await look() == [], "what was published last does not say how many there were"
            b.feed("images", None)  # cannot be an image: the module fails
            await b.clock.sleep(2.0)
            assert b.supervisor.states["Tested"].restarts == 1
            assert await look(PILOT, VISITOR) == [3, 4]
            b.graph.reset()
            b.feed("images", None)
            await b.clock.sleep(4.0)
            assert b.supervisor.states["Tested"].restarts == 2
            assert await look(PILOT) == [1], "after a restart numbers begin again"

    run_virtual(main())

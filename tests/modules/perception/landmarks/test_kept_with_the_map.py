"""QRCodeDetector with a map: its landmarks hang on keyframes, and are kept and loaded with the map."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.base.geometry import FloatArray, Pose2, Pose3
from app.maps.library import MapLibrary
from app.maps.map_service import Files, MapService
from app.messages import DisplacedLandmarks, Image, Keyframes, LandmarkPose, Landmarks, Odometry, QRCodes, Zone
from app.modules.perception.landmarks.landmark_file import LANDMARKS_FILE
from app.runtime.clock import run_virtual
from tests.modules.behaviors.driven_world import box, mapped
from tests.modules.fakes import Bench, drain
from tests.modules.perception.landmarks.graphs import keyframes, turned
from tests.modules.perception.rendering import facing, kinect_image

GRID = mapped(box(0.1, 0.1, 3.9, 3.9), (0.0, 0.0, 4.0, 4.0))
#: In odom, before the robot that stands at its origin.
STOP = facing(1.5, 0.1, 1.3, 0.2)
#: odom on the map.
X_MO = Pose2(5.0, -2.0, 1.0)
P_MQ = X_MO.to_pose3().transform(STOP.translation)
GRAPH = {0: X_MO @ Pose2(-1.0, 0.0, 0.0), 1: X_MO}
Script = Callable[["Visit"], Awaitable[None]]


class Visit:
    """The module, a map server that does nothing but keep, and a robot that stands at the origin of odom."""

    def __init__(self, library: MapLibrary, **settings: float) -> None:
        self.library, self.control, self.name = library, MapService(), ""
        self.control.attach(self)
        self.bench = Bench(
            "app.modules.perception.qr_code_detector:QRCodeDetector",
            inputs={"images": Image, "odometry": Odometry, "keyframes": Keyframes},
            outputs={"codes": QRCodes, "landmarks": Landmarks, "displaced": DisplacedLandmarks, "poses": LandmarkPose},
            services={MapLibrary: library, MapService: self.control},
            settings=settings,
        )
        self.version = 0
        self.landmarks = self.bench.listen("landmarks")
        self.displaced = self.bench.listen("displaced")
        self.poses = self.bench.listen("poses")
        self.newest = Landmarks(0.0, ())

    def map(self, state: str = "mapping", graph: Mapping[int, Pose2] = GRAPH, X_MO: Pose2 = X_MO) -> None:
        """The map's keyframes come, with odom at ``X_MO`` on it."""
        self.version += 1
        message = keyframes(graph, X_MO, X_OB=Pose2(), state=state, version=self.version)
        self.bench.feed("keyframes", replace(message, stamp=self.bench.clock.now()))

    async def look(self, posters: Mapping[str, Pose3], times: int = 1) -> Landmarks:
        """Take pictures of ``posters``; returns the landmarks published last."""
        for _ in range(times):
            now = self.bench.clock.now()
            for at in (now - 0.3, now - 0.1, now + 0.01):
                self.bench.feed("odometry", Odometry(at, Pose2(), 0.0, 0.0))
            self.bench.feed("images", kinect_image(now, Pose2(), dict(posters), noise=0, depth_noise=False))
            await self.bench.clock.sleep(1.0)
        return await self.known()

    async def known(self) -> Landmarks:
        await self.bench.clock.sleep(0.1)
        self.newest = [self.newest, *drain(self.landmarks)][-1]
        return self.newest

    # --- As a map server ---

    async def save(self, name: str, others: Files | None = None) -> None:
        await asyncio.to_thread(self.library.keep, name, GRID, (), others, self.name)
        self.name = name

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        self.name = name
        self.map("searching")

    async def begin(self) -> None:
        self.name = ""
        self.map("searching", {})

    async def place(self, X_MB: Pose2) -> None: ...

    async def search(self) -> None: ...

    async def mark(self, zones: tuple[Zone, ...]) -> None: ...


def visit(tmp_path: Path, script: Script, *, fails: bool = False, **settings: float) -> None:
    made = Visit(MapLibrary(tmp_path), **settings)

    async def main() -> None:
        async with made.bench:
            await made.bench.supervisor.started()
            await script(made)

    run_virtual(main())
    assert bool(made.bench.problem) == fails


def assert_at(landmarks: Landmarks, p: FloatArray, frame: str = "map") -> None:
    assert landmarks.frame == frame
    (mark,) = landmarks.landmarks
    np.testing.assert_allclose(mark.p_FQ, p, atol=0.02)
    assert mark.heading is not None
    assert turned(mark.heading, math.pi + 0.2 + (X_MO.theta if frame == "map" else 0.0)) < 0.1


def test_a_code_seen_before_the_map_is_on_it_once_the_robot_is_localized(tmp_path: Path) -> None:
    async def script(body: Visit) -> None:
        assert_at(await body.look({"stop": STOP}), STOP.translation, "odom")
        body.map()
        assert_at(await body.known(), P_MQ)

    visit(tmp_path, script)


def test_a_landmark_follows_its_keyframe_also_after_a_restart(tmp_path: Path) -> None:
    async def script(body: Visit) -> None:
        body.map()
        await body.look({"stop": STOP})
        # A message that is no image makes the module fail.
        body.bench.feed("images", None)
        await body.bench.clock.sleep(2.0)
        assert body.bench.supervisor.states["Tested"].restarts == 1
        moved = Pose2(5.5, -2.0, 1.0)
        body.map(graph={0: GRAPH[0], 1: moved}, X_MO=moved)
        assert_at(await body.known(), P_MQ + np.array([0.5, 0.0, 0.0]))

    visit(tmp_path, script, fails=True)


def test_landmarks_are_kept_loaded_and_forgotten_with_the_map(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async def first(body: Visit) -> None:
        body.map()
        await body.look({"stop": STOP})
        await body.control.server.save("hall")
        await body.control.server.begin()
        body.map()
        assert (await body.known()).landmarks == ()
        await body.control.server.save("empty")

    async def second(body: Visit) -> None:
        await body.control.server.load("hall")
        assert_at(await body.known(), P_MQ)
        body.map("tracking")
        merged = await body.look({"stop": STOP}, times=2)
        assert_at(merged, P_MQ)
        assert (merged.landmarks[0].id, merged.landmarks[0].sightings) == (1, 3)
        await body.control.server.load("empty")
        assert (await body.known()).landmarks == ()
        await asyncio.to_thread((tmp_path / "hall" / LANDMARKS_FILE).write_bytes, b"broken")
        await body.control.server.load("hall")
        assert (await body.known()).landmarks == ()

    visit(tmp_path, first)
    visit(tmp_path, second)
    assert "landmarks on the map hall are not known" in caplog.text


def test_a_map_kept_without_landmarks_is_loaded_as_before(tmp_path: Path) -> None:
    async def script(body: Visit) -> None:
        await asyncio.to_thread(body.library.keep, "old", GRID)
        await body.control.server.load("old")
        body.map("tracking")
        assert_at(await body.look({"stop": STOP}), P_MQ)

    visit(tmp_path, script)


def test_a_lost_robot_has_its_pose_by_a_landmark_and_places_nothing(tmp_path: Path) -> None:
    async def first(body: Visit) -> None:
        body.map()
        await body.look({"stop": STOP})
        await body.control.server.save("hall")

    async def second(body: Visit) -> None:
        await body.control.server.load("hall")
        known = await body.look({"stop": STOP})
        assert known.landmarks[0].sightings == 1
        (by,) = drain(body.poses)
        off = X_MO.inverse() @ by.X_MO
        assert math.hypot(off.x, off.y) < 0.15
        assert abs(off.theta) < 0.1
        assert (by.landmark, by.text) == (1, "stop")
        body.map("tracking")
        await body.look({"stop": STOP})
        assert drain(body.poses) == []

    visit(tmp_path, first)
    visit(tmp_path, second)


def test_a_code_that_hangs_elsewhere_is_reported_with_both_places(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    now = facing(1.5, -0.5, 1.3, 0.2)

    async def first(body: Visit) -> None:
        body.map()
        await body.look({"stop": STOP})
        await body.control.server.save("hall")

    async def second(body: Visit) -> None:
        await body.control.server.load("hall")
        body.map("tracking")
        await body.look({"stop": now}, times=4)
        (report,) = drain(body.displaced)[-1].landmarks
        np.testing.assert_allclose(report.p_MQ, P_MQ, atol=0.02)
        np.testing.assert_allclose(report.p_MR, X_MO.to_pose3().transform(now.translation), atol=0.02)
        # Where it was it is looked for in vain until it is gone.
        known = await body.look({"stop": now}, times=3)
        assert [mark.id for mark in known.landmarks] == [2]
        assert drain(body.displaced)[-1].landmarks == ()

    visit(tmp_path, first)
    visit(tmp_path, second, gone_looks=6, gone_s=4)
    assert "the code 'stop' hangs at" in caplog.text
    assert "the code 'stop' is gone from" in caplog.text


def test_a_code_out_of_sight_is_not_gone(tmp_path: Path) -> None:
    async def script(body: Visit) -> None:
        body.map()
        await body.look({"stop": STOP})
        # The camera looks at another wall, on which something hangs, from a place where the first is not in view.
        away = X_MO @ Pose2(0.0, 0.0, 2.0)
        body.map(X_MO=away)
        known = await body.look({"other": STOP}, times=4)
        assert sorted(mark.text for mark in known.landmarks) == ["other", "stop"]

    visit(tmp_path, script, gone_looks=3, gone_s=1)

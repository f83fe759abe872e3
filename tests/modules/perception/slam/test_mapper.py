"""Whole drives: loops close, kept maps are followed, what is passed again and again does not grow."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.mapper import Slam
from app.modules.perception.slam.offline_mapping import MappedLog, Sweep, mapped
from app.modules.perception.slam.settings import SlamSettings
from app.modules.perception.slam.types import SlamState
from tests.modules.perception.slam.rooms import around, driven, half_circle, ring, room, seen

BEAMS = half_circle(181)
WALLS = ring(9.5, 2.5)
SIDE = 12.0


def off(log: MappedLog, true: list[Pose2]) -> float:
    """The greatest distance (m) of a pose from the true one."""
    start = true[0].inverse()
    wanted = np.array([((p := start @ pose).x, p.y) for pose in true])
    return float(np.hypot(*(log.poses()[:, :2] - wanted).T).max())


@pytest.fixture(scope="module")
def lap() -> tuple[MappedLog, list[Pose2]]:
    """A lap and a little more around a block."""
    true = around(SIDE, 0.25, laps=1.25)
    return mapped(driven(WALLS, true, BEAMS)), true


def test_a_loop_is_closed_and_the_map_is_true(lap: tuple[MappedLog, list[Pose2]]) -> None:
    log, true = lap
    assert log.slam.loops > 3
    assert log.unmatched() == 0
    assert off(log, true) < 0.15
    ends = [
        math.hypot(p.X_OB.x - q.x, p.X_OB.y - q.y)
        for p, q in zip(driven(WALLS, true, BEAMS), _starting(true), strict=True)
    ]
    assert max(ends) > 1.0  # what odometry alone makes of it


def _starting(true: list[Pose2]) -> list[Pose2]:
    start = true[0].inverse()
    return [start @ pose for pose in true]


def test_the_same_log_gives_the_same_map() -> None:
    true = around(SIDE, 0.3, laps=0.25)
    first, second = (mapped(driven(WALLS, true, BEAMS)) for _ in range(2))
    np.testing.assert_array_equal(first.poses(), second.poses())


def test_what_is_not_seen_makes_the_pose_unsure_and_seeing_again_sure() -> None:
    slam = Slam()
    X_OB = Pose2()
    slam.add(0.0, seen(room(), BEAMS, Pose2(0, 1, 0)), BEAMS, X_OB)
    for k in range(1, 15):
        X_OB = Pose2(0.05 * k, 0, 0)
        blind = slam.add(0.1 * k, np.full(181, np.inf), BEAMS, X_OB)
    assert not blind.matched
    assert math.sqrt(blind.covariance[0, 0]) > 0.1
    assert math.isclose(blind.X_MB.x, X_OB.x)
    found = slam.add(2.0, seen(room(), BEAMS, Pose2(0.7, 1, 0)), BEAMS, Pose2(0.75, 0, 0))
    assert found.matched
    assert math.sqrt(found.covariance[0, 0]) < 0.02
    assert math.dist((found.X_MB.x, found.X_MB.y), (0.7, 0.0)) < 0.02


def test_a_kept_map_is_followed_and_stays_as_it_is(lap: tuple[MappedLog, list[Pose2]]) -> None:
    log, true = lap
    state = log.slam.state()
    slam = Slam(state=state, frozen=True, X_MB=Pose2(0.4, -0.3, 0.1))
    there = _starting(true)
    for sweep in list(driven(WALLS, true, BEAMS, seed=5))[:60]:
        match = slam.add(sweep.stamp, sweep.ranges, BEAMS, sweep.X_OB)
        assert match.matched
        assert slam.pending() is None
    assert math.dist((match.X_MB.x, match.X_MB.y), (there[59].x, there[59].y)) < 0.1
    assert list(slam.keyframes) == [keyframe.id for keyframe in state.keyframes]
    assert slam.state().edges == state.edges


def test_what_was_mapped_in_one_direction_is_followed_in_the_other(lap: tuple[MappedLog, list[Pose2]]) -> None:
    """Beside many keyframes behind a wall, which are nearer than those that see what the robot sees."""
    log, true = lap
    state = log.slam.state()
    back = [Pose2(pose.x, pose.y, pose.theta + math.pi) for pose in true[::-1]]
    start = true[0].inverse()
    there = [start @ pose for pose in back]
    slam = Slam(state=_crowded(state), frozen=True, X_MB=there[0])
    X_OM = there[0].inverse()
    shares = []
    for number, (pose, X_MB) in enumerate(zip(back, there, strict=True)):
        match = slam.add(0.5 * number, seen(WALLS, BEAMS, pose), BEAMS, X_OM @ X_MB)
        shares.append(match.inliers)
    assert min(shares) > 0.45
    assert math.dist((match.X_MB.x, match.X_MB.y), (there[-1].x, there[-1].y)) < 0.2


def _crowded(state: SlamState) -> SlamState:
    """``state`` with keyframes of the next room about its own: all headings, and a wall that no other keyframe sees."""
    wall = np.array([[0.1 * k, 0.0, 0.0, 1.0] for k in range(5)], np.float32)
    keyframes, poses = list(state.keyframes), list(state.poses)
    number = max(keyframe.id for keyframe in keyframes) + 1
    for keyframe, pose in list(zip(keyframes, poses, strict=True))[::4]:
        for quarter in range(4):
            for _ in range(3):
                keyframes.append(replace(keyframe, id=number, points=wall))
                poses.append(Pose2(pose.x, pose.y, pose.theta + quarter * math.pi / 2))
                number += 1
    return replace(state, keyframes=tuple(keyframes), poses=tuple(poses))


def test_mapping_goes_on_where_it_was_left() -> None:
    true = around(SIDE, 0.25, laps=0.5)
    sweeps = list(driven(WALLS, true, BEAMS))
    half = len(sweeps) // 2
    first = mapped(sweeps[:half])
    slam = Slam(state=first.slam.state(), X_MB=_starting(true)[half])
    before = len(slam.keyframes)
    for sweep in sweeps[half:]:
        match = slam.add(sweep.stamp, sweep.ranges, BEAMS, sweep.X_OB)
        if job := slam.pending():
            slam.take(job.run())
    end = _starting(true)[-1]
    assert len(slam.keyframes) > before + 20
    assert match.matched
    assert math.dist((match.X_MB.x, match.X_MB.y), (end.x, end.y)) < 0.2
    joined = {edge.a < before <= edge.b for edge in slam.state().edges}
    assert True in joined


def test_a_job_runs_in_another_thread_while_scans_go_on() -> None:
    """Additions during the job follow the entries it knew."""
    true = around(SIDE, 0.25, laps=1.25)
    slam = Slam()
    running = None
    with ThreadPoolExecutor(1) as pool:
        for sweep in driven(WALLS, true, BEAMS):
            match = slam.add(sweep.stamp, sweep.ranges, BEAMS, sweep.X_OB)
            if running is not None and match.added and len(slam.keyframes) % 4 == 0:
                slam.take(running.result(30))
                running = None
            if running is None and (job := slam.pending()):
                assert slam.pending() is None
                running = pool.submit(job.run)
    assert slam.loops > 0
    last = _starting(true)[-1]
    assert math.dist((match.X_MB.x, match.X_MB.y), (last.x, last.y)) < 0.3


def test_a_place_passed_again_and_again_does_not_grow() -> None:
    settings = SlamSettings(keyframes_per_m2=2)
    true = [Pose2(0.05 + 0.2 * math.cos(a), 0.9 + 0.2 * math.sin(a), a + math.pi / 2) for a in np.arange(0, 75, 0.3)]
    log = mapped(driven(room(), true, half_circle(91), slip=0.0), settings)
    made = max(log.slam.keyframes) + 1
    assert made > 200
    assert len(log.slam.keyframes) < 150
    assert len(log.slam.state().edges) < 8 * len(log.slam.keyframes)
    assert off(log, true) < 0.05
    ids = set(log.slam.keyframes)
    assert all({edge.a, edge.b} <= ids for edge in log.slam.state().edges)


def _with_a_hole(true: list[Pose2], begin: int, end: int, wrong: Pose2) -> list[Sweep]:
    """A drive along ``true`` of which sweeps are missing; odometry is ``wrong`` over the hole."""
    sweeps = list(driven(WALLS, true, BEAMS))
    X_OO = sweeps[begin].X_OB @ wrong @ sweeps[begin].X_OB.inverse()
    return [*sweeps[:begin], *(replace(sweep, X_OB=X_OO @ sweep.X_OB) for sweep in sweeps[end:])]


def test_loops_mend_what_a_hole_in_the_log_tore() -> None:
    """What follows a scan that fits nowhere hangs on odometry alone, not on the map before, however well it fits."""
    true = around(SIDE, 0.25, laps=2.2)
    begin, end = 20, 60
    log = mapped(_with_a_hole(true, begin, end, Pose2(0.5, -0.9, 0.1)))
    kept = [*true[:begin], *true[end:]]
    assert log.unmatched() >= 1
    matched = [k for k, row in enumerate(log.rows) if row.matched]
    start = true[0].inverse()
    wanted = np.array([((p := start @ kept[k]).x, p.y) for k in matched])
    assert np.hypot(*(log.poses()[matched, :2] - wanted).T).max() < 0.3


def test_a_laser_that_was_covered_for_a_moment_leaves_nothing_in_the_map() -> None:
    true = around(SIDE, 0.1, laps=0.25)
    covered = [
        replace(sweep, ranges=np.full(181, 0.1)) if 50 <= k < 55 else sweep
        for k, sweep in enumerate(driven(WALLS, true, BEAMS))
    ]
    log = mapped(covered)
    assert log.unmatched() == 5
    assert not {keyframe.stamp for keyframe in log.slam.keyframes.values()} & {0.2 * k for k in range(50, 55)}
    assert off(log, true) < 0.15

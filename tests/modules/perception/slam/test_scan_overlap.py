"""Views laid over each other: where they are of one place they agree, where they are laid wrongly they contradict."""

from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.scan_overlap import compared
from app.modules.perception.slam.scans import prepared
from app.modules.perception.slam.types import Keyframe
from tests.modules.perception.slam.rooms import half_circle, room, seen

BEAMS = half_circle()
PLACES = [
    Pose2(0.0, 0.0, 0.0),
    Pose2(0.6, 0.3, 0.4),
    Pose2(-2.0, 1.0, 0.8),
    Pose2(-1.0, 1.0, 2.9),
    Pose2(1.0, 2.0, -1.0),
]


def keyframe(id: int, pose: Pose2) -> Keyframe:
    scan = prepared(seen(room(), BEAMS, pose), BEAMS, (0.0, 0.0, 0.0), 0.0, 25.0, 0.03)
    return Keyframe(id, float(id), scan.points, scan.ends, scan.hits, scan.origin, float(id))


def laid(poses: list[Pose2]) -> tuple[int, int]:
    keyframes = [keyframe(id, pose) for id, pose in enumerate(PLACES)]
    pairs = compared(keyframes, np.array([(p.x, p.y, p.theta) for p in poses]))
    assert (pairs.first < pairs.second).all()
    return int(pairs.agree.sum()), int(pairs.contradict.sum())


def test_views_of_one_room_agree() -> None:
    agree, contradict = laid(PLACES)
    assert agree >= 10
    assert contradict == 0


@pytest.mark.parametrize("moved", [Pose2(1.5, 0.0, 0.0), Pose2(0.0, 0.0, 0.6), Pose2(-0.8, 0.9, 1.57)])
def test_a_view_laid_wrongly_contradicts_the_others(moved: Pose2) -> None:
    wrong = [*PLACES[:-1], PLACES[-1] @ moved]
    right, _ = laid(PLACES)
    agree, contradict = laid(wrong)
    assert agree < right
    assert contradict >= 2


def test_what_is_far_apart_is_not_compared() -> None:
    apart = [Pose2(20.0 * k, 0.0, 0.0) for k in range(len(PLACES))]
    assert laid(apart) == (0, 0)


def test_nothing_is_said_of_no_views_and_of_blind_ones() -> None:
    assert not len(compared([], np.zeros((0, 3))).first)
    blind = Keyframe(0, 0.0, np.zeros((0, 4), np.float32), np.zeros((0, 2), np.float32), np.zeros(0, np.bool_),
                     np.zeros(2, np.float32), 0.0)  # fmt: skip
    pairs = compared([blind, keyframe(1, PLACES[0])], np.zeros((2, 3)))
    assert not pairs.agree.any()
    assert not pairs.contradict.any()

"""Whether a map is whole, said without truth: whole ones are, broken ones never."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.offline_mapping import MappedLog, Sweep, mapped
from app.modules.perception.slam.scan_overlap import Pairs
from app.modules.perception.slam.self_check import CheckSettings, checked, cuts_of
from tests.modules.perception.slam.rooms import around, driven, half_circle, ring

BEAMS = half_circle(181)
WALLS = ring(5.5, 2.5)
WAY = around(8.0, 0.2, laps=2.0)
#: The second lap begins here.
LAP = len(WAY) // 2


@pytest.fixture(scope="module")
def sweeps() -> list[Sweep]:
    """Two laps around a block."""
    return list(driven(WALLS, WAY, BEAMS))


def jumping(sweeps: list[Sweep], at: int, by: Pose2) -> list[Sweep]:
    """Odometry says ``by`` more at one sweep."""
    X_OO = sweeps[at].X_OB @ by @ sweeps[at].X_OB.inverse()
    return [*sweeps[:at], *(replace(sweep, X_OB=X_OO @ sweep.X_OB) for sweep in sweeps[at:])]


def without(sweeps: list[Sweep], begin: int, end: int, *, known: bool) -> list[Sweep]:
    """Sweeps are missing; odometry went on meanwhile, if ``known``, or the robot was carried."""
    if known:
        return [*sweeps[:begin], *sweeps[end:]]
    X_OO = sweeps[begin - 1].X_OB @ sweeps[end].X_OB.inverse()
    return [*sweeps[:begin], *(replace(sweep, X_OB=X_OO @ sweep.X_OB) for sweep in sweeps[end:])]


def farthest_off(log: MappedLog, way: list[Pose2]) -> float:
    """How far (m) a keyframe's first scan is from where it truly was, seen from the first."""
    first = way[0].inverse()
    own = {row.keyframe: k for k, row in reversed(list(enumerate(log.rows)))}
    poses = log.poses()
    off = [
        math.hypot(
            *(poses[k, :2] - np.array(((first @ way[log.rows[k].number]).x, (first @ way[log.rows[k].number]).y)))
        )
        for k in own.values()
    ]
    return max(off)


def test_a_whole_map_is_intact(sweeps: list[Sweep]) -> None:
    log = mapped(sweeps)
    assert farthest_off(log, WAY) < 0.3
    check = checked(log)
    assert (check.intact, check.inconsistencies) == ("yes", ())
    assert set(check.sigmas_m) == set(log.slam.keyframes)
    assert max(check.sigmas_m.values()) < 0.5


def test_a_robot_that_was_carried_leaves_no_intact_map_unless_it_is_whole(sweeps: list[Sweep]) -> None:
    kept = [*range(30), *range(70, len(WAY))]
    log = mapped(without(sweeps, 30, 70, known=False))
    check = checked(log)
    assert farthest_off(log, [WAY[k] for k in kept]) > 0.5
    assert check.intact != "yes"
    assert check.inconsistencies


def test_a_hole_that_nothing_bridges_is_not_known(sweeps: list[Sweep]) -> None:
    side = LAP // 4
    log = mapped(without(sweeps[: 3 * side], side // 2, 2 * side, known=True))
    check = checked(log)
    assert check.intact == "unknown"
    assert any(
        "odometry alone holds what was seen before and after together" in doubt for doubt in check.inconsistencies
    )
    assert any(f"at scan {side // 2} " in doubt for doubt in check.inconsistencies)
    # What is not known of the way over the hole is in how surely keyframes are known.
    assert max(check.sigmas_m.values()) > 1.0


def test_a_wheel_that_slipped_far_is_doubted_until_a_later_visit_confirms_it(sweeps: list[Sweep]) -> None:
    slipped = jumping(sweeps, LAP // 2, Pose2(0.0, 0.0, 0.7))
    early, whole = mapped(slipped[: 3 * LAP // 4]), mapped(slipped)
    assert farthest_off(whole, WAY) < 0.3
    assert checked(whole).intact == "yes"
    (doubt,) = checked(early).inconsistencies
    assert "no later visit confirms it" in doubt


def test_scans_that_do_not_fit_are_said(sweeps: list[Sweep]) -> None:
    rng = np.random.default_rng(0)
    covered = [
        replace(sweep, ranges=rng.uniform(0.06, 0.3, 181)) if 60 <= k < 65 else sweep for k, sweep in enumerate(sweeps)
    ]
    log = mapped(covered)
    assert log.unmatched() >= 4
    check = checked(log, CheckSettings(unmatched_share=0.5 * log.unmatched() / len(log.rows)))
    assert check.intact == "unknown"
    share = 100 * log.unmatched() / len(log.rows)
    assert f"{log.unmatched()} scans ({share:.1f} %) did not fit the map" in check.inconsistencies


def test_a_cut_counts_the_pairs_that_reach_over_it() -> None:
    first, second = np.array([0, 1, 0, 2]), np.array([1, 3, 99, 3])
    pairs = Pairs(first, second, np.array([True, True, True, False]), np.array([False, False, False, True]))
    cuts = cuts_of(pairs, 100)
    assert cuts.agreeing[:5].tolist() == [0, 2, 2, 2, 1]
    assert cuts.contradicting[:5].tolist() == [0, 0, 0, 1, 0]
    assert (cuts.confirming[1:] == 1).all()
    assert all(int(b) - int(a) <= 1 for a, b in pairwise(cuts.contradicting))

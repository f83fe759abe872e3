"""Whether calibrated positions should be adopted, in words."""

from __future__ import annotations

import math

import numpy as np

from app.modules.perception.voices.array_calibration.refinement import Fit, Geometry
from app.modules.perception.voices.array_calibration.results import Verdict
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND

#: Claps that a calibration should have, and the least with which there is one.
ENOUGH, LEAST = 12, 8
#: A clap is used if its arrivals are believed by so much on average.
BELIEVED = 0.3
#: A held-out error smaller by this factor, and a difference (m) that is one at all, are an improvement.
_BETTER, _NO_CHANGE_M = 0.8, 0.0002
#: Greatest contradiction (m), and greatest standard deviation of a position (m, and share of the array's size).
_CONTRADICTING_M, _UNSURE_M, _UNSURE = 0.004, 0.003, 0.03
#: Greatest RMS difference between the visible parts of claps around a plane array.
_UNEVEN = 0.025
#: Least visible part of claps at a plane array's height: within 20° of it.
_VISIBLE = 0.93


def judge(
    fit: Fit, configured: Geometry, before_m: float, after_m: float, *, reordered: bool
) -> tuple[Verdict, tuple[str, ...]]:
    """The verdict on ``fit``, and why, each reason a sentence without its full stop.

    ``before_m`` and ``after_m``: errors (m) of arrival times that the fit had not seen, by the ``configured`` positions
    and by those found. ``reordered``: whether channels are in another order than configured.
    """
    before, after = (f"{1e6 * error / SPEED_OF_SOUND:.1f} µs" for error in (before_m, after_m))
    if doubts := _doubts(fit, configured, after_m):
        return Verdict.REPEAT, tuple(doubts)
    if after_m < _BETTER * before_m and before_m - after_m > _NO_CHANGE_M:
        explained = f"the positions found explain claps that they were not fitted to within {after}, the configured"
        reasons = [f"{explained} ones within {before}"]
        return Verdict.ADOPT, (*(["the channels are in another order than configured"] if reordered else []), *reasons)
    return Verdict.KEEP, (f"the configured positions explain the claps as well as those found ({before} and {after})",)


def _doubts(fit: Fit, configured: Geometry, after_m: float) -> list[str]:
    doubts = []
    used = int((fit.weights.mean(axis=1) > BELIEVED).sum())
    if used < LEAST:
        doubts.append(
            f"only {used} claps fit together; at least {LEAST} are needed: clap louder and nearer, in a quiet room"
        )
    if after_m > _CONTRADICTING_M:
        doubts.append(
            f"no positions explain the arrival times: they are off by {1e6 * after_m / SPEED_OF_SOUND:.0f} µs. Noise, "
            "walls or a table beside the array, or an array that moved, do that; so does a wrong body_m"
        )
    size = 2 * float(np.linalg.norm(configured.positions, axis=1).max())
    worst = float(fit.deviations.max())
    if fit.undetermined:
        doubts.append(
            f"{fit.undetermined} of the numbers that make the array's shape are not shown by these claps: clap from "
            "more directions, some high and some low"
        )
    elif worst > max(_UNSURE_M, _UNSURE * size):
        doubts.append(f"positions are uncertain by up to {1e3 * worst:.1f} mm: clap more often, from more directions")
    if fit.unevenness > _UNEVEN:
        doubts.append(
            "the claps came from different heights: around a flat array, clap at one height, that of the array"
        )
    # Lower claps and a smaller array make the same differences.
    visible = fit.visible * float(np.linalg.norm(fit.positions) / np.linalg.norm(configured.positions))
    if fit.visible < _VISIBLE:
        above_deg = math.degrees(math.acos(min(1.0, visible)))
        doubts.append(
            f"the claps came from {above_deg:.0f}° above or below the flat array, or its configured size is too large: "
            f"clap at its height; if you did, its microphones are {visible:.2f} times as far apart as configured"
        )
    return doubts


def unseen_of(dimensions: int) -> tuple[str, ...]:
    """What sound from unknown directions cannot show of an array that extends in so many ``dimensions``; each completes
    "Sound does not show ..."."""
    always = (
        "how the array as a whole is turned, whether it is mirrored, and where it is on the robot: these are as "
        "configured; compare the directions of the claps with where you clapped"
    )
    plane = (
        "places across the plane, nor that the configured size is too large: differences within the plane were "
        "measured, taking the claps to be at about one height"
    )
    line = "places beside the line, nor its size: the ratios of distances along it were measured"
    return {1: (always, line), 2: (always, plane)}.get(dimensions, (always,))

"""1.7 km of long bare corridors, as in MIT's Killian Court: a synthetic log of which the truth is known.

Three streets by four around solid blocks, niches of 8 to 30 cm for doors every few metres, some stretches bare; 180
rays of 1° with ±5 cm of noise, rounded to cm; odometry wrong in its scale, in its turns, and swerving slowly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.slam.relations import Poses

Walls = NDArray[np.float64]
STREETS_X, STREETS_Y, WIDTH_M = (0, 52, 118, 190), (0, 46, 95), 2.6
#: Crossings passed, by column and row.
ROUTE = (
    (0, 0), (3, 0), (3, 2), (0, 2), (0, 0), (1, 0), (1, 2), (2, 2), (2, 0), (3, 0), (3, 1), (0, 1), (0, 2), (3, 2),
    (3, 1), (2, 1), (2, 0), (0, 0),
)  # fmt: skip
ANGLES: NDArray[np.float64] = np.radians(-90.0 + np.arange(180))
STEP_M, TURN_RAD = 0.11, 0.06
RANGE_M, NOTHING_M, NOISE_M = 30.0, 81.83, 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """``ranges`` (N, 180) float32 m of ``ANGLES``; of each scan (N, 3) the ``odometry`` and the ``truth``: m, rad."""

    ranges: NDArray[np.float32]
    odometry: Poses
    truth: Poses


def drive(seed: int, scale: float, turn: float) -> Drive:
    """One drive along all of ``ROUTE``, with odometry that measures ``scale`` m for each metre and ``turn`` rad for
    each radian."""
    truth = _route()
    return Drive(_scans(_walls(seed), truth, seed), _odometry(truth, seed, scale, turn), truth)


def _box(left: float, low: float, right: float, high: float) -> list[tuple[float, float, float, float]]:
    return [(left, low, right, low), (right, low, right, high), (right, high, left, high), (left, high, left, low)]


def _walls(seed: int) -> Walls:
    """x0, y0, x1, y1 (m) of each wall, (W, 4)."""
    rng = np.random.default_rng(seed)
    half = WIDTH_M / 2
    walls: list[tuple[float, float, float, float]] = []
    for left, right in pairwise(STREETS_X):
        for low, high in pairwise(STREETS_Y):
            for wall in _box(left + half, low + half, right - half, high - half):
                walls += _with_niches(wall, rng)
    return np.array(walls + _box(STREETS_X[0] - half, STREETS_Y[0] - half, STREETS_X[-1] + half, STREETS_Y[-1] + half))


def _with_niches(
    wall: tuple[float, float, float, float], rng: np.random.Generator
) -> list[tuple[float, float, float, float]]:
    x0, y0, x1, y1 = wall
    length = math.hypot(x1 - x0, y1 - y0)
    ux, uy = (x1 - x0) / length, (y1 - y0) / length

    def at(along: float, deep: float = 0.0) -> tuple[float, float]:
        return x0 + ux * along - uy * deep, y0 + uy * along + ux * deep

    made: list[tuple[float, float, float, float]] = []
    done = 0.0
    while done < length - 12:
        begin = done + rng.uniform(4, 9)
        deep, wide = rng.uniform(0.08, 0.3), rng.uniform(0.9, 2.0)
        if rng.random() < 0.25:
            begin += 8
        begin = min(begin, length - 4)
        corners = at(done), at(begin), at(begin, deep), at(begin + wide, deep), at(begin + wide)
        made += [(*a, *b) for a, b in pairwise(corners)]
        done = begin + wide
    return [*made, (*at(done), x1, y1)]


def _route() -> Poses:
    poses: list[tuple[float, float, float]] = []
    heading = 0.0
    corners = [(STREETS_X[column], STREETS_Y[row]) for column, row in ROUTE]
    for (x0, y0), (x1, y1) in pairwise(corners):
        length, towards = math.hypot(x1 - x0, y1 - y0), math.atan2(y1 - y0, x1 - x0)
        turn = math.remainder(towards - heading, math.tau)
        turns = max(1, int(abs(turn) / TURN_RAD))
        if abs(turn) > 1e-3:
            poses += [(x0, y0, heading + turn * k / turns) for k in range(1, turns + 1)]
        heading = towards
        c, s = math.cos(heading), math.sin(heading)
        steps = int(length / STEP_M)
        for k in range(1, steps + 1):
            along = length * k / steps
            aside = 0.25 * math.sin(along / 9) * min(1, along / 3, (length - along) / 3)
            look = heading + 0.02 * math.sin(along / 5)
            poses.append((x0 + c * along - s * aside, y0 + s * along + c * aside, look))
    return np.array(poses)


def _scans(walls: Walls, poses: Poses, seed: int) -> NDArray[np.float32]:
    rng = np.random.default_rng(seed + 100)
    begin, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    middle, half = begin + along / 2, np.hypot(*along.T) / 2
    ranges = np.empty((len(poses), len(ANGLES)), np.float32)
    for k, (x, y, theta) in enumerate(poses):
        near = np.hypot(middle[:, 0] - x, middle[:, 1] - y) - half < RANGE_M + 2
        (dx, dy), (ax, ay) = along[near].T, (begin[near] - (x, y)).T
        c, s = np.cos(ANGLES + theta)[:, None], np.sin(ANGLES + theta)[:, None]
        across = c * dy - s * dx
        across = np.where(np.abs(across) < 1e-12, 1e-12, across)
        far, share = (ax * dy - ay * dx) / across, (ax * s - ay * c) / across
        hit = np.where((far > 1e-6) & (share >= 0) & (share <= 1), far, np.inf).min(axis=1)
        noisy = hit + rng.uniform(-NOISE_M, NOISE_M, len(ANGLES))
        ranges[k] = np.round(np.maximum(np.where(noisy < RANGE_M, noisy, NOTHING_M), 0.06), 2)
    return ranges


def _odometry(truth: Poses, seed: int, scale: float, turn: float) -> Poses:
    rng = np.random.default_rng(seed + 200)
    poses = [(0.0, 0.0, 0.0)]
    swerve = 0.0
    for before, after in pairwise(truth):
        x, y, theta = poses[-1]
        c, s = math.cos(before[2]), math.sin(before[2])
        dx, dy = after[0] - before[0], after[1] - before[1]
        ahead, aside = c * dx + s * dy, -s * dx + c * dy
        distance = math.hypot(ahead, aside)
        swerve = 0.995 * swerve + rng.normal(0, 0.0004)
        ahead *= scale + rng.normal(0, 0.03)
        aside *= scale
        turned = math.remainder(after[2] - before[2], math.tau) * (turn + rng.normal(0, 0.03))
        turned += (swerve + rng.normal(0, 0.006)) * distance
        c, s = math.cos(theta), math.sin(theta)
        poses.append((x + c * ahead - s * aside, y + s * ahead + c * aside, math.remainder(theta + turned, math.tau)))
    return np.array(poses)

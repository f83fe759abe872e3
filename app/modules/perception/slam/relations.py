"""Quality of a trajectory: errors of relative poses (Kuemmerle et al., 2009), and distance to a reference.

Poses are arrays (N, 3) float64: x, y (m), theta (rad).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Poses = NDArray[np.float64]
#: Error of a relation (m, rad) that indicates a broken map.
GROSS_M = 0.5
GROSS_RAD = np.radians(5.0)


@dataclass(frozen=True, slots=True)
class RelationErrors:
    """Errors of relative poses: translation in m, rotation in degrees, and number of gross errors."""

    relations: int
    mean_m: float
    sd_m: float
    max_m: float
    mean_deg: float
    sd_deg: float
    max_deg: float
    gross: int


def wrapped(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles (rad) in [-pi, pi)."""
    return (angles + np.pi) % (2.0 * np.pi) - np.pi


def composed(first: Poses, second: Poses) -> Poses:
    """``X_AC`` of ``X_AB`` and ``X_BC``, pose by pose."""
    c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
    x = first[:, 0] + c * second[:, 0] - s * second[:, 1]
    y = first[:, 1] + s * second[:, 0] + c * second[:, 1]
    return np.stack((x, y, wrapped(first[:, 2] + second[:, 2])), axis=1)


def between(first: Poses, second: Poses) -> Poses:
    """``X_AB`` of ``X_MA`` and ``X_MB``, pose by pose."""
    c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
    x, y = second[:, 0] - first[:, 0], second[:, 1] - first[:, 1]
    return np.stack((c * x + s * y, c * y - s * x, wrapped(second[:, 2] - first[:, 2])), axis=1)


def relation_errors(first: Poses, second: Poses, measured: Poses) -> RelationErrors:
    """Errors between the poses ``first`` and ``second`` of each relation (at least one), against ``measured``."""
    off = between(measured, between(first, second))
    metres = np.hypot(off[:, 0], off[:, 1])
    turned = np.abs(off[:, 2])
    degrees = np.degrees(turned)
    return RelationErrors(
        relations=len(off),
        mean_m=float(metres.mean()),
        sd_m=float(metres.std()),
        max_m=float(metres.max()),
        mean_deg=float(degrees.mean()),
        sd_deg=float(degrees.std()),
        max_deg=float(degrees.max()),
        gross=int(((metres > GROSS_M) | (turned > GROSS_RAD)).sum()),
    )


def trajectory_error(poses: Poses, reference: Poses) -> tuple[float, float, float]:
    """Mean, root mean square and greatest distance (m) to ``reference`` after rigid alignment (Horn, 1987)."""
    ours, theirs = poses[:, :2] - poses[:, :2].mean(axis=0), reference[:, :2] - reference[:, :2].mean(axis=0)
    cross = (ours[:, 0] * theirs[:, 1] - ours[:, 1] * theirs[:, 0]).sum()
    turn = np.arctan2(cross, (ours * theirs).sum())
    c, s = np.cos(turn), np.sin(turn)
    off = ours @ np.array([[c, s], [-s, c]]) - theirs
    away = np.hypot(off[:, 0], off[:, 1])
    return float(away.mean()), float(np.sqrt((away**2).mean())), float(away.max())


def filled_in(rows: NDArray[np.int64], poses: Poses, odometry: Poses) -> Poses:
    """A pose for every row of ``odometry`` (K, 3), given ``poses`` at some ``rows`` (ascending): odometry forward from
    the row before and backward from the row after, blended linearly."""
    all_rows = np.arange(len(odometry))
    before = np.clip(np.searchsorted(rows, all_rows, side="right") - 1, 0, None)
    after = np.clip(np.searchsorted(rows, all_rows, side="left"), None, len(rows) - 1)
    ahead = composed(poses[before], between(odometry[rows[before]], odometry))
    back = composed(poses[after], between(odometry[rows[after]], odometry))
    # 0 at the row before, 1 at the row after; only one of them before the first and after the last.
    share = np.clip((all_rows - rows[before]) / np.maximum(rows[after] - rows[before], 1), 0.0, 1.0)
    filled = ahead.copy()
    filled[:, :2] += share[:, None] * (back[:, :2] - ahead[:, :2])
    filled[:, 2] = wrapped(ahead[:, 2] + share * wrapped(back[:, 2] - ahead[:, 2]))
    return filled

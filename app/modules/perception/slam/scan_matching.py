"""Scan matching on a surfel grid: point-to-line least squares around a guess (after Censi, 2008)."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel
from app.base.geometry import Pose2
from app.modules.perception.slam.information import Information, along, packed
from app.modules.perception.slam.surfels import CELL_M, MARGIN, SurfelGrid

#: Standard deviation (m) of a reading's distance from the surface.
NOISE_M = 0.03
#: Number of readings from which more give no more information: they are not independent.
_INDEPENDENT = 60.0
#: Distances (m) at which a reading's weight is halved: to a line, to a point.
_SOFT_LINE_M = 0.04
_SOFT_POINT_M = 0.06
#: Weight of a point without a surface normal ...
_POINT_WEIGHT = 0.2
#: ... and range (m) from which only its bearing counts.
_POINT_REACH_M = 5.0
_LEAST_INLIERS = 15
#: Least covariance of a match (m^2, m^2, rad^2): surfels approximate the walls.
_MODEL_VARIANCES = (0.005**2, 0.005**2, 0.0015**2)
#: Step (m, rad) at which the iteration ends.
_SMALL_M = 2e-4
_SMALL_RAD = 2e-5
#: Greatest distance (m) of a reading from its surfel: at first, at last.
FAR_M = 0.3
NEAR_M = 0.12


@dataclass(frozen=True, slots=True, eq=False)
class ScanFit:
    """Fit of a scan on a grid: ``X_SB`` in the grid's frame; shares of its points as in :class:`types.Match`.

    ``rms_m``: of the inliers' distances from their surfaces. ``information`` (3, 3) float64 by the readings alone, of
    x, y (1/m^2) and theta (1/rad^2) of X_SB along the grid's axes.
    """

    X_SB: Pose2
    inliers: float
    overlap: float
    rms_m: float
    information: NDArray[np.float64]

    def edge_information(self, prior_sigmas: tuple[float, float]) -> Information:
        """Information of a graph edge by this fit, whose prior was odometry of ``prior_sigmas`` (m, rad).

        It is less along a corridor than across it, so that a correction of the graph moves keyframes along it.
        """
        sigma_m, sigma_rad = prior_sigmas
        held = self.information + np.diag([1.0 / sigma_m**2, 1.0 / sigma_m**2, 1.0 / sigma_rad**2])
        covariance = np.linalg.inv(along(held, self.X_SB.theta)) + np.diag(_MODEL_VARIANCES)
        return packed(self.inliers * np.linalg.inv(covariance))


def fitted(
    grid: SurfelGrid,
    points: NDArray[np.float32],
    guess: Pose2,
    prior: Pose2,
    sigmas: tuple[float, float],
    *,
    iterations: int = 14,
    near_m: float = NEAR_M,
) -> ScanFit:
    """The best pose near ``guess`` of ``points`` (N, 4) on ``grid``, with a prior of ``sigmas`` (m, rad)."""
    found = _fit(
        grid.surfels,
        grid.corner[0],
        grid.corner[1],
        points,
        guess.x,
        guess.y,
        guess.theta,
        prior.x,
        prior.y,
        prior.theta,
        1.0 / sigmas[0] ** 2,
        1.0 / sigmas[1] ** 2,
        iterations,
        FAR_M,
        near_m,
    )
    x, y, theta, inliers, overlap, rms = (float(v) for v in found[:6])
    a, b, c, d, e, f = found[6:]
    information = np.array([[a, b, c], [b, d, e], [c, e, f]])
    if not (a > 0.0 and a * d - b * b > 0.0 and np.linalg.det(information) > 0.0):
        information = _nowhere_less_than_none(information)
    return ScanFit(Pose2(x, y, math.remainder(theta, math.tau)), inliers, overlap, rms, information)


def _nowhere_less_than_none(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest positive semidefinite matrix: noise can make information negative."""
    known, axes = np.linalg.eigh(information)
    found: NDArray[np.float64] = (axes * np.maximum(known, 0.0)) @ axes.T
    return found


@kernel(
    "float64[::1](float32[:, :, ::1], int64, int64, float32[:, ::1], float64, float64, float64, float64, float64,"
    " float64, float64, float64, int64, float64, float64)",
    fastmath=True,
)
def _fit(
    surfels,
    corner_i,
    corner_j,
    points,
    x,
    y,
    theta,
    prior_x,
    prior_y,
    prior_theta,
    weight_m,
    weight_rad,
    iterations,
    far,
    near,
) -> NDArray[np.float64]:
    """Gauss-Newton; x, y, theta, inliers, overlap, rms, then the upper triangle of the information, row by row.

    The information (``i00`` …) uses products of the surfel's normal and the reading's own, whose errors are
    independent: squares of one normal would turn its noise into information along a bare wall.
    """
    rows, columns = surfels.shape[:2]
    h00 = h01 = h02 = h11 = h12 = h22 = 0.0
    i00 = i01 = i02 = i11 = i12 = i22 = 0.0
    inliers = 0
    overlapping = 0
    squares = 0.0
    count = len(points)
    scale = 0.0
    for iteration in range(iterations):
        progress = iteration / (iterations - 1.0)
        reach = far * (1.0 - progress) + near * progress
        around = 1 if reach < 0.16 else (2 if reach < 0.26 else 3)
        c = math.cos(theta)
        s = math.sin(theta)
        h00 = h01 = h02 = h11 = h12 = h22 = 0.0
        i00 = i01 = i02 = i11 = i12 = i22 = 0.0
        g0 = g1 = g2 = 0.0
        inliers = 0
        overlapping = 0
        squares = 0.0
        for k in range(count):
            # The point, its derivative by theta and its normal, in the grid's frame.
            arm_y = c * points[k, 0] - s * points[k, 1]
            arm_x = -s * points[k, 0] - c * points[k, 1]
            px = arm_y + x
            py = y - arm_x
            i = math.floor(px / CELL_M) - corner_i
            j = math.floor(py / CELL_M) - corner_j
            if i < MARGIN or j < MARGIN or i >= rows - MARGIN or j >= columns - MARGIN:
                continue
            nx = c * points[k, 2] - s * points[k, 3]
            ny = s * points[k, 2] + c * points[k, 3]
            has_normal = nx != 0.0 or ny != 0.0
            best = reach * reach
            best_i = -1
            best_j = -1
            anything = False
            for a in range(i - around, i + around + 1):
                for b in range(j - around, j + around + 1):
                    dx = surfels[a, b, 0] - px
                    if dx > 1e3:
                        continue
                    anything = True
                    dy = surfels[a, b, 1] - py
                    d = dx * dx + dy * dy
                    # The other side of a wall is another surface.
                    if d < best and (not has_normal or nx * surfels[a, b, 2] + ny * surfels[a, b, 3] >= 0.3):
                        best = d
                        best_i = a
                        best_j = b
            if anything:
                overlapping += 1
            if best_i < 0:
                continue
            inliers += 1
            ex = px - surfels[best_i, best_j, 0]
            ey = py - surfels[best_i, best_j, 1]
            ux = surfels[best_i, best_j, 2]
            uy = surfels[best_i, best_j, 3]
            d = ex * ex + ey * ey
            is_line = ux != 0.0 or uy != 0.0
            if not is_line and points[k, 0] ** 2 + points[k, 1] ** 2 < _POINT_REACH_M**2:
                w = _POINT_WEIGHT / (1.0 + d / _SOFT_POINT_M**2)
                h00 += w
                h11 += w
                h02 += w * arm_x
                h12 += w * arm_y
                h22 += w * (arm_x * arm_x + arm_y * arm_y)
                i00 += w
                i11 += w
                i02 += w * arm_x
                i12 += w * arm_y
                i22 += w * (arm_x * arm_x + arm_y * arm_y)
                g0 += w * ex
                g1 += w * ey
                g2 += w * (arm_x * ex + arm_y * ey)
                squares += 0.25 * d
                continue
            if not is_line:
                # Distant readings of a wall at a grazing angle are far apart and move along it with the robot: their
                # position along the ray carries no information, only their bearing does.
                arm = math.sqrt(arm_x * arm_x + arm_y * arm_y)
                ux, uy = arm_x / arm, arm_y / arm
            if not (is_line and has_normal):
                nx, ny = ux, uy
            e = ux * ex + uy * ey
            w = 1.0 / (1.0 + (e / _SOFT_LINE_M) ** 2) if is_line else _POINT_WEIGHT / (1.0 + (e / _SOFT_POINT_M) ** 2)
            turn = ux * arm_x + uy * arm_y
            turned = nx * arm_x + ny * arm_y
            h00 += w * ux * ux
            h01 += w * ux * uy
            h02 += w * ux * turn
            h11 += w * uy * uy
            h12 += w * uy * turn
            h22 += w * turn * turn
            g0 += w * ux * e
            g1 += w * uy * e
            g2 += w * turn * e
            i00 += w * ux * nx
            i01 += w * 0.5 * (ux * ny + uy * nx)
            i02 += w * 0.5 * (ux * turned + nx * turn)
            i11 += w * uy * ny
            i12 += w * 0.5 * (uy * turned + ny * turn)
            i22 += w * turn * turned
            squares += e * e if is_line else 0.25 * e * e
        if inliers < _LEAST_INLIERS:
            scale = 0.0
            break
        scale = min(1.0, _INDEPENDENT / inliers) / NOISE_M**2
        a00 = h00 * scale + weight_m
        a01 = h01 * scale
        a02 = h02 * scale
        a11 = h11 * scale + weight_m
        a12 = h12 * scale
        a22 = h22 * scale + weight_rad
        g0 = g0 * scale + weight_m * (x - prior_x)
        g1 = g1 * scale + weight_m * (y - prior_y)
        away = (theta - prior_theta + math.pi) % (2.0 * math.pi) - math.pi
        g2 = g2 * scale + weight_rad * away
        # Solved by the adjugate matrix.
        c00 = a11 * a22 - a12 * a12
        c01 = a02 * a12 - a01 * a22
        c02 = a01 * a12 - a02 * a11
        det = a00 * c00 + a01 * c01 + a02 * c02
        if det < 1e-9:
            break
        c11 = a00 * a22 - a02 * a02
        c12 = a02 * a01 - a00 * a12
        c22 = a00 * a11 - a01 * a01
        step_x = (c00 * g0 + c01 * g1 + c02 * g2) / det
        step_y = (c01 * g0 + c11 * g1 + c12 * g2) / det
        step_theta = (c02 * g0 + c12 * g1 + c22 * g2) / det
        x -= step_x
        y -= step_y
        theta -= step_theta
        small = abs(step_x) + abs(step_y) < _SMALL_M and abs(step_theta) < _SMALL_RAD
        if iteration > 3 and small and reach <= near * 1.3:
            break
    count = max(count, 1)
    shares = np.array([x, y, theta, inliers / count, overlapping / count, math.sqrt(squares / max(inliers, 1))])
    return np.concatenate((shares, scale * np.array([i00, i01, i02, i11, i12, i22])))

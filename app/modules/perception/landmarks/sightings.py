"""Sightings of one landmark, anchored to keyframes, and their fusion: pure functions on arrays.

A sighting is kept in the frame of the keyframe K that the robot was attached to. Where the landmark is on the map
follows from where the keyframes are now: with rows i,

    p_MQ = (sum L_i)^-1 sum L_i X_MK_i p_KQ_i        L_i = (R_i (I_i^-1 + s^2 1) R_i^T)^-1

with the information I of a row, the rotation R of its keyframe, and s, the error that all sightings of a keyframe
share. Sightings of one keyframe are joined in information form, and headings as vectors as long as their information:
both sums are the same in any order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Sightings of one landmark, one row for each keyframe.

    ``anchors`` (N,) int64: ids of keyframes, each once. ``p_KQ`` (N, 3) m: the code's centre in the keyframe's frame.
    ``information`` (N, 3, 3): inverse covariance (m^-2) along the keyframe's axes. ``headings`` (N, 2): the sum over
    the row's sightings of the horizontal unit vector of the code's outward normal, each weighted by the inverse
    variance (rad^-2) of its heading; 0, 0 while none is known.
    """

    anchors: NDArray[np.int64]
    p_KQ: FloatArray
    information: FloatArray
    headings: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Fused:
    """Where a landmark is: ``p`` (3,) m with ``covariance`` (3, 3) m^2; ``heading`` (rad) and its ``heading_sigma``
    (rad) are None while unknown. All in the frame of the keyframes' poses."""

    p: FloatArray
    covariance: FloatArray
    heading: float | None
    heading_sigma: float | None


def sighting(
    anchor: int,
    p_KQ: FloatArray,
    covariance: FloatArray,
    heading: float | None = None,
    heading_sigma: float | None = None,
) -> Sightings:
    """One sighting at ``p_KQ`` (3,) m with ``covariance`` (3, 3) m^2 in the frame of ``anchor``; ``heading`` (rad) of
    the code's normal with ``heading_sigma`` (rad, > 0), if both are known."""
    vector = np.zeros(2)
    if heading is not None and heading_sigma is not None:
        vector = np.array([math.cos(heading), math.sin(heading)]) / heading_sigma**2
    information = np.linalg.inv(covariance)
    return Sightings(np.array([anchor]), p_KQ[None], 0.5 * (information + information.T)[None], vector[None])


def joined(one: Sightings, other: Sightings) -> Sightings:
    """The sightings of both, those of one keyframe in one row, by ascending id."""
    return _by_anchor(
        np.concatenate((one.anchors, other.anchors)),
        np.concatenate((one.p_KQ, other.p_KQ)),
        np.concatenate((one.information, other.information)),
        np.concatenate((one.headings, other.headings)),
    )


def moved(sightings: Sightings, rows: NDArray[np.bool_], anchors: NDArray[np.int64], X_AK: FloatArray) -> Sightings:
    """``sightings`` with the ``rows`` (N,) anchored to other keyframes: row n of them to ``anchors[n]``, in whose frame
    the former keyframe is at ``X_AK[n]`` (x, y, theta)."""
    R = rotations(X_AK[:, 2])
    p, information, headings = sightings.p_KQ.copy(), sightings.information.copy(), sightings.headings.copy()
    ids = sightings.anchors.copy()
    p[rows] = np.einsum("nij,nj->ni", R, p[rows])
    p[rows, :2] += X_AK[:, :2]
    information[rows] = R @ information[rows] @ R.transpose(0, 2, 1)
    headings[rows] = np.einsum("nij,nj->ni", R[:, :2, :2], headings[rows])
    ids[rows] = anchors
    return _by_anchor(ids, p, information, headings)


def fused(sightings: Sightings, X_MK: FloatArray, shared_m: float, shared_rad: float) -> Fused:
    """Where the landmark is, with the keyframes of its rows at ``X_MK`` (N, 3) x, y, theta.

    ``shared_m`` and ``shared_rad`` (> 0): standard deviations of the error that all sightings of a keyframe share, and
    the least of the result. Where rows contradict each other, the covariance grows with their chi-square per degree of
    freedom.
    """
    R = rotations(X_MK[:, 2])
    at = np.einsum("nij,nj->ni", R, sightings.p_KQ)
    at[:, :2] += X_MK[:, :2]
    own = np.linalg.inv(sightings.information) + shared_m**2 * np.eye(3)
    information = R @ np.linalg.inv(own) @ R.transpose(0, 2, 1)
    covariance = np.linalg.inv(information.sum(axis=0))
    p = covariance @ np.einsum("nij,nj->i", information, at)
    off = at - p
    chi2 = float(np.einsum("ni,nij,nj->", off, information, off))
    covariance = covariance * max(1.0, chi2 / max(1, 3 * (len(at) - 1)))
    least = shared_m**2 * np.eye(3)
    variance = float(np.trace(covariance)) / 3.0
    if variance < shared_m**2:
        covariance = least
    heading, heading_sigma = _heading(sightings.headings, R, shared_rad)
    return Fused(p, 0.5 * (covariance + covariance.T), heading, heading_sigma)


def rotations(theta: FloatArray) -> FloatArray:
    """(N, 3, 3) rotations about z by ``theta`` (N,) rad."""
    c, s, zero, one = np.cos(theta), np.sin(theta), np.zeros_like(theta), np.ones_like(theta)
    rows = ((c, -s, zero), (s, c, zero), (zero, zero, one))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def placed(pose: Pose2, p: FloatArray) -> FloatArray:
    """The point ``p`` (3,) of a frame at ``pose``, in the frame of ``pose``."""
    xy = pose.transform(p[:2])
    return np.array([xy[0], xy[1], p[2]])


def _heading(vectors: FloatArray, R: FloatArray, shared_rad: float) -> tuple[float | None, float | None]:
    strength = np.linalg.norm(vectors, axis=1)
    known = strength > 0
    if not known.any():
        return None, None
    # No keyframe weighs more than its shared error allows.
    weights = 1.0 / (1.0 / strength[known] + shared_rad**2)
    units = vectors[known] / strength[known, None]
    total = np.einsum("n,nij,nj->i", weights, R[known, :2, :2], units)
    length = float(np.linalg.norm(total))
    if length < 1e-9:
        return None, None
    return wrap_angle(math.atan2(total[1], total[0])), max(shared_rad, length**-0.5)


def _by_anchor(anchors: NDArray[np.int64], p: FloatArray, information: FloatArray, headings: FloatArray) -> Sightings:
    ids, rows = np.unique(anchors, return_inverse=True)
    rows = rows.reshape(-1)
    total, weighted, vectors = np.zeros((len(ids), 3, 3)), np.zeros((len(ids), 3)), np.zeros((len(ids), 2))
    np.add.at(total, rows, information)
    np.add.at(weighted, rows, np.einsum("nij,nj->ni", information, p))
    np.add.at(vectors, rows, headings)
    p_KQ = np.asarray(np.linalg.solve(total, weighted[..., None])[..., 0], np.float64)
    return Sightings(ids, p_KQ, total, vectors)

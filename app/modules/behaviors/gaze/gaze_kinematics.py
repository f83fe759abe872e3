"""Inverse kinematics of gaze: joint positions at which an eye's optical axis passes through a point. Pure functions.

Nothing is known of the body but its kinematic model: any joints that move the eye, in any order, with any offsets. The
method is Gauss and Newton's, on the angle between axis and point. Limits are an active set: a joint that would pass its
limit stays there, and the others do what they can.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.kinematic_model import KinematicModel
from app.link import JointLimits

_ITERATIONS = 30
_DIFFERENCE_RAD = 1e-6
_DONE_RAD = 1e-5
#: Added to the squares of the Jacobian's singular values: looking along a joint's axis, its step must stay finite.
_DAMPING = 1e-6


@dataclass(frozen=True, slots=True)
class Gaze:
    """Joint ``positions`` (rad) by name, and the angle (rad) that is left between the optical axis and the point."""

    positions: Mapping[str, float]
    error_rad: float


def aim(
    model: KinematicModel,
    eye: str,
    joints: Sequence[JointLimits],
    p_BP: NDArray[np.float64],
    measured: Mapping[str, float],
) -> Gaze:
    """Positions of ``joints`` within their limits that bring the point ``p_BP`` (3,) m, in the model's root link, as
    near to the optical axis of the link ``eye`` (its z) as they can.

    ``measured``: positions by name of all joints of the model (missing ones are 0), from which the search begins.
    Raises KeyError for a link that the model does not have.
    """
    lower, upper = np.array([j.lower for j in joints]), np.array([j.upper for j in joints])
    names = [joint.name for joint in joints]

    def beside(q: NDArray[np.float64]) -> NDArray[np.float64]:
        X_BE = model.pose(eye, {**measured, **dict(zip(names, q.tolist(), strict=True))})
        return _off_axis(X_BE.inverse().transform(p_BP).astype(np.float64))

    here = np.array([measured.get(name, 0.0) for name in names])
    # Half a turn away the way round is not decided by the angle: then the middle of the joints' ranges may be better.
    middle = np.array([(j.lower + j.upper) / 2 if math.isfinite(j.upper - j.lower) else 0.0 for j in joints])
    best = np.clip(here, lower, upper)
    for start in (here, middle):
        found = _descend(beside, np.clip(start, lower, upper), lower, upper)
        if _angle(beside(found)) < _angle(beside(best)) - _DONE_RAD:
            best = found
        if _angle(beside(best)) < 10 * _DONE_RAD:
            break
    return Gaze(dict(zip(names, best.tolist(), strict=True)), _angle(beside(best)))


def gaze_error(model: KinematicModel, eye: str, p_BP: NDArray[np.float64], measured: Mapping[str, float]) -> float:
    """Angle (rad) between the optical axis of the link ``eye`` and the point ``p_BP`` (3,) m, in the model's root link,
    with the joints at ``measured``. Raises KeyError for a link that the model does not have."""
    return _angle(_off_axis(model.pose(eye, measured).inverse().transform(p_BP).astype(np.float64)))


def _off_axis(p_EP: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles (2,) rad right and down by which a point of the eye's optical frame lies off its axis: the direction of
    the shortest turn times its angle."""
    x, y, z = (float(value) for value in p_EP)
    across = math.hypot(x, y)
    if across == 0.0:
        return np.array([0.0 if z >= 0 else math.pi, 0.0])
    return math.atan2(across, z) / across * np.array([x, y])


def _angle(off_axis: NDArray[np.float64]) -> float:
    return float(np.hypot(*off_axis))


def _descend(
    beside: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    q: NDArray[np.float64],
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Positions within ``lower`` and ``upper`` at a minimum of the angle of ``beside``, down from ``q``."""
    off = beside(q)
    for _ in range(_ITERATIONS):
        if _angle(off) < _DONE_RAD:
            break
        columns = [(beside(q + _DIFFERENCE_RAD * unit) - off) / _DIFFERENCE_RAD for unit in np.eye(len(q))]
        step = _bounded_step(np.column_stack(columns), off, lower - q, upper - q)
        if np.abs(step).max() < _DONE_RAD:
            break
        share = 1.0
        while share > 1e-3 and _angle(beside(q + share * step)) >= _angle(off):
            share /= 2
        if share <= 1e-3:
            break
        q = np.clip(q + share * step, lower, upper)
        off = beside(q)
    return q


def _bounded_step(
    jacobian: NDArray[np.float64], off: NDArray[np.float64], least: NDArray[np.float64], most: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The step (n,) that cancels ``off`` (2,) best; a joint that would pass its bounds stays at them, and the others
    share what is left."""
    step = np.zeros(len(least))
    free = np.ones(len(least), dtype=bool)
    while free.any():
        J = jacobian[:, free]
        rest = off + jacobian[:, ~free] @ step[~free]
        step[free] = -np.linalg.solve(J.T @ J + _DAMPING * np.eye(J.shape[1]), J.T @ rest)
        beyond = free & ((step < least) | (step > most))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, least, most)[beyond]
        free &= ~beyond
    return step

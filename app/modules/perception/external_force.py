"""The force on a point of an arm, from what its joints feel: F = pinv(J^T) tau.

What a joint feels from outside is what neither its motor nor its damping accounts for: tau = -(motor - D dq/dt), as
long as the arm does not speed up and its weight is compensated. J (3, n) is the point's Jacobian. The point is supposed
to be where the arm is touched: touched at half the forearm, the force is found about a fifth wrong. Along a stretched
arm no joint feels anything: near there, where J is ill-conditioned, there is no estimate.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from app.base.kinematic_model import KinematicModel
from app.messages import ExternalForce

#: The greatest condition number of J: beyond it, noise of the joints is magnified into forces that are not there.
HIGHEST_CONDITION = 20.0


def felt_efforts(model: KinematicModel, efforts: Mapping[str, float], speeds: Mapping[str, float]) -> dict[str, float]:
    """What each joint feels from outside (N m, N where prismatic), by name: its motor exerts ``efforts`` and it moves
    with ``speeds`` (rad/s, m/s; missing ones are 0)."""
    return {
        name: -(effort - model.joints[name].damping * speeds.get(name, 0.0))
        for name, effort in efforts.items()
        if name in model.joints
    }


def force_on(
    model: KinematicModel, link: str, positions: Mapping[str, float], felt: Mapping[str, float]
) -> ExternalForce | None:
    """The force at the origin of ``link`` that its joints, at ``positions`` (rad, m), feel as ``felt`` (N m, N); None
    where they cannot know it. Raises KeyError for a link that the body does not have."""
    joints = [name for name in model.moved_by(link) if name in felt]
    f_B = solved(model.jacobian(link, joints, positions), np.array([felt[name] for name in joints]))
    if f_B is None:
        return None
    p_B = model.pose(link, positions).translation
    return ExternalForce(link, (float(p_B[0]), float(p_B[1]), float(p_B[2])), (f_B[0], f_B[1], f_B[2]))


def solved(jacobian: NDArray[np.float64], efforts: NDArray[np.float64]) -> list[float] | None:
    """The force (3,) N for which ``jacobian`` (3, n) gives ``efforts`` (n,) best; None where it is ill-conditioned."""
    if jacobian.shape[1] < 3:
        return None
    left, stretch, right = np.linalg.svd(jacobian, full_matrices=False)
    if not stretch[0] < HIGHEST_CONDITION * stretch[2]:
        return None
    return [float(f) for f in left @ ((right @ efforts) / stretch)]

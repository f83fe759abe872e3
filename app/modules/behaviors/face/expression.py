"""Expressions as positions of the face's nine joints. Pure functions; a pose is (9,) float64, rad, in the order of
``JOINTS``.

The joints and the four expressions, each in two variants that alternate every 5 s, are those of IRL-1 (thesis 3.2); so
is the reaction to a detection, I ((n - t) / n)^2. Signs: inner end of an eyebrow up, eyes left and up, eyelids closed,
corners of the mouth up, lips open.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from app.link import JointLimits

FacePose = NDArray[np.float64]
Expression = Literal["attractive", "happy", "sad", "angry"]

JOINTS: Final = (
    "left_eyebrow_joint",
    "right_eyebrow_joint",
    "eyes_pan_joint",
    "eyes_tilt_joint",
    "eyelids_joint",
    "left_mouth_corner_joint",
    "right_mouth_corner_joint",
    "upper_lip_joint",
    "lower_lip_joint",
)
EXPRESSIONS: Final[tuple[Expression, ...]] = get_args(Expression)
VARIANT_S: Final = 5.0
"""So long a variant lasts (s), with the turn to it."""
TURN_S: Final = 0.8
REACTION_S: Final = 0.8
LIDS_CLOSED: Final = 1.2

_BROWS, _EYES, _LIDS, _CORNERS, _LIPS = slice(0, 2), slice(2, 4), 4, slice(5, 7), slice(7, 9)


def _pose(*positions: float) -> FacePose:
    pose = np.array(positions)
    pose.flags.writeable = False
    return pose


CALM: Final = _pose(0.12, 0.12, 0, 0, 0.26, 0.18, 0.18, 0.02, 0.03)
VARIANTS: Final[Mapping[Expression, tuple[FacePose, FacePose]]] = {
    "attractive": (
        _pose(0.34, -0.06, 0, 0, 0.54, 0.52, 0.26, 0.03, 0.05),
        _pose(-0.06, 0.34, 0, 0, 0.54, 0.26, 0.52, 0.03, 0.05),
    ),
    "happy": (
        _pose(0.28, 0.28, 0, 0, 0.18, 0.68, 0.68, 0.10, 0.20),
        _pose(0.16, 0.16, 0, 0, 0.40, 0.58, 0.58, 0.04, 0.07),
    ),
    "sad": (
        _pose(0.52, 0.52, 0, -0.14, 0.42, -0.50, -0.50, 0.00, 0.02),
        _pose(0.42, 0.42, 0.12, -0.24, 0.58, -0.40, -0.40, 0.03, 0.02),
    ),
    "angry": (
        _pose(-0.46, -0.46, 0, 0, 0.46, -0.34, -0.34, -0.03, -0.03),
        _pose(-0.36, -0.48, 0, 0, 0.56, -0.40, -0.20, 0.12, 0.10),
    ),
}
"""The two variants of each expression."""

_REACTION: Final = _pose(0.24, 0.24, 0, 0, -0.22, 0, 0, 0.03, 0.06)
#: By viseme (``app.speech.visemes``): how far the upper and the lower lip are open, and the corners up (rad).
_MOUTHS: Final[Mapping[str, tuple[float, float, float]]] = {
    "closed": (0.00, 0.00, 0.00),
    "teeth": (0.05, -0.03, 0.00),
    "narrow": (0.05, 0.10, 0.00),
    "spread": (0.06, 0.13, 0.12),
    "mid": (0.07, 0.20, 0.00),
    "open": (0.11, 0.38, 0.00),
    "round": (0.10, 0.30, -0.20),
    "pursed": (0.07, 0.16, -0.26),
}
_CORNERS_WHILE_SPEAKING = 0.6
"""Share of an expression that the corners of a speaking mouth keep."""


def alternation(time: float) -> float:
    """Share of the second variant at ``time`` (s), 0 to 1: each lasts ``VARIANT_S``, with a smooth turn at its
    begin."""
    into, second = math.fmod(time, VARIANT_S), math.floor(time / VARIANT_S) % 2 == 1
    turned = _smooth(into / TURN_S)
    return turned if second else 1.0 - turned


def expressed(weights: Mapping[Expression, float], time: float) -> FacePose:
    """The pose of expressions with ``weights`` at ``time`` (s); what their sum leaves of 1 is the calm face.

    Weights are not negative; above a sum of 1 they count by their shares.
    """
    total = max(1.0, sum(weights.values()))
    second = alternation(time)
    pose = CALM.copy()
    for name, weight in weights.items():
        begin, end = VARIANTS[name]
        pose += weight / total * (begin + second * (end - begin) - CALM)
    return pose


def reaction(age_s: float, strength: float = 1.0) -> FacePose:
    """The small movement ``age_s`` after a detection, to be added: raised brows, wider eyes; 0 beyond
    ``REACTION_S``."""
    left = max(0.0, (REACTION_S - age_s) / REACTION_S) if age_s >= 0 else 0.0
    return strength * left**2 * _REACTION


def with_mouth(pose: FacePose, viseme: str) -> FacePose:
    """``pose`` with a mouth that says ``viseme``; one that is not known is a neutral vowel."""
    upper, lower, corners = _MOUTHS.get(viseme, _MOUTHS["mid"])
    spoken = pose.copy()
    spoken[_LIPS] = upper, lower
    spoken[_CORNERS] = _CORNERS_WHILE_SPEAKING * pose[_CORNERS] + corners
    return spoken


def with_gaze(pose: FacePose, pan: float, tilt: float) -> FacePose:
    """``pose`` with eyes that look to ``pan`` (left) and ``tilt`` (up), rad from straight ahead; eyelids follow eyes
    that look down."""
    gazing = pose.copy()
    gazing[_EYES] = pan, tilt
    gazing[_LIDS] += 0.6 * max(0.0, -tilt)
    return gazing


def with_blink(pose: FacePose, closed: float) -> FacePose:
    """``pose`` with eyelids that are ``closed`` by that share of what was open, 0 to 1."""
    blinking = pose.copy()
    blinking[_LIDS] += closed * max(0.0, LIDS_CLOSED - pose[_LIDS])
    return blinking


def approach(before: FacePose, goal: FacePose, limits: Sequence[JointLimits], elapsed_s: float) -> FacePose:
    """The pose between ``before`` and ``goal`` that the joints reach within ``elapsed_s`` at their greatest speeds,
    within their positions. ``limits``: of each joint, in the order of ``JOINTS``."""
    lower, upper = np.array([j.lower for j in limits]), np.array([j.upper for j in limits])
    reach = np.array([j.velocity for j in limits]) * max(elapsed_s, 0.0)
    return np.clip(before + np.clip(np.clip(goal, lower, upper) - before, -reach, reach), lower, upper)


def _smooth(share: float) -> float:
    """From 0 to 1 with a level begin and end."""
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)

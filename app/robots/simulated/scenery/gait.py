"""Posture of a person: joints of the limbs, and their motion when walking and clapping.

Lengths are shares of the person's height. Proportions: Drillis and Contini 1966 (in Winter, *Biomechanics and Motor
Control of Human Movement*, figure 4.1); the mouth's height is that of ``app/modules/perception/height_prior.py``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

EYES_SHARE, MOUTH_SHARE = 0.936, 0.896
NECK_SHARE, HIP_SHARE, SHOULDER_SHARE, HANDS_SHARE = 0.850, 0.520, 0.795, 0.720
HIP_ASIDE, SHOULDER_ASIDE = 0.048, 0.115
THIGH, SHIN, UPPER_ARM, FOREARM = 0.245, 0.246, 0.165, 0.145
MOUTH_AHEAD, HANDS_AHEAD = 0.057, 0.215
STEP = 0.43
"""Length of a step at 1.3 m/s."""
_SWING_RAD = 0.40
_ANKLE = HIP_SHARE - THIGH - SHIN


@dataclass(frozen=True, slots=True)
class Posture:
    """Posture of the limbs: ``gait`` phase (rad) and ``stride`` (0 standing, 1 a full step); ``clap`` 0 arms down, 1
    raised with the palms ``apart`` (0 together, 1 wide); ``head_yaw``, ``head_pitch`` (rad, up positive) on the body.
    """

    gait: float = 0.0
    stride: float = 0.0
    clap: float = 0.0
    apart: float = 1.0
    head_yaw: float = 0.0
    head_pitch: float = 0.0


@dataclass(frozen=True, slots=True)
class LimbJoint:
    """A limb's upper joint in the person's own frame (feet at the origin, x forward) and its angles (rad): ``pitch``
    about y (positive swings a hanging limb backward), then ``yaw`` about z.
    """

    at: tuple[float, float, float]
    pitch: float = 0.0
    yaw: float = 0.0


def drop(posture: Posture) -> float:
    """Lowering of the trunk relative to standing: spread legs reach less far down."""
    return HIP_SHARE - _ANKLE - max(_reach(leg) for leg in _legs(posture))


def joints(posture: Posture) -> dict[str, LimbJoint]:
    """Every limb's joint in ``posture``."""
    lower = drop(posture)
    hip = HIP_SHARE - lower
    legs = _legs(posture)
    found = {
        "trunk": LimbJoint((0.0, 0.0, hip), pitch=0.03 * posture.stride),
        "head": LimbJoint((0.0, 0.0, NECK_SHARE - lower), -posture.head_pitch, posture.head_yaw),
    }
    for side, sign, (thigh, shin) in zip(("left", "right"), (1, -1), legs, strict=True):
        knee = (-THIGH * math.sin(thigh), sign * HIP_ASIDE, hip - THIGH * math.cos(thigh))
        found[f"{side}_thigh"] = LimbJoint((0.0, sign * HIP_ASIDE, hip), thigh)
        found[f"{side}_shin"] = LimbJoint(knee, shin)
        upper, lower_arm, inward = _arm(-0.8 * thigh * posture.stride, posture)
        shoulder = (0.0, sign * SHOULDER_ASIDE, SHOULDER_SHARE - lower)
        elbow = (-UPPER_ARM * math.sin(upper), shoulder[1], shoulder[2] - UPPER_ARM * math.cos(upper))
        found[f"{side}_upper_arm"] = LimbJoint(shoulder, upper)
        found[f"{side}_forearm"] = LimbJoint(elbow, lower_arm, -sign * inward)
    return found


def mouth(posture: Posture) -> tuple[float, float]:
    """Position of the mouth: ahead of the neck along the gaze, and height above the floor."""
    up = MOUTH_SHARE - NECK_SHARE
    c, s = math.cos(posture.head_pitch), math.sin(posture.head_pitch)
    return MOUTH_AHEAD * c - up * s, NECK_SHARE - drop(posture) + MOUTH_AHEAD * s + up * c


def _legs(posture: Posture) -> tuple[tuple[float, float], tuple[float, float]]:
    """Pitch of thigh and shin, left and right: the thigh swings, the knee bends while it comes forward."""
    swing = _SWING_RAD * posture.stride

    def leg(phase: float) -> tuple[float, float]:
        thigh = swing * math.cos(phase)
        return thigh, thigh + 1.6 * swing * max(0.0, math.sin(phase - 0.4))

    return leg(posture.gait), leg(posture.gait + math.pi)


def _reach(leg: tuple[float, float]) -> float:
    return THIGH * math.cos(leg[0]) + SHIN * math.cos(leg[1])


def _arm(swing: float, posture: Posture) -> tuple[float, float, float]:
    """Pitch of upper arm and forearm, and how far the forearm turns inward: hanging and swinging, or clapping."""
    clap = posture.clap
    upper = (1 - clap) * swing - 0.45 * clap
    lower = (1 - clap) * (swing - 0.18) - 1.75 * clap
    return upper, lower, clap * (0.68 - 0.50 * posture.apart)

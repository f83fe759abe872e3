"""The desire classes of the arms, and their parameters."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict, Field

from app.attention.desires import DesireClass
from app.maps.zones import FURTHEST_M
from app.modules.behaviors.gaze.look_at import Frame
from app.modules.behaviors.gestures.impedance import StiffnessParameters

Side = Literal["left", "right"]
Choice = Literal["better", "left", "right"]

_PLACE = "The point, in metres in its frame."


class _Point(StiffnessParameters):
    x: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="x", description=_PLACE)
    y: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="y", description=_PLACE)
    z: float = Field(1.0, ge=-100, le=100, title="z", description="Its height, in metres above the floor.")
    frame: Frame = Field(
        "odom", title="Frame", description="base_link: it turns with the robot; odom or map: it stays in the room."
    )
    arm: Choice = Field("better", title="Arm", description="By which arm: left, right, or the better one.")


class PointAtParameters(_Point):
    """Parameters of a desire of class PointAt."""

    model_config = ConfigDict(extra="forbid", title="Point at", allow_inf_nan=False)

    turn: bool = Field(
        True, title="Turn", description="Whether the base turns towards a point that the arms cannot point at."
    )
    hold_s: float = Field(3.0, ge=0, le=600, title="For how long", description="Seconds for which it points.")


class ReachParameters(_Point):
    """Parameters of a desire of class Reach."""

    model_config = ConfigDict(extra="forbid", title="Reach for", allow_inf_nan=False)

    hold_s: float = Field(
        0.0, ge=0, le=600, title="For how long", description="Seconds for which the hand stays there."
    )


class WaveParameters(StiffnessParameters):
    """Parameters of a desire of class Wave."""

    model_config = ConfigDict(extra="forbid", title="Wave", allow_inf_nan=False)

    arm: Choice = Field("better", title="Arm", description="By which arm: left, right, or one that is free.")
    times: int = Field(3, ge=1, le=20, title="Times", description="How often to and fro, 1 to 20.")


class RestParameters(StiffnessParameters):
    """Parameters of a desire of class Rest."""

    model_config = ConfigDict(extra="forbid", title="Rest", allow_inf_nan=False)

    arm: Literal["both", "left", "right"] = Field("both", title="Arm", description="Which arm: left, right, or both.")
    hold_s: float = Field(
        0.0, ge=0, le=600, title="For how long", description="Seconds for which it stays there; a free one from now on."
    )


class GripperParameters(StiffnessParameters):
    """Parameters of desires of classes Hold and Release."""

    model_config = ConfigDict(extra="forbid", title="Gripper", allow_inf_nan=False)

    arm: Side = Field("right", title="Arm", description="Which gripper: left or right.")


POINT_AT = DesireClass(
    name="PointAt",
    title="Point at a point",
    description="Point at a point with an arm, turning the base towards it where that is needed.",
    parameters=PointAtParameters,
    achievement=True,
)
REACH = DesireClass(
    name="Reach",
    title="Reach for a point",
    description="Bring a hand to a point within the arm's reach.",
    parameters=ReachParameters,
    achievement=True,
)
WAVE = DesireClass(
    name="Wave", title="Wave", description="Wave with an arm.", parameters=WaveParameters, achievement=True
)
REST = DesireClass(
    name="Rest",
    title="Rest the arms",
    description="Let the arms hang at rest, or make them free so that a person can lead them.",
    parameters=RestParameters,
    achievement=True,
)
HOLD = DesireClass(
    name="Hold",
    title="Hold a thing",
    description="Close a gripper on what is between its fingers; it stays closed until Release.",
    parameters=GripperParameters,
    achievement=True,
)
RELEASE = DesireClass(
    name="Release",
    title="Let go of a thing",
    description="Open a gripper.",
    parameters=GripperParameters,
    achievement=True,
)

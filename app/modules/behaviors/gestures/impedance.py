"""How stiff an arm is: words and numbers of a desire as the stiffness and damping of a command. Pure functions."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import BaseModel, Field

from app.link import ActuatorGroup

Stiffness = Literal["usual", "free", "soft", "stiff"]

#: Of the group's usual stiffness.
_SOFT = 1 / 3
_STIFF = 5.0


class StiffnessParameters(BaseModel):
    """Parameters of desires that say how stiff a group of joints is."""

    stiffness: Stiffness = Field(
        "usual",
        title="Stiffness",
        description="How it gives way to a push: free (it keeps no position), soft, stiff, or as usual.",
    )
    stiffness_nm: float | None = Field(
        None,
        ge=0,
        le=10000,
        title="Stiffness in numbers",
        description="The same in N m/rad (N/m of a gripper), within what the body allows; none: by the word.",
    )


def impedance(group: ActuatorGroup, wanted: StiffnessParameters) -> tuple[float, float] | None:
    """Stiffness (N m/rad, N/m where prismatic) and damping for the joints of ``group``; None: its own.

    The damping is the usual one scaled by the root of the stiffness, which damps the same inertia alike.
    Raises ValueError for a group that is not compliant, and for a stiffness that it does not take.
    """
    if wanted.stiffness_nm is None and wanted.stiffness == "usual":
        return None
    if not group.compliant:
        raise ValueError(f"{group.name} is not compliant: its stiffness cannot be set")
    least, most = group.stiffness_range
    words = {
        "usual": group.stiffness,
        "free": least,
        "soft": max(least, group.stiffness * _SOFT),
        "stiff": min(most, group.stiffness * _STIFF),
    }
    stiffness = words[wanted.stiffness] if wanted.stiffness_nm is None else wanted.stiffness_nm
    if not least <= stiffness <= most:
        raise ValueError(f"a stiffness of {stiffness:g} is not within {least:g} to {most:g}, which {group.name} takes")
    damping = group.damping * math.sqrt(stiffness / group.stiffness) if group.stiffness > 0 else group.damping
    return stiffness, min(max(damping, group.damping_range[0]), group.damping_range[1])

"""Gains of the features of saliency, for the ego-sphere and what looks at its regions: what the robot is after decides
what stands out (Kismet). Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

FEATURES = ("motion", "color", "contrast", "faces", "sounds")
"""Of pictures: motion, colour and contrast with what is around; percepts: faces and sounds."""
#: Before the name of a feature: a factor to its gain, by a strategy that serves something else.
RAISED = "raised_"


class SaliencyGains(BaseModel):
    """How much each feature counts: parameters of the desires WatchSurroundings and LookAtSalient."""

    model_config = ConfigDict(extra="forbid", title="Gains of features", allow_inf_nan=False)

    motion: float = Field(1.0, ge=0, le=10, title="Motion", description="How much counts what moves.")
    color: float = Field(0.3, ge=0, le=10, title="Colour", description="How much counts a colour unlike those around.")
    contrast: float = Field(
        0.2, ge=0, le=10, title="Contrast", description="How much counts what is brighter or darker than around it."
    )
    faces: float = Field(1.0, ge=0, le=10, title="Faces", description="How much counts a face that was detected.")
    sounds: float = Field(1.0, ge=0, le=10, title="Sounds", description="How much counts a sound that was localized.")


def gains_of(parameters: Mapping[str, Any], otherwise: SaliencyGains) -> dict[str, float]:
    """The gain of each feature by a module's ``parameters``: a desire's, or those of ``otherwise``, times
    ``raised_FEATURE`` of the strategies in force. Raises TypeError, ValueError for what is no number."""
    return {
        name: float(parameters.get(name, getattr(otherwise, name))) * float(parameters.get(RAISED + name, 1.0))
        for name in FEATURES
    }

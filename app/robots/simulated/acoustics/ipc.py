"""Messages between the link's process and its microphones' process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.messages import Audio
from app.robots.simulated.acoustics.sound_library import Key
from app.robots.simulated.world_config import WorldConfig
from app.robots.stream_config import LoudspeakerConfig, MicrophonesConfig

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class AcousticsSetup:
    """Constants: ``X_BM`` and ``X_BS`` are the poses of the microphones' and the loudspeaker's links.

    ``clips``: samples (N,) float32 with their levels; ``p_BW``: middles of the left and the right wheel.
    """

    config: MicrophonesConfig
    loudspeaker: LoudspeakerConfig | None
    world: WorldConfig
    X_BM: Pose3
    X_BS: Pose3
    p_BW: tuple[Vector, Vector]
    clips: Mapping[Key, tuple[NDArray[np.float32], float]]
    seed: int


@dataclass(frozen=True, slots=True)
class ActiveSound:
    """The state of a scripted sound: ``p_W`` m; ``looks`` (rad): heading of its mouth, or None."""

    name: str
    key: Key
    begin_s: float
    gain_db: float
    loop: bool
    p_W: Vector
    looks: float | None


@dataclass(frozen=True, slots=True)
class SoundScene:
    """The world at ``time_s`` (simulated), ``stamp`` by the robot's clock. ``rims_mps``: left and right wheel."""

    time_s: float
    stamp: float
    X_WB: Pose2
    rims_mps: tuple[float, float]
    sounds: tuple[ActiveSound, ...]


@dataclass(frozen=True, slots=True, eq=False)
class LoudspeakerFrame:
    audio: Audio


@dataclass(frozen=True, slots=True, eq=False)
class MicrophoneFrame:
    """One frame of the microphones; ``lost``: number of frames dropped just before it.

    ``played``: what the loudspeaker played in the same samples' time, by the same numbers; None for silence.
    """

    audio: Audio
    lost: int
    played: Audio | None = None

"""Every message that crosses a channel: frozen, slotted dataclasses, passed by reference, never copied.

Conventions (ARCHITECTURE.md, *Words*): SI units, radians, seconds; right-handed frames, x forward, y left, z up (REP
103/105: ``odom -> base_link -> ...``); camera optical frames x right, y down, z forward. ``stamp`` is the robot's clock
at *capture*, seconds since the Unix epoch. Arrays are read-only: the publisher of a message passes its arrays through
:func:`read_only`. Poses are named by monogram: ``X_WB`` is the pose of B in W, ``p_WB`` its translation; M is ``map``
(in ``p_BM`` a microphone), O ``odom``, B ``base_link``, C a camera's optical frame, L the laser, A the array of
microphones, Q a QR code, F a face, S a sound source.
"""

from __future__ import annotations

from app.messages.actuation import GroupStatus, JointCommand
from app.messages.base import Message, read_only
from app.messages.driving import Exploitation, LinkStatus, OperatorDrive, Twist
from app.messages.navigation import (
    GivenUpGoal,
    Localization,
    NavigationReport,
    NavigationStatus,
    OccupancyGrid,
    PlannedPath,
    Zone,
    Zones,
)
from app.messages.percepts import (
    Darkness,
    EncodedImage,
    Face,
    Faces,
    Landmark,
    Landmarks,
    LoudNoise,
    PerceptEvent,
    PlacedCode,
    PlacedFace,
    PlacedPercepts,
    PlacedSound,
    PointCloud,
    QRCode,
    QRCodes,
    SeparatedSound,
    SoundSource,
    SoundSources,
)
from app.messages.records import (
    DesireRecord,
    DesiresRecord,
    Divisors,
    EventRecord,
    IntentionRecord,
    LaneRow,
    Lanes,
    LaneState,
    LoadRecord,
    LogLine,
    ModuleRecord,
    ReasonRecord,
    RecorderState,
    RecorderStatus,
)
from app.messages.sensors import (
    Audio,
    GroundTruth,
    Image,
    JointState,
    LaserScan,
    Odometry,
    PersonTruth,
    SceneTruth,
    SoundTruth,
)
from app.messages.speech import Speech, SpeechState

__all__ = [
    "Audio",
    "Darkness",
    "DesireRecord",
    "DesiresRecord",
    "Divisors",
    "EncodedImage",
    "EventRecord",
    "Exploitation",
    "Face",
    "Faces",
    "GivenUpGoal",
    "GroundTruth",
    "GroupStatus",
    "Image",
    "IntentionRecord",
    "JointCommand",
    "JointState",
    "Landmark",
    "Landmarks",
    "LaneRow",
    "LaneState",
    "Lanes",
    "LaserScan",
    "LinkStatus",
    "LoadRecord",
    "Localization",
    "LogLine",
    "LoudNoise",
    "Message",
    "ModuleRecord",
    "NavigationReport",
    "NavigationStatus",
    "OccupancyGrid",
    "Odometry",
    "OperatorDrive",
    "PerceptEvent",
    "PersonTruth",
    "PlacedCode",
    "PlacedFace",
    "PlacedPercepts",
    "PlacedSound",
    "PlannedPath",
    "PointCloud",
    "QRCode",
    "QRCodes",
    "ReasonRecord",
    "RecorderState",
    "RecorderStatus",
    "SceneTruth",
    "SeparatedSound",
    "SoundSource",
    "SoundSources",
    "SoundTruth",
    "Speech",
    "SpeechState",
    "Twist",
    "Zone",
    "Zones",
    "read_only",
]

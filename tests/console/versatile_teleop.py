"""Teleop of the console's test programs, which declares every desire class of the lab: none of them has all modules."""

from __future__ import annotations

from typing import ClassVar

from app.attention.desires import DesireClass
from app.modules.behaviors.gaze.look_at import LOOK_AT
from app.modules.behaviors.go_to import GO_TO
from app.modules.behaviors.teleop import TELEOPERATION, Teleop
from app.modules.perception.audio_stream import LISTEN
from app.modules.perception.face_detector import LOCATE_FACES
from app.modules.perception.loud_noise_detector import DETECT_NOISES
from app.modules.perception.qr_code_detector import FIND_QR_CODES
from app.modules.perception.slam_2d import MAP_AND_LOCALIZE
from app.modules.perception.telepresence import TELEPRESENCE
from app.modules.perception.voice_localizer import LOCATE_VOICES
from app.modules.recording.recorder import RECORD


class VersatileTeleop(Teleop):
    """Teleop, of which anything can be desired."""

    desire_classes: ClassVar[tuple[DesireClass, ...]] = (  # type: ignore[assignment]
        FIND_QR_CODES,
        LOCATE_FACES,
        DETECT_NOISES,
        LOCATE_VOICES,
        MAP_AND_LOCALIZE,
        GO_TO,
        TELEOPERATION,
        TELEPRESENCE,
        LISTEN,
        RECORD,
        LOOK_AT,
    )

"""What the robot sees and hears, as the page, the 3D view and REST tell it: faces, QR codes, sounds, loud noises.

Each percept is placed with the pose the robot had at its own stamp, once odometry has reached that.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.base.geometry import FloatArray, Pose3
from app.base.pose_buffer import PoseBuffer
from app.console.perceived import Direction, HeardSound, Perceived, Point, SeenCode, SeenFace
from app.messages import (
    EncodedImage,
    Face,
    Faces,
    LoudNoise,
    Odometry,
    QRCode,
    QRCodes,
    SoundSource,
    SoundSources,
)
from app.runtime.graph import Graph

#: A face or a code is told until it was not seen for this long (s), or for so many images of its camera, and never
#: longer than the last.
SEEN_S = 1.0
SEEN_IMAGES = 2.5
LONGEST_SEEN_S = 4.0
#: Without news of sounds for this long (s), none of them sounds any more.
SILENCE_S = 0.5
#: A sound is told so long (s) after it last sounded, a noise so long after it was heard.
SOUND_S = 2.0
NOISE_S = 2.0

_MOST_POSES = 64


@dataclass(frozen=True, slots=True)
class _Heard:
    stamp: float
    p_BA: Point
    source: SoundSource
    last_active: float


class Percepts:
    """Remembers what was said on channels of faces, QR codes, sound sources and loud noises, as far as there are such.

    It is told as messages are published and is no consumer: perceptions may rest for it. :meth:`open` when the program
    runs; what it returns ends it.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self.forget()

    @property
    def channels(self) -> tuple[str, ...]:
        """Those of its channels that this program has."""
        return tuple(
            name for name in ("faces", "qr_codes", "sound_sources", "loud_noises") if name in self._graph.channels
        )

    def open(self) -> Callable[[], None]:
        """Begin to remember."""
        handlers: dict[str, Callable[[Any], None]] = {
            "odometry": self._on_odometry,
            "faces": self._on_faces,
            "qr_codes": self._on_codes,
            "sound_sources": self._on_sounds,
            "loud_noises": self._on_noise,
        }
        stack = ExitStack()
        for name, handler in handlers.items():
            if name in self._graph.channels:
                stack.callback(self._graph.channel(name).observe(handler))
        return stack.close

    def forget(self) -> None:
        """Time has jumped: nothing of before is true."""
        self._poses = PoseBuffer(span_s=LONGEST_SEEN_S + 2.0, tolerance_s=0.0)
        #: By track and camera, with all that was said of the image.
        self._faces: dict[tuple[int, str], tuple[Faces, Face]] = {}
        #: By text and camera, likewise.
        self._codes: dict[tuple[str, str], tuple[QRCodes, QRCode]] = {}
        #: By what is looked for and camera: stamp of its last image, and the time between the last two.
        self._images: dict[tuple[str, str], tuple[float, float]] = {}
        self._sounds: dict[int, _Heard] = {}
        self._sounding: frozenset[int] = frozenset()
        self._sounds_stamp = -math.inf
        self._noises: deque[LoudNoise] = deque(maxlen=32)
        #: Poses X_OB by stamp, of the stamps that were asked for last.
        self._placed: dict[float, Pose3] = {}

    def _on_odometry(self, message: Odometry) -> None:
        self._poses.add(message.stamp, message.X_OB)

    def _on_faces(self, message: Faces) -> None:
        self._looked("faces", message)
        for face in message.faces:
            self._faces[face.track, message.frame] = (message, face)
        self._fade(message.stamp)

    def _on_codes(self, message: QRCodes) -> None:
        self._looked("codes", message)
        for code in message.codes:
            self._codes[code.text, message.frame] = (message, code)
        self._fade(message.stamp)

    def _looked(self, what: str, message: Faces | QRCodes) -> None:
        before, _ = self._images.get((what, message.frame), (message.stamp, 0.0))
        self._images[what, message.frame] = (message.stamp, message.stamp - before)

    def _on_sounds(self, message: SoundSources) -> None:
        self._sounds_stamp = message.stamp
        self._sounding = frozenset(source.track for source in message.sources if source.active)
        for source in message.sources:
            before = self._sounds.get(source.track)
            # Of one that was silent since its birth, its birth is all there is.
            last = message.stamp if source.active or before is None else before.last_active
            self._sounds[source.track] = _Heard(message.stamp, message.p_BA, source, last)
        self._fade(message.stamp)

    def _on_noise(self, message: LoudNoise) -> None:
        self._noises.append(message)

    # --- Now ---------------------------------------------------------------------------------------------------------

    def at(self, now: float) -> Perceived:
        """What is perceived at ``now`` (the robot's clock)."""
        self._fade(now)
        if not (self._faces or self._codes or self._sounds or self._noises):
            return Perceived(now)
        panorama = self._panorama()
        faces = tuple(
            self._face(of, face, panorama) for _, (of, face) in sorted(self._faces.items(), key=lambda item: item[0])
        )
        # Nobody tells any more that they sound.
        sounding = self._sounding if now - self._sounds_stamp <= SILENCE_S else frozenset()
        sounds = tuple(self._sound(heard, track in sounding, panorama) for track, heard in sorted(self._sounds.items()))
        codes = tuple(
            SeenCode(
                code.text,
                of.frame,
                of.stamp,
                tuple((float(u), float(v)) for u, v in code.corners),
                (of.width, of.height),
            )
            for _, (of, code) in sorted(self._codes.items(), key=lambda item: item[0])
        )
        return Perceived(now, faces, sounds, tuple(self._noises), codes)

    def _fade(self, now: float) -> None:
        """Forget what is over. With each message, too: for days nobody may ask."""
        for face, (faces, _) in tuple(self._faces.items()):
            if now - faces.stamp > self._kept_for("faces", face[1]):
                del self._faces[face]
        for code, (codes, _) in tuple(self._codes.items()):
            if now - codes.stamp > self._kept_for("codes", code[1]):
                del self._codes[code]
        for track, heard in tuple(self._sounds.items()):
            if now - heard.last_active > SOUND_S:
                del self._sounds[track]
        while self._noises and now - self._noises[0].stamp > NOISE_S:
            self._noises.popleft()

    def _kept_for(self, what: str, frame: str) -> float:
        _, period_s = self._images[what, frame]
        return min(max(SEEN_S, SEEN_IMAGES * period_s), LONGEST_SEEN_S)

    def _face(self, of: Faces, face: Face, panorama: Pose3 | None) -> SeenFace:
        p_BF = np.array(face.p_BF)
        X_OB = self._pose(of.stamp)
        return SeenFace(
            face.track,
            of.frame,
            stamp=of.stamp,
            direction=_direction(p_BF - of.X_BC.translation),
            panorama=None if panorama is None else _direction(p_BF - panorama.translation),
            range_m=face.range_m,
            range_sigma_m=face.range_sigma_m,
            p_OF=None if X_OB is None else _point(X_OB.transform(p_BF)),
            towards_O=None if X_OB is None else _direction(X_OB.rotation @ -p_BF)[0],
            score=face.score,
            box=face.box,
            image=(of.width, of.height),
        )

    def _sound(self, heard: _Heard, active: bool, panorama: Pose3 | None) -> HeardSound:
        source, p_BA, v_B = heard.source, np.array(heard.p_BA), np.array(heard.source.direction)
        X_OB = self._pose(heard.stamp)
        p_BS = p_BA + source.range_m * v_B if math.isfinite(source.range_m) else None
        seen = None
        if panorama is not None:
            seen = _direction(v_B if p_BS is None else p_BS - panorama.translation)
        return HeardSound(
            source.track,
            heard.stamp,
            direction=_direction(v_B),
            panorama=seen,
            power=source.power,
            level_db=source.level_db,
            active=active,
            last_active=heard.last_active,
            speech=source.speech,
            range_m=source.range_m,
            range_sigma_m=source.range_sigma_m,
            p_OA=None if X_OB is None else _point(X_OB.transform(p_BA)),
            v_O=None if X_OB is None else _point(X_OB.rotation @ v_B),
            p_OS=None if X_OB is None or p_BS is None else _point(X_OB.transform(p_BS)),
        )

    def _pose(self, stamp: float) -> Pose3 | None:
        X_OB = self._placed.get(stamp)
        if X_OB is None and (pose := self._poses.at(stamp)) is not None:
            X_OB = self._placed[stamp] = pose.to_pose3()
            if len(self._placed) > _MOST_POSES:
                del self._placed[next(iter(self._placed))]
        return X_OB

    def _panorama(self) -> Pose3 | None:
        """Where the camera was (X_BC) when the panorama that is shown now was taken."""
        channel = self._graph.channels.get("panorama_jpeg")
        picture = None if channel is None else channel.latest
        return picture.X_BC if isinstance(picture, EncodedImage) else None


def _direction(v_B: FloatArray) -> Direction:
    x, y, z = (float(value) for value in v_B)
    return math.atan2(y, x), math.atan2(z, math.hypot(x, y))


def _point(p: FloatArray) -> Point:
    return float(p[0]), float(p[1]), float(p[2])

"""PerceptPlacer: faces, QR codes, sounds and loud noises, each where it is.

    ┌──────────────────────────────────────────────────────────────────────────────────────┐
    │ PerceptPlacer  in   faces       Faces, any rate                                      │
    │                in   codes       QRCodes, any rate                                    │
    │                in   sounds      SoundSources, any rate                               │
    │                in   noises      LoudNoise, as they come                              │
    │                in   panorama    EncodedImage: where the panorama was taken           │
    │                in   odometry    Odometry, 100 Hz                                     │
    │                out  percepts    PlacedPercepts, at every change                      │
    └──────────────────────────────────────────────────────────────────────────────────────┘

Each percept is placed with the pose the robot had at the percept's own stamp, once odometry has reached that.
Perceptions rest while nothing wants the placed percepts, or their own; the panorama is never made for this module.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from app.base.geometry import FloatArray, Pose3
from app.base.pose_buffer import PoseBuffer
from app.messages import (
    EncodedImage,
    Face,
    Faces,
    LoudNoise,
    Odometry,
    PlacedCode,
    PlacedFace,
    PlacedPercepts,
    PlacedSound,
    QRCode,
    QRCodes,
    SoundSource,
    SoundSources,
    read_only,
)
from app.runtime.module import Module, ModuleContext

Point = tuple[float, float, float]
Direction = tuple[float, float]

#: Period (s) of removing percepts that are over.
PERIOD_S = 0.1
#: A face or a code is there until it was not seen for this long (s), or for so many images of its camera, and never
#: longer than the last.
SEEN_S = 1.0
SEEN_IMAGES = 2.5
LONGEST_SEEN_S = 4.0
#: Without a message of sounds for this long (s), none of them sounds any more.
SILENCE_S = 0.5
#: A sound is there so long (s) after it last sounded, a noise so long after it was heard.
SOUND_S = 2.0
NOISE_S = 2.0
#: Room for what comes while the loop does something else.
BURST = 100

_MOST_POSES = 64


@dataclass(frozen=True, slots=True)
class _Heard:
    stamp: float
    p_BA: Point
    source: SoundSource
    last_active: float


class Percepts:
    """Recent percepts; :meth:`at` places them. Messages come in the order in which they were published."""

    def __init__(self) -> None:
        #: Stamp of the newest panorama, and the pose of its camera (X_BC).
        self._panorama: tuple[float, Pose3] | None = None
        #: Whether a face or a sound of the last answer waits for the pose at its stamp.
        self.unplaced = False
        self._poses = PoseBuffer(span_s=LONGEST_SEEN_S + 2.0, tolerance_s=0.0)
        #: By track and camera, with the message of its image.
        self._faces: dict[tuple[int, str], tuple[Faces, Face]] = {}
        #: By text and camera, likewise.
        self._codes: dict[tuple[str, str], tuple[QRCodes, QRCode]] = {}
        #: By kind of percept and camera: stamp of its last image, and the time between the last two.
        self._images: dict[tuple[str, str], tuple[float, float]] = {}
        self._sounds: dict[int, _Heard] = {}
        self._sounding: frozenset[int] = frozenset()
        self._sounds_stamp = -math.inf
        self._noises: deque[LoudNoise] = deque(maxlen=32)
        #: Poses X_OB by stamp, of the stamps that were asked for last.
        self._placed: dict[float, Pose3] = {}

    def take(self, message: Odometry | Faces | QRCodes | SoundSources | LoudNoise | EncodedImage) -> None:
        match message:
            case Odometry():
                self._poses.add(message.stamp, message.X_OB)
            case Faces():
                self._looked("faces", message)
                for face in message.faces:
                    self._faces[face.track, message.frame] = (message, face)
                self._fade(message.stamp)
            case QRCodes():
                self._looked("codes", message)
                for code in message.codes:
                    self._codes[code.text, message.frame] = (message, code)
                self._fade(message.stamp)
            case SoundSources():
                self._take_sounds(message)
            case LoudNoise():
                level_db = round(message.level_db, 2)
                self._noises.append(replace(message, ratio=round(message.ratio, 2), level_db=level_db))
            case EncodedImage():
                self._panorama = message.stamp, message.X_BC

    def _looked(self, what: str, message: Faces | QRCodes) -> None:
        before, _ = self._images.get((what, message.frame), (message.stamp, 0.0))
        self._images[what, message.frame] = (message.stamp, message.stamp - before)

    def _take_sounds(self, message: SoundSources) -> None:
        self._sounds_stamp = message.stamp
        self._sounding = frozenset(source.track for source in message.sources if source.active)
        for source in message.sources:
            before = self._sounds.get(source.track)
            # Of one that was silent since its birth, its birth is all there is.
            last = message.stamp if source.active or before is None else before.last_active
            self._sounds[source.track] = _Heard(message.stamp, message.p_BA, source, last)
        self._fade(message.stamp)

    # --- Now ---------------------------------------------------------------------------------------------------------

    def at(self, now: float) -> PlacedPercepts:
        """The percepts at ``now`` (the robot's clock)."""
        self._fade(now)
        self.unplaced = False
        # Without a message of them, no sound sounds any more.
        sounding = self._sounding if now - self._sounds_stamp <= SILENCE_S else frozenset()
        return PlacedPercepts(
            now,
            tuple(self._face(of, face) for _, (of, face) in sorted(self._faces.items(), key=lambda item: item[0])),
            tuple(self._sound(heard, track in sounding) for track, heard in sorted(self._sounds.items())),
            tuple(self._noises),
            tuple(_code(of, code) for _, (of, code) in sorted(self._codes.items(), key=lambda item: item[0])),
        )

    def _fade(self, now: float) -> None:
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

    def _face(self, of: Faces, face: Face) -> PlacedFace:
        p_BF = np.array(face.p_BF)
        X_OB = self._pose(of.stamp)
        azimuth, elevation = _direction(p_BF - of.X_BC.translation)
        x, y, z = (None, None, None) if X_OB is None else _point(X_OB.transform(p_BF))
        return PlacedFace(
            track=face.track,
            camera=of.frame,
            stamp=of.stamp,
            azimuth=azimuth,
            elevation=elevation,
            panorama=self._in_panorama(X_OB, p_BF),
            range_m=_rounded(face.range_m),
            range_sigma_m=_rounded(face.range_sigma_m),
            x=x,
            y=y,
            z=z,
            towards_O=None if X_OB is None else _direction(X_OB.rotation @ -p_BF)[0],
            score=round(face.score, 3),
            box=tuple(round(value, 1) for value in face.box),  # type: ignore[arg-type]  # four, as they were
            image=(of.width, of.height),
        )

    def _sound(self, heard: _Heard, active: bool) -> PlacedSound:
        source, p_BA, v_B = heard.source, np.array(heard.p_BA), np.array(heard.source.direction)
        X_OB = self._pose(heard.stamp)
        p_BS = p_BA + source.range_m * v_B if math.isfinite(source.range_m) else None
        azimuth, elevation = _direction(v_B)
        x, y, z = (None, None, None) if X_OB is None or p_BS is None else _point(X_OB.transform(p_BS))
        return PlacedSound(
            track=source.track,
            stamp=heard.stamp,
            azimuth=azimuth,
            elevation=elevation,
            panorama=self._in_panorama(X_OB, p_BS, v_B),
            range_m=_rounded(source.range_m),
            range_sigma_m=_rounded(source.range_sigma_m),
            x=x,
            y=y,
            z=z,
            p_OA=None if X_OB is None else _point(X_OB.transform(p_BA)),
            v_O=None if X_OB is None else _point(X_OB.rotation @ v_B),
            power=round(source.power, 3),
            level_db=round(source.level_db, 2),
            active=active,
            last_active=heard.last_active,
            speech=_rounded(source.speech),
        )

    def _in_panorama(
        self, X_OB: Pose3 | None, p_B: FloatArray | None, v_B: FloatArray | None = None
    ) -> Direction | None:
        """Where in the newest panorama the point ``p_B`` is, or a direction ``v_B`` without a range.

        ``X_OB``: the base at the percept's stamp. The robot may have turned since; without its pose at either instant
        it is taken to stand.
        """
        if self._panorama is None:
            return None
        stamp, X_BC = self._panorama
        X_OP = self._pose(stamp)
        X_PB = Pose3.identity() if X_OB is None or X_OP is None else X_OP.inverse() @ X_OB
        if p_B is not None:
            return _direction(X_PB.transform(p_B) - X_BC.translation)
        assert v_B is not None
        return _direction(X_PB.rotation @ v_B)

    def _pose(self, stamp: float) -> Pose3 | None:
        X_OB = self._placed.get(stamp)
        if X_OB is None and (pose := self._poses.at(stamp)) is not None:
            X_OB = self._placed[stamp] = pose.to_pose3()
            if len(self._placed) > _MOST_POSES:
                del self._placed[next(iter(self._placed))]
        self.unplaced |= X_OB is None
        return X_OB


class PerceptPlacer(Module):
    title = "Percepts placed"

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._percepts = Percepts()
        self._published: PlacedPercepts | None = None
        self.percepts = self.output("percepts", PlacedPercepts)
        self.on(self.input("faces", Faces, capacity=BURST, wants="if_wanted"), self._take)
        self.on(self.input("codes", QRCodes, capacity=BURST, wants="if_wanted"), self._take)
        self.on(self.input("sounds", SoundSources, capacity=BURST, wants="if_wanted"), self._take)
        self.on(self.input("noises", LoudNoise, capacity=BURST, wants="if_wanted"), self._take)
        self.on(self.input("panorama", EncodedImage, wants="never"), self._percepts.take)
        self.on(
            self.input("odometry", Odometry, capacity=BURST, always_open=True, wants="if_wanted"), self._take_odometry
        )
        self.every(PERIOD_S, self._publish)

    async def _take(self, message: Faces | QRCodes | SoundSources | LoudNoise) -> None:
        self._percepts.take(message)
        await self._publish()

    async def _take_odometry(self, odometry: Odometry) -> None:
        self._percepts.take(odometry)
        if self._percepts.unplaced:
            await self._publish()

    async def _publish(self) -> None:
        percepts = self._percepts.at(self.clock.now())
        if self._published is None or _content(percepts) != _content(self._published):
            self._published = percepts
            self.percepts.publish(percepts)


def _content(percepts: PlacedPercepts) -> tuple[object, ...]:
    """The members in which two of them differ."""
    codes = tuple((code.text, code.camera, code.stamp) for code in percepts.codes)
    return percepts.faces, percepts.sounds, percepts.noises, codes


def _code(of: QRCodes, code: QRCode) -> PlacedCode:
    corners = np.asarray(code.corners, np.float64).round(1)
    return PlacedCode(code.text, of.frame, of.stamp, read_only(corners), (of.width, of.height))


def _direction(v_B: FloatArray) -> Direction:
    x, y, z = (float(value) for value in v_B)
    return round(math.atan2(y, x), 4), round(math.atan2(z, math.hypot(x, y)), 4)


def _point(p: FloatArray) -> Point:
    return round(float(p[0]), 4), round(float(p[1]), 4), round(float(p[2]), 4)


def _rounded(value: float) -> float | None:
    """To a tenth of a millimetre or of a milliradian; None for what is not known."""
    return round(value, 4) if math.isfinite(value) else None

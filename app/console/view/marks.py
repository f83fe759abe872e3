"""From people as perceived, and forces as felt, to what is drawn of them: arrows, frames, a flash. Pure functions.

Everything is rounded to what an eye can see, so that what has not changed for the eye is not sent again.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from app.messages import ExternalForce, ExternalForces, PlacedFace, PlacedPercepts, PlacedSound

MOST_ARROWS = 4
MOST_FORCES = 4
MOST_FACES = 8
#: An arrow is gone so long (s) after its sound fell silent, a flash so long after its noise.
FADE_S = 1.5
FLASH_S = 0.7
#: Probability from which a sound is shown as a voice.
VOICE = 0.5

RED = (235, 45, 40)
ORANGE = (240, 150, 40)
GREY = (150, 156, 168)
VIOLET = (170, 90, 240)

#: Levels (dB of full scale) and lengths (m) of the shortest and the longest arrow.
_LEVELS_DB = (-65.0, -15.0)
_LENGTHS_M = (0.35, 1.6)
#: Length (m) of the arrow of a force: of none, of each newton more, and at most.
_FORCE_M = (0.10, 0.02, 1.0)
_OPACITY = 0.9
#: A distance is shown if its uncertainty is below this share of it.
_KNOWN = 0.5

Color = tuple[int, int, int]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Arrow:
    """From ``position`` (m in O) along x of ``wxyz`` to its ``head``, ``length`` m away; ``text`` is shown there."""

    position: Vector
    wxyz: Quaternion
    length: float
    head: Vector
    color: Color
    opacity: float
    text: str


@dataclass(frozen=True, slots=True)
class FaceFrame:
    """A frame around a face at ``position`` (m in O), x of ``wxyz`` towards the robot; ``text`` is shown above it."""

    position: Vector
    wxyz: Quaternion
    text: str


@dataclass(frozen=True, slots=True)
class Flash:
    """A ring around the robot, ``scale`` times its first size."""

    scale: float
    opacity: float


def arrow_marks(perceived: PlacedPercepts) -> dict[int, Arrow]:
    """By track, the sounds to draw: those that sound, then those that did last; of them the strongest."""
    placed = [sound for sound in perceived.sounds if _opacity(sound, perceived.stamp) > 0 and sound.v_O is not None]
    placed.sort(key=lambda sound: (sound.active, sound.last_active, sound.power), reverse=True)
    return {sound.track: _arrow(sound, perceived.stamp) for sound in placed[:MOST_ARROWS]}


def _opacity(sound: PlacedSound, now: float) -> float:
    silent_s = 0.0 if sound.active else now - sound.last_active
    return max(0.0, round(_OPACITY * (1.0 - silent_s / FADE_S), 1))


def _arrow(sound: PlacedSound, now: float) -> Arrow:
    assert sound.v_O is not None
    assert sound.p_OA is not None
    if sound.speech is None:
        color, what = GREY, "sound"
    else:
        color, what = (RED, "voice") if sound.speech >= VOICE else (ORANGE, "sound")
    loud = (sound.level_db - _LEVELS_DB[0]) / (_LEVELS_DB[1] - _LEVELS_DB[0])
    length = _LENGTHS_M[0] + min(max(loud, 0.0), 1.0) * (_LENGTHS_M[1] - _LENGTHS_M[0])
    range_m, sigma_m = sound.range_m, sound.range_sigma_m
    known = range_m is not None and sigma_m is not None and sigma_m <= _KNOWN * range_m
    length = round(length, 1)
    x, y, z = sound.v_O
    a, b, c = sound.p_OA
    return Arrow(
        _rounded(sound.p_OA),
        _turned(math.atan2(y, x), math.atan2(z, math.hypot(x, y))),
        length=length,
        head=_rounded((a + length * x, b + length * y, c + length * z)),
        color=color,
        opacity=_opacity(sound, now),
        text=f"{what} · {range_m:.1f} m" if known else what,
    )


def face_marks(perceived: PlacedPercepts) -> dict[int, FaceFrame]:
    """By track, the faces to draw: each once, as the camera saw it that knows its distance best; the nearest first."""
    best: dict[int, PlacedFace] = {}
    for face in perceived.faces:
        if None in (face.x, face.y, face.z):
            continue
        before = best.get(face.track)
        if before is None or _known(face.range_sigma_m) < _known(before.range_sigma_m):
            best[face.track] = face
    nearest = sorted(best.values(), key=lambda face: _known(face.range_m))[:MOST_FACES]
    return {face.track: _face_frame(face) for face in nearest}


def _known(value: float | None) -> float:
    return math.inf if value is None else value


def _face_frame(face: PlacedFace) -> FaceFrame:
    assert face.x is not None
    assert face.y is not None
    assert face.z is not None
    yaw = 0.0 if face.towards_O is None else face.towards_O
    text = f"Person {face.track}" if face.range_m is None else f"Person {face.track} · {face.range_m:.1f} m"
    return FaceFrame(_rounded((face.x, face.y, face.z)), _turned(yaw, 0.0), text)


def flash_mark(perceived: PlacedPercepts) -> Flash | None:
    """The flash of the last noise, if it is not over."""
    if not perceived.noises:
        return None
    share = (perceived.stamp - perceived.noises[-1].stamp) / FLASH_S
    if share >= 1.0:
        return None
    share = max(share, 0.0)
    return Flash(round(1.0 + share, 1), max(round(_OPACITY * (1.0 - share), 1), 0.1))


def force_marks(felt: ExternalForces | None) -> dict[int, Arrow]:
    """The forces to draw, in ``base_link``: an arrow each, from where the body is pushed, the way that it is pushed."""
    forces = () if felt is None else felt.forces[:MOST_FORCES]
    return {number: _force(force) for number, force in enumerate(forces)}


def _force(force: ExternalForce) -> Arrow:
    x, y, z = force.f_B
    newtons = math.hypot(x, y, z)
    none, each, most = _FORCE_M
    length = round(min(none + each * newtons, most), 1)
    share = length / max(newtons, 1e-9)
    a, b, c = force.p_B
    return Arrow(
        _rounded(force.p_B),
        _turned(math.atan2(y, x), math.atan2(z, math.hypot(x, y))),
        length=length,
        head=_rounded((a + share * x, b + share * y, c + share * z)),
        color=VIOLET,
        opacity=_OPACITY,
        text=f"{newtons:.0f} N",
    )


def _turned(yaw: float, pitch_up: float) -> Quaternion:
    """The rotation that turns x by ``yaw`` to the left and then ``pitch_up`` (rad), (w, x, y, z)."""
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    cp, sp = math.cos(0.5 * pitch_up), math.sin(-0.5 * pitch_up)
    w, x, y, z = cy * cp, -sy * sp, cy * sp, sy * cp
    return (round(w, 3), round(x, 3), round(y, 3), round(z, 3))


def _rounded(p: Vector) -> Vector:
    return (round(p[0], 2), round(p[1], 2), round(p[2], 2))


def assigned(before: dict[int, int], tracks: Collection[int], places: int) -> dict[int, int]:
    """Which of ``places`` numbered places each of ``tracks`` has: the one it had ``before``, else a free one.

    There are at most as many tracks as places.
    """
    kept = {track: place for track, place in before.items() if track in tracks}
    free = iter(sorted(set(range(places)) - set(kept.values())))
    return kept | {track: next(free) for track in tracks if track not in kept}

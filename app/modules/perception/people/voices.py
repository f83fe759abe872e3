"""Binding of voices to persons by direction: a voice has none but its direction, and several may stand there.

Each candidate has a likelihood by its angle from the voice, with the errors of the voice's direction and of the
candidate's own place, and a prior: who looks at the robot is more likely to speak than who looks away, and legs that
may be a chair's less. Somebody unseen is a candidate, too, in every direction alike. A direction errs for a whole
sentence alike, so likelihoods are averaged over the sentence and not summed. A voice is of the candidate with most of
the probability, and of none while no candidate has it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import wrap_angle

Vector = NDArray[np.float64]

#: Scale (rad) and degrees of freedom of a voice's error, a t distribution: some directions are those of an echo.
_VOICE_RAD, _FREEDOM = math.radians(1.3), 3.0
#: Logarithm of the distribution's constant.
_LOG_T = math.lgamma((_FREEDOM + 1) / 2) - math.lgamma(_FREEDOM / 2) - 0.5 * math.log(_FREEDOM * math.pi)
#: Priors: of a person, factor of one whose face is seen, of legs not believed to be a person's, of somebody unseen.
_FACE, _LEGS, _UNSEEN = 3.0, 0.3, 2.0
#: Probability from which a voice is a candidate's, and from which it stays.
_BOUND, _STAYS = 0.65, 0.4
#: Time constant (s) of the mean of likelihoods, and how long a voice that is not heard is kept.
_MEAN_S, KEPT_S = 1.5, 5.0


@dataclass(frozen=True, slots=True)
class VoiceHeard:
    """A voice that sounds: its track, and its ``azimuth`` (rad, in ``odom``) from the microphones."""

    track: int
    azimuth: float


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """Who may speak: ``at`` (2,) m in ``odom``, with ``covariance`` (2, 2) m²."""

    number: int
    at: Vector
    covariance: Vector
    #: Whether it is believed to be a person, and whether the face is seen.
    believed: bool = True
    faces: bool = False

    @property
    def prior(self) -> float:
        """Weight among the candidates."""
        return (1.0 if self.believed else _LEGS) * (_FACE if self.faces else 1.0)


@dataclass(slots=True)
class _Voice:
    #: When it was heard first and last, and whose it is.
    began: float
    heard: float
    of: int | None = None
    #: Mean log likelihood by candidate.
    means: dict[int, float] = field(default_factory=dict)


class Voices:
    """Voices of the last seconds, and whose they are."""

    def __init__(self) -> None:
        self._voices: dict[int, _Voice] = {}

    def hear(
        self, stamp: float, p_OA: Vector, voices: Sequence[VoiceHeard], candidates: Sequence[Candidate]
    ) -> dict[int, int]:
        """Numbers of ``candidates`` by the tracks of ``voices`` heard at ``p_OA`` (2,) m, without those of none."""
        found = {}
        for voice in sorted(voices, key=lambda v: v.track):
            held = self._voices.setdefault(voice.track, _Voice(stamp, stamp))
            weight = 1 - math.exp(-max(stamp - held.heard, 0.0) / _MEAN_S)
            held.heard = stamp
            now = {c.number: _log_likelihood(voice, p_OA, c) for c in candidates}
            # Who appears within a sentence is judged by the voice from then on.
            held.means = {
                number: value + (1 - weight) * (held.means.get(number, value) - value) for number, value in now.items()
            }
            held.of = _most_probable(held, candidates)
            if held.of is not None:
                found[voice.track] = held.of
        self._voices = {track: held for track, held in self._voices.items() if stamp - held.heard < KEPT_S}
        return found

    def heard_s(self, voice: int) -> float:
        """For how long (s) ``voice`` has been heard."""
        held = self._voices[voice]
        return held.heard - held.began


def _log_likelihood(voice: VoiceHeard, p_OA: Vector, candidate: Candidate) -> float:
    dx, dy = (candidate.at - p_OA).tolist()
    away = max(math.hypot(dx, dy), 0.3)
    aside = np.array((-dy, dx)) / away
    variance = _VOICE_RAD**2 + float(aside @ candidate.covariance @ aside) / away**2
    off = wrap_angle(math.atan2(dy, dx) - voice.azimuth)
    tail = 0.5 * (_FREEDOM + 1) * math.log1p(off * off / (_FREEDOM * variance))
    return _LOG_T - 0.5 * math.log(variance) - tail


def _most_probable(voice: _Voice, candidates: Sequence[Candidate]) -> int | None:
    if not candidates:
        return None
    weights = {c.number: c.prior * math.exp(voice.means[c.number]) for c in candidates}
    total = sum(weights.values()) + _UNSEEN / (2 * math.pi)
    if voice.of is not None and weights.get(voice.of, 0.0) >= _STAYS * total:
        return voice.of
    best = max(sorted(weights), key=lambda number: weights[number])
    return best if weights[best] >= _BOUND * total else None

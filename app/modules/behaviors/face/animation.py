"""The face from moment to moment: blends expressions, blinks, reacts, and moves no joint faster than it can.

Given the same seed and the same moments, poses are the same.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from random import Random

from app.link import JointLimits
from app.modules.behaviors.face.expression import (
    CALM,
    EXPRESSIONS,
    Expression,
    FacePose,
    approach,
    expressed,
    reaction,
    with_blink,
    with_gaze,
    with_mouth,
)

BLINK_S = 0.15
_BLINK_EVERY_S = (2.0, 6.0)
_LID_S = 0.04
"""The eyelids' way down, and up, within a blink."""
_BLEND_S = 0.6
"""An expression comes, or goes, wholly within this."""
FORGOTTEN_S = 2.0


@dataclass(frozen=True, slots=True)
class FaceState:
    """What the face is to show at ``time`` (s): ``weights`` of expressions; ``gaze`` (pan, tilt) rad from straight
    ahead, None for that of the expressions; the ``viseme`` that is said, None in silence; when something was
    ``detected`` last, None for never."""

    time: float
    weights: Mapping[Expression, float]
    gaze: tuple[float, float] | None = None
    viseme: str | None = None
    detected: float | None = None


class Blinking:
    """Closes the eyes for ``BLINK_S`` at random intervals, by a generator of ``seed``."""

    def __init__(self, seed: int) -> None:
        self._random = Random(seed)
        self._begins: float | None = None

    def closed(self, time: float) -> float:
        """How far the eyelids are closed at ``time`` (s, not falling), 0 to 1."""
        if self._begins is None or time > self._begins + BLINK_S + _BLINK_EVERY_S[1]:
            self._begins = time + self._random.uniform(*_BLINK_EVERY_S)
        elif time > self._begins + BLINK_S:
            self._begins += self._random.uniform(*_BLINK_EVERY_S)
        into = time - self._begins
        return max(0.0, min(into / _LID_S, (BLINK_S - into) / _LID_S, 1.0))


class FaceAnimation:
    """Poses of a face with joints of ``limits``, in the order of ``expression.JOINTS``."""

    def __init__(self, limits: Sequence[JointLimits], seed: int) -> None:
        self._limits = limits
        self._blinking = Blinking(seed)
        self._weights = dict.fromkeys(EXPRESSIONS, 0.0)
        self._time: float | None = None
        self.pose: FacePose = approach(CALM, CALM, limits, 0.0)

    def step(self, state: FaceState) -> FacePose:
        """The pose (9,) rad at ``state.time``, not earlier than the last one's."""
        elapsed_s = 0.0 if self._time is None else state.time - self._time
        self._time = state.time
        for name in EXPRESSIONS:
            change = state.weights.get(name, 0.0) - self._weights[name]
            self._weights[name] += max(-elapsed_s / _BLEND_S, min(elapsed_s / _BLEND_S, change))
        goal = expressed(self._weights, state.time)
        if state.detected is not None:
            goal = goal + reaction(state.time - state.detected)
        if state.viseme is not None:
            goal = with_mouth(goal, state.viseme)
        if state.gaze is not None:
            goal = with_gaze(goal, *state.gaze)
        goal = with_blink(goal, self._blinking.closed(state.time))
        self.pose = approach(self.pose, goal, self._limits, elapsed_s)
        return self.pose


class Novelty:
    """What is new among what is seen: known is what was seen within the last ``FORGOTTEN_S``."""

    def __init__(self) -> None:
        self._seen: dict[Hashable, float] = {}

    def any_new(self, seen: Iterable[Hashable], time: float) -> bool:
        """Whether any of ``seen`` at ``time`` (s) is new."""
        self._seen = {key: last for key, last in self._seen.items() if time - last <= FORGOTTEN_S}
        news = False
        for key in seen:
            news = news or key not in self._seen
            self._seen[key] = time
        return news

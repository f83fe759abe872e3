"""What TrackFace, TrackCode and TrackSound share: percepts placed at their own instant, one of them looked at."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import deque
from typing import Generic, TypeVar

import numpy as np
from pydantic import Field

from app.base.geometry import Pose3
from app.messages import Faces, QRCodes, SoundSources
from app.modules.behaviors.gaze.gaze_behavior import G, GazeBehavior, GazeSettings, Look
from app.modules.behaviors.gaze.target_choice import Candidate, ChoiceRules, TargetChoice
from app.runtime.module import Input, ModuleContext

P = TypeVar("P", Faces, QRCodes, SoundSources)

#: Percepts wait so long (s) for odometry to reach their stamp.
_PATIENCE_S = 1.0


class TrackSettings(GazeSettings):
    """Settings of every behavior that tracks a percept."""

    keep_s: float = Field(2.0, ge=0, le=60, description="an unseen percept stays the one that is tracked so long")
    give_up_s: float = Field(10.0, gt=0, le=600, description="without any for so long, the head is left to others")
    smoothing_s: float = Field(0.15, ge=0, le=5, description="time constant of places; 0: none")


class TrackPercept(GazeBehavior[G], Generic[G, P]):
    """Looks at one of the percepts of messages of one type."""

    Settings = TrackSettings
    settings: TrackSettings

    def __init__(self, context: ModuleContext, port: str, message_type: type[P]) -> None:
        super().__init__(context)
        self.percepts: Input[P] = self.input(port, message_type, capacity=8, wants="if_wanted")
        self.on(self.percepts, self._take_percepts)
        self._waiting: deque[P] = deque(maxlen=32)
        self._choice: TargetChoice | None = None

    @abstractmethod
    def begin(self, now: float) -> TargetChoice | None:
        """What the desire asks for; None without a desire."""

    @abstractmethod
    def candidates(self, percepts: P, X_OB: Pose3) -> list[Candidate]:
        """The percepts of a message, with the robot's pose at its stamp."""

    def rules(self, *, margin: float = math.inf) -> ChoiceRules:
        """The rules of choice that the settings give."""
        s = self.settings
        return ChoiceRules(s.keep_s, s.give_up_s, margin, s.smoothing_s)

    def rest(self) -> None:
        """The next track begins with the percepts of its time."""
        self._choice = None
        self._waiting.clear()

    def look(self, now: float) -> Look:
        """The percept that is tracked, where the robot is now; where it was last, while it is not perceived."""
        if self._choice is None:
            self._choice = self.begin(now)
        choice = self._choice
        if choice is None:
            return Look(None)
        self._place(choice, now)
        if problem := choice.problem(now):
            return Look(None, problem, outcome="failed")
        if choice.target is None or self.X_OB is None:
            return Look(None, f"it waits: {choice.what} is not perceived yet")
        return Look(np.asarray(self.X_OB.to_pose3().inverse().transform(choice.target.p_OP)))

    async def _take_percepts(self, percepts: P) -> None:
        self._waiting.append(percepts)

    def _place(self, choice: TargetChoice, now: float) -> None:
        """Place those that wait, once odometry has reached their stamp."""
        later = []
        for percepts in sorted(self._waiting, key=lambda each: each.stamp):
            X_OB = self.poses.at(percepts.stamp)
            if X_OB is not None:
                choice.see(percepts.stamp, self.candidates(percepts, X_OB.to_pose3()))
            elif now - percepts.stamp < _PATIENCE_S:
                later.append(percepts)
        self._waiting.clear()
        self._waiting.extend(later)

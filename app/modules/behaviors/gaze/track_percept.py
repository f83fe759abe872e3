"""What TrackFace, TrackCode and TrackSound share: one of the percepts of a channel is looked at."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Generic

from pydantic import Field

from app.base.geometry import Pose3
from app.modules.behaviors.gaze.gaze_behavior import G, GazeBehavior, GazeSettings, Look
from app.modules.behaviors.gaze.percept_follower import P, PerceptFollower
from app.modules.behaviors.gaze.target_choice import Candidate, ChoiceRules, TargetChoice
from app.runtime.module import Input, ModuleContext


class TrackSettings(GazeSettings):
    """Settings of every behavior that tracks a percept."""

    keep_s: float = Field(2.0, ge=0, le=60, description="an unseen percept stays the one that is tracked so long")
    give_up_s: float = Field(10.0, gt=0, le=600, description="without any for so long, the head is left to others")
    smoothing_s: float = Field(0.15, ge=0, le=5, description="time constant of places; 0: none")

    def rules(self, *, margin: float = math.inf) -> ChoiceRules:
        """The rules of choice; ``margin`` of rank, by which another percept must be better."""
        return ChoiceRules(self.keep_s, self.give_up_s, margin, self.smoothing_s)


class TrackPercept(GazeBehavior[G], Generic[G, P]):
    """Looks at one of the percepts of messages of one type."""

    Settings = TrackSettings
    settings: TrackSettings

    def __init__(self, context: ModuleContext, port: str, message_type: type[P]) -> None:
        super().__init__(context)
        self.percepts: Input[P] = self.input(port, message_type, capacity=8, wants="if_wanted")
        self._follower: PerceptFollower[P] = PerceptFollower(self.poses, self.candidates)
        self.on(self.percepts, self._follower.take)

    @abstractmethod
    def begin(self, given: G, now: float) -> TargetChoice:
        """What the desire ``given`` asks for."""

    @abstractmethod
    def candidates(self, percepts: P, X_OB: Pose3) -> list[Candidate]:
        """The percepts of a message, with the robot's pose at its stamp."""

    def rest(self) -> None:
        """The next track begins with the percepts of its time."""
        self._follower.rest()

    def look(self, now: float) -> Look:
        """The percept that is tracked; none without a desire."""
        given = self.given
        if given is None:
            return Look(None)
        return self._follower.look(now, self.X_OB, lambda: self.begin(given, now))

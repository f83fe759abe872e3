"""Settings of EpisodicMemory."""

from __future__ import annotations

from pydantic import Field

from app.attention.desires import SCALE
from app.runtime.module import Settings


class EpisodicMemorySettings(Settings):
    """How much is remembered, and how far it may go."""

    enabled: bool = Field(False, description="whether anything is remembered; off, the file of earlier is deleted")
    kept_days: float = Field(90.0, gt=0, description="an episode that has not happened for so long is forgotten")
    most_episodes: int = Field(200, ge=1, le=5000, description="so many are kept; those that happened least go first")
    most_events: int = Field(2000, ge=10, le=50_000, description="so many events of them")
    near_m: float = Field(2.0, gt=0, description="this near to a place the robot is at it")
    person_m: float = Field(4.0, gt=0, description="persons farther away do not count")
    settle_s: float = Field(1.0, gt=0, description="what there is counts once it has been the same for so long")
    silence_s: float = Field(1.0, gt=0, description="an episode ends once nothing has been there for so long")
    identity: float = Field(
        0.1,
        ge=0,
        le=1,
        description="activation of a person's number beside that of someone; from 0.2 on, another person is another "
        "event; 0: no number is kept",
    )
    habit: float = Field(
        0.25,
        ge=0,
        le=1,
        description="of episodes that fit, that one is recognized whose match times its number of times "
        "to this power is greatest; 0: the one that fits best",
    )
    objects: tuple[str, ...] = Field(("code",), description="kinds of percept events that are objects")
    people: tuple[str, ...] = Field(("face",), description="kinds of percept events that mean that someone is there")
    acts: tuple[str, ...] | None = Field(
        ("GoTo", "Say", "Ask", "Follow", "Dock", "PointAt", "Wave", "Reach", "Hold", "Release"),
        description="desire classes that make events when they are exploited; null: all",
    )
    raises: tuple[str, ...] = Field(
        ("ListenForWords", "LocateFaces", "LocateVoices", "TrackPersons", "FindQRCodes", "DetectNoises"),
        description="desire classes that it may desire; the usual ones perceive, and move nothing",
    )
    most: float = Field(2.0, gt=0, le=SCALE, description="greatest intensity of what none else desires")
    boost: float = Field(1.0, ge=0, le=SCALE, description="greatest rise of what others desire, too")
    least: float = Field(0.3, gt=0, le=1, description="share of accomplishments from which a desire is raised")
    most_desires: int = Field(4, ge=1, le=20, description="so many at one time")

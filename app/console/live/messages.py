"""The schemas of the messages that the robot sends over the live stream, for its AsyncAPI description;
docs/live-stream.md explains them in words.

Data that REST serves too has REST's schemas. :mod:`app.console.live.protocol` declares the messages of pages.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from app.console.rest.map_models import NavigationModel, ZoneModel
from app.console.rest.models import (
    Answer,
    DesireClassModel,
    DesireList,
    Divisor,
    EventList,
    IntentionModel,
    ScaleModel,
    Stamp,
)
from app.console.rest.percepts import PerceptsModel
from app.console.rest.playback_models import PlaybackModel
from app.console.rest.program_models import GuardModel, LandmarkModel, ModuleModel, OdometryModel
from app.console.rest.recording_models import RecorderModel
from app.runtime.freshness import FreshnessState

Sequence = Annotated[int, Field(ge=0, description="Grows.")]
LaneState = Literal["fulfilled", "degraded", "unfulfilled", "inhibited", "undesired", "needed"]


class LimitsOfBase(Answer):
    """What `linear` and `angular` of 1 in `drive` are, and how fast that may change."""

    linear_mps: float
    angular_radps: float
    linear_mps2: float
    angular_radps2: float


class CautionModel(Answer):
    """What people must know of how the program is configured, such as a collision monitor that is off."""

    title: str = Field(description="In a few words.")
    text: str = Field(description="In a sentence.")
    where: str = Field(description="File and line.")


class RobotFacts(Answer):
    """What the body is, and what people must know of it."""

    name: str
    simulated: bool
    replayed: bool = Field(description="Whether it is the body of a replay.")
    limits: LimitsOfBase
    footprint: list[tuple[float, float]] = Field(
        description="Corners of its outline (m, in base_link), counter-clockwise; empty for one that does not move."
    )
    cautions: list[CautionModel]


class Comes(Answer):
    """Whether there are such pictures, scans and clouds."""

    camera: bool
    panorama: bool
    map: bool
    costmap: bool
    scan: bool
    point_cloud: bool


class AudioFacts(Answer):
    """Whether the robot can be listened to, and be spoken through."""

    listen: bool
    speak: bool


class Hello(Answer):
    """Once, first: what can be seen and done here."""

    protocol: Literal[1]
    session: str = Field(description="Id of this connection.")
    stamp: Stamp
    robot: RobotFacts
    scale: ScaleModel
    classes: list[DesireClassModel]
    channels: Comes
    drive: bool = Field(description="Whether an operator can drive here.")
    audio: AudioFacts
    playback: PlaybackModel | None = Field(description="null: not a recording.")


class SpeakerModel(Answer):
    """Who speaks through the robot."""

    operator: str
    mine: bool = Field(description="Whether it is this page's operator.")


class DriverModel(SpeakerModel):
    """Who has the wheel."""

    holds: bool = Field(description="Whether they hold a drive command just now.")


class SourceState(Answer):
    """How fresh a channel is, measured beside commanded."""

    channel: str
    state: FreshnessState
    age_ms: float | None
    rate_hz: float | None
    expected_hz: float | None


class Status(Answer):
    """20 times a second: guard, pose, driver, freshness of every source."""

    seq: Sequence
    stamp: Stamp
    guard: GuardModel
    world_rate: float
    odometry: OdometryModel | None
    driver: DriverModel | None
    speaker: SpeakerModel | None
    exploited: str | None = Field(description="The behavior that drives.")
    limited: str = Field(description="Why the collision monitor slowed or stopped it, in words.")
    waits: str = Field(description="Why this viewer's driving waits, its commands coming too late; empty: it does not.")
    sources: list[SourceState]


class LaneValues(Answer):
    """A desire class: how much it is desired, what attention gives it, and why."""

    intensity: float | None
    utility: float | None
    divisor: Divisor
    divisors: dict[str, Divisor] = Field(description="By filter, `Module.port`.")
    state: LaneState
    text: str


class LaneRow(LaneValues):
    """A lane now."""

    cls: str = Field(alias="class")
    rate: float | None = Field(description="Messages let through over messages offered, in the last second.")


class Lanes(Answer):
    """20 times a second: one row for each desire class."""

    seq: Sequence
    stamp: Stamp
    rows: list[LaneRow]


class LaneSpell(LaneValues):
    """What a lane was, from one sample until the next spell's."""

    at: int = Field(ge=0, description="Number of the sample.")


class LanePast(Answer):
    """A lane before now."""

    cls: str = Field(alias="class")
    rate: list[float | None] = Field(description="One for each stamp.")
    spells: list[LaneSpell]


class LanesHistory(Answer):
    """Once, before the first `lanes`, and after a `jump`: what they were."""

    stamps: list[float]
    rows: list[LanePast]


class CurrentIntention(Answer):
    """What attention chose; null before the first."""

    intention: IntentionModel | None


class Load(Answer):
    """Once a second: what the modules take of the computer."""

    stamp: Stamp
    process_cpu: float = Field(description="Per cent of one core.")
    budget: float | None = Field(description="Per cent that attention may give; null: no limit.")
    modules: list[ModuleModel]


class Landmarks(Answer):
    """On change: what was found, in `odom`."""

    landmarks: list[LandmarkModel]


class Place(Answer):
    """A pose: m and rad."""

    x: float
    y: float
    theta: float


class Localization(Place):
    """Where the robot is on the map."""

    stamp: Stamp
    state: Literal["mapping", "tracking", "searching", "lost"]
    map: str = Field(description="Name of the map in use; empty while it has none.")
    sigma: tuple[float, float, float] = Field(description="Standard deviations of x, y (m) and theta (rad).")
    X_MO: Place = Field(description="Pose of `odom` on the map.")
    overlap: float = Field(description="Share of the scan that fits the map, 0 to 1.")


class Zones(Answer):
    """On change: the zones of the map."""

    zones: list[ZoneModel]


class GridInfo(Answer):
    """What the picture that follows, of the same `seq`, shows."""

    seq: Sequence
    stamp: Stamp
    frame: Literal["map", "odom"]
    version: int
    resolution_m: float = Field(description="Of a pixel.")
    origin: tuple[float, float] = Field(description="x, y of the picture's lower left corner.")
    width: int
    height: int


class Pong(Answer):
    """The answer to `ping`."""

    t: float = Field(description="As it was sent.")
    stamp: Stamp


class Notice(Answer):
    """Something for this viewer, in words to show."""

    level: Literal["info", "warning", "error"]
    text: str


class Jump(Answer):
    """On a recording, at a seek: what came before is of another time and to be forgotten."""

    stamp: Stamp


class Message(NamedTuple):
    """A message from the robot: its record, and when and why it is sent."""

    record: type[Any]
    about: str


#: By ``type``, which goes before the record's members.
FROM_ROBOT: dict[str, Message] = {
    "hello": Message(Hello, "Once, first: what can be seen and done here."),
    "status": Message(Status, "20 times a second: guard, pose, driver, freshness of every source."),
    "lanes": Message(Lanes, "20 times a second: one row for each desire class."),
    "lanes_history": Message(LanesHistory, "Once, before the first `lanes`, and after a `jump`: what they were."),
    "desires": Message(DesireList, "On change: every desire."),
    "intention": Message(CurrentIntention, "On change: what attention chose; null before the first."),
    "events": Message(EventList, "As they come: events, oldest first."),
    "load": Message(Load, "Once a second: what the modules take of the computer."),
    "recorder": Message(RecorderModel, "On change, and about once a second while it records: what the Recorder does."),
    "landmarks": Message(Landmarks, "On change: what was found, in `odom`."),
    "perceived": Message(PerceptsModel, "On change: what the robot sees and hears."),
    "localization": Message(Localization, "Up to 10 times a second: where the robot is on the map."),
    "navigation": Message(NavigationModel, "On change: the goal and the state of navigation."),
    "zones": Message(Zones, "On change: the zones of the map."),
    "map_info": Message(GridInfo, "Right before each picture of kind 3 (map): what it shows."),
    "costmap_info": Message(GridInfo, "Right before each picture of kind 4 (costmap): what it shows."),
    "pong": Message(Pong, "The answer to `ping`."),
    "notice": Message(Notice, "Something for this viewer, in words to show."),
    "playback": Message(
        PlaybackModel, "On a recording, at every change and ten times a second while it plays: its transport."
    ),
    "jump": Message(Jump, "On a recording, at a seek: what came before is of another time and to be forgotten."),
}

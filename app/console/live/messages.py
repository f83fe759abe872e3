"""The records of the messages that the robot sends over the live stream; docs/live-stream.md explains them in words.

:mod:`app.console.live.protocol` declares the messages of pages.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

from msgspec import Meta, Struct

from app.console.records.attention import EventList
from app.console.records.link import LinkReport
from app.console.records.maps import LocalizationState, ZoneList
from app.console.records.navigation import NavigationModel
from app.console.records.places import PlaceList
from app.console.records.program import RoleName, SourceState
from app.console.records.recordings import PlaybackReport, RecorderReport
from app.console.records.robot import GroupReport, Guard, LandmarkReport, OdometryReport, RobotFacts
from app.messages import (
    BatteryState,
    DesireClassReport,
    Desires,
    Divisor,
    EmotionState,
    HeardWords,
    IntentionReport,
    Lanes,
    LaneState,
    LoadReport,
    MemoryState,
    Persons,
    PlacedPercepts,
    RulesReport,
    SaliencyMap,
    SalientRegions,
    Scale,
    ShownMedia,
    Speech,
    TourProgress,
    TourQuestion,
    TourState,
)
from app.messages.base import Stamp, doc

Sequence = Annotated[int, doc("Grows.")]
Level = Literal["info", "warning", "error"]


@dataclass(frozen=True, slots=True)
class Channels:
    """Whether there are such pictures, scans and clouds."""

    camera: bool
    panorama: bool
    map: bool
    costmap: bool
    scan: bool
    point_cloud: bool


@dataclass(frozen=True, slots=True)
class AudioFacts:
    """Whether the robot has microphones to listen to, and a loudspeaker to speak through."""

    listen: bool
    speak: bool


@dataclass(frozen=True, slots=True)
class Hello:
    """What can be seen and done here."""

    protocol: Literal[1]
    session: Annotated[str, doc("Id of this connection.")]
    stamp: Stamp
    robot: RobotFacts
    scale: Scale
    classes: tuple[DesireClassReport, ...]
    channels: Channels
    role: Annotated[RoleName, doc("What this connection may do.")]
    drive: Annotated[bool, doc("Whether an operator can drive here.")]
    head: Annotated[bool, doc("Whether an operator can turn a head here.")]
    audio: AudioFacts
    vp9: Annotated[bool, doc("Whether the camera's pictures come as VP9 to pages that say they decode it.")]
    playback: Annotated[PlaybackReport | None, doc("null: not a recording.")]


@dataclass(frozen=True, slots=True)
class Speaker:
    """The operator who speaks through the robot."""

    operator: str
    mine: Annotated[bool, doc("Whether it is this page's operator.")]


@dataclass(frozen=True, slots=True)
class Driver:
    """Who has the wheel."""

    operator: str
    mine: Annotated[bool, doc("Whether it is this page's operator.")]
    holds: Annotated[bool, doc("Whether they hold a drive command just now.")]


@dataclass(frozen=True, slots=True)
class Asker:
    """Who asks the driver for the wheel."""

    operator: str
    mine: Annotated[bool, doc("Whether it is this page's operator.")]
    remaining_s: Annotated[float, doc("Until the driver has not answered.")]


@dataclass(frozen=True, slots=True)
class Status:
    """Guard, pose, driver, freshness of every source."""

    seq: Sequence
    stamp: Stamp
    guard: Guard
    world_rate: float
    odometry: OdometryReport | None
    driver: Driver | None
    asker: Asker | None
    speaker: Speaker | None
    exploited: Annotated[str | None, doc("The behavior that drives.")]
    limited: Annotated[str, doc("Why the collision monitor slowed or stopped it, in words; empty: it did not.")]
    groups: Annotated[tuple[GroupReport, ...], doc("The actuator groups but for the base.")]
    waits: Annotated[str, doc("Why this viewer's driving waits, its commands coming too late; empty: it does not.")]
    sources: tuple[SourceState, ...]
    slowed: Annotated[str, doc("Why this viewer drives slower than its stick says; empty: it does not.")] = ""
    share: Annotated[float, doc("The share of the speeds of its stick that this viewer is given for it, 0 to 1.")] = 1.0


class LaneSpell(Struct, frozen=True):
    """What a lane was, from one sample until the next spell's."""

    at: Annotated[int, Meta(ge=0, description="Number of the sample.")]
    intensity: float | None
    utility: float | None
    divisor: Divisor
    divisors: Annotated[Mapping[str, Divisor], doc("By filter, `Module.port`.")]
    state: LaneState
    text: str


class LanePast(Struct, frozen=True, rename={"cls": "class"}):
    """A lane before now."""

    cls: str
    rate: Annotated[tuple[float | None, ...], doc("One for each stamp.")]
    spells: tuple[LaneSpell, ...]


@dataclass(frozen=True, slots=True)
class LanesHistory:
    """Once, before the first `lanes`, and after a `jump`: what they were."""

    stamps: tuple[float, ...]
    rows: tuple[LanePast, ...]


@dataclass(frozen=True, slots=True)
class LandmarkList:
    """What was found, each in its `frame`."""

    landmarks: tuple[LandmarkReport, ...]


@dataclass(frozen=True, slots=True)
class PoseReport:
    """A pose: m and rad."""

    x: float
    y: float
    theta: float


@dataclass(frozen=True, slots=True)
class LocalizationReport:
    """Where the robot is on the map (m and rad)."""

    stamp: Stamp
    state: LocalizationState
    map: Annotated[str, doc("Name of the map in use; empty while it has none.")]
    x: float
    y: float
    theta: float
    sigma: Annotated[tuple[float, float, float], doc("Standard deviations of x, y (m) and theta (rad).")]
    X_MO: Annotated[PoseReport, doc("Pose of `odom` on the map.")]
    overlap: Annotated[float, doc("Share of the scan that fits the map, 0 to 1.")]


@dataclass(frozen=True, slots=True)
class GridInfo:
    """What the picture that follows, of the same `seq`, shows."""

    seq: Sequence
    stamp: Stamp
    frame: Annotated[str, doc("`map` or `odom`.")]
    version: int
    resolution_m: Annotated[float, doc("Of a pixel.")]
    origin: Annotated[tuple[float, float], doc("x, y of the picture's lower left corner.")]
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class FaceReport:
    """The robot's face."""

    stamp: Stamp
    joints: Annotated[Mapping[str, float], doc("Positions (rad) of the actuator group `face`, by joint.")]


@dataclass(frozen=True, slots=True)
class VisitorLink:
    """The way in for phones of visitors."""

    url: Annotated[str, doc("Of the page for visitors, with the key of this run; empty: there is no way in now.")]
    code: Annotated[tuple[str, ...], doc("The same as a QR code: its rows from the top, `1` for each black module.")]
    problem: Annotated[str, doc("Why phones do not get in by it, in words; empty: they do.")]


VisitorButton = Literal["start", "agree", "decline", "next"]


@dataclass(frozen=True, slots=True)
class VisitorView:
    """How the tour goes, for visitors."""

    tour: Annotated[bool, doc("Whether one is led, or waits for visitors.")]
    title: Annotated[Mapping[str, str], doc("By language.")]
    language: Annotated[str, doc("That the robot speaks.")]
    languages: tuple[str, ...]
    state: TourState
    stop_title: Annotated[Mapping[str, str], doc("By language.")]
    number: Annotated[int, doc("Of the stop, from 1; 0: none.")]
    stops: int
    sentences: Annotated[Mapping[str, tuple[str, ...]], doc("Of the text of this step, by language.")]
    sentence: Annotated[int, doc("Which of them is said, in the language that the robot speaks, from 0.")]
    said: Annotated[str, doc("What is said beside the text, in the language that the robot speaks; empty: nothing.")]
    shown: Annotated[ShownMedia | None, doc("A picture or a video: `file` is below `media/`; null: none.")]
    press: Annotated[Mapping[str, str], doc("What the button `next` is called, by language.")]
    questions: Annotated[tuple[TourQuestion, ...], doc("That may be asked now.")]
    buttons: Annotated[tuple[VisitorButton, ...], doc("That the tour waits for.")]


@dataclass(frozen=True, slots=True)
class Pong:
    """The answer to `ping`."""

    t: Annotated[float | None, doc("As it was sent.")]
    stamp: Stamp


@dataclass(frozen=True, slots=True)
class Notice:
    """Something for this viewer, in words to show."""

    level: Level
    text: str


@dataclass(frozen=True, slots=True)
class Jump:
    """Where a recording goes on."""

    stamp: Stamp


class FrameKind(NamedTuple):
    """A message from the robot: its record, and when and why it is sent."""

    record: type[Any]
    about: str


#: By ``type``, which goes before the record's members.
FROM_ROBOT: dict[str, FrameKind] = {
    "hello": FrameKind(Hello, "Once, first: what can be seen and done here."),
    "status": FrameKind(Status, "20 times a second: guard, pose, driver, freshness of every source."),
    "lanes": FrameKind(Lanes, "10 times a second: one row for each desire class."),
    "lanes_history": FrameKind(LanesHistory, "Once, before the first `lanes`, and after a `jump`: what they were."),
    "desires": FrameKind(Desires, "On change: every desire."),
    "intention": FrameKind(IntentionReport, "On change, from the first on: what attention chose."),
    "events": FrameKind(EventList, "As they come: events, oldest first."),
    "load": FrameKind(LoadReport, "Once a second: what the modules take of the computer."),
    "recorder": FrameKind(RecorderReport, "On change, and once a second while it records: the Recorder."),
    "landmarks": FrameKind(LandmarkList, "On change: what was found, each in its `frame`."),
    "perceived": FrameKind(PlacedPercepts, "On change: what the robot sees and hears."),
    "rules": FrameKind(RulesReport, "When a rule applies, and when files of rules change: every rule."),
    "speech": FrameKind(Speech, "On change, up to 20 times a second: what the robot says, for subtitles."),
    "battery": FrameKind(BatteryState, "Once a second, of a body with a battery: its charge."),
    "heard_words": FrameKind(HeardWords, "As they come: an utterance while words are listened for."),
    "salient_regions": FrameKind(SalientRegions, "Five times a second while it is desired: what stands out around."),
    "saliency": FrameKind(SaliencyMap, "With it: how salient all directions are."),
    "persons": FrameKind(Persons, "10 times a second while it is desired: who is around, in `odom`."),
    "localization": FrameKind(LocalizationReport, "Up to 10 times a second: where the robot is on the map."),
    "navigation": FrameKind(NavigationModel, "On change: the goal and the state of navigation."),
    "zones": FrameKind(ZoneList, "On change: the zones of the map."),
    "places": FrameKind(PlaceList, "On change: the places of the map."),
    "tour": FrameKind(TourProgress, "On change: how the guided tour goes."),
    "emotions": FrameKind(EmotionState, "On change, at most once a second: what is felt, and what it comes from."),
    "memory": FrameKind(MemoryState, "On change, up to 4 times a second: what is recognized, expected, remembered."),
    "map_info": FrameKind(GridInfo, "Right before each picture of kind 3 (map): what it shows."),
    "costmap_info": FrameKind(GridInfo, "Right before each picture of kind 4 (costmap): what it shows."),
    "pong": FrameKind(Pong, "The answer to `ping`."),
    "notice": FrameKind(Notice, "Something for this viewer, in words to show."),
    "playback": FrameKind(
        PlaybackReport, "On a recording, at every change and ten times a second while it plays: its transport."
    ),
    "jump": FrameKind(Jump, "On a recording, at a seek: what came before is of another time and to be forgotten."),
    "link": FrameKind(LinkReport, "On change: how the link to the pages is shaped, for tests."),
}

#: The same of the stream for a page that shows the face.
TO_FACE: dict[str, FrameKind] = {
    "face": FrameKind(FaceReport, "30 times a second: where the joints of the face are."),
    "speech": FROM_ROBOT["speech"],
    "visitor_link": FrameKind(VisitorLink, "On change: the way in for visitors while a tour would have them."),
    "pong": FROM_ROBOT["pong"],
}

#: The same of the stream for visitors of a tour.
TO_VISITORS: dict[str, FrameKind] = {
    "visitor": FrameKind(VisitorView, "On change: how the tour goes."),
    "pong": FROM_ROBOT["pong"],
}

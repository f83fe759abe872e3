"""What the program and its clients send each other.

Written by `make types` from the program's own description; change that, not this file.
Stamps are the robot's clock, in seconds of the Unix epoch. Angles are radians, lengths metres.
"""

from __future__ import annotations

from typing import Any, Literal

from msgspec import UNSET, Struct, UnsetType


class Accomplishment(Struct, kw_only=True, frozen=True):
    """A behavior's report that what a desire asks for is done, or that it cannot be done."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    desire_id: str
    behavior: str
    """Name of the module that reports it."""
    outcome: Literal["done", "failed"]
    reason: str
    """In words: what was reached, or why it cannot be; may be empty."""


class Alternative(Struct, kw_only=True, frozen=True):
    """A change that would serve a desire better: more of a resource, or no desire for another class."""

    kind: Literal["capacity", "without"]
    utility: float
    """The utility that the class would get."""
    resource: str
    """Of `capacity`: the resource; else empty."""
    amount: float
    """Of `capacity`: how much more of it."""
    unit: str
    without: str
    """Of `without`: the other class; else empty."""


class AnticipatedEvent(Struct, kw_only=True, frozen=True):
    """An event that is to come, by the episode that is recognized."""

    event: MemoryEvent
    weight: float
    """In the episode, over 0 and at most 1: the later, the greater."""


class Asked(Struct, kw_only=True, frozen=True):
    """What the strongest desire of a class asked for, when the problem was solved."""

    intensity: float
    """With what an emotion added."""
    utility: float
    security: bool
    modulation: Modulation | None
    """What an emotion added to the intensity; null: nothing."""


class Asker(Struct, kw_only=True, frozen=True):
    """Who asks the driver for the wheel."""

    operator: str
    mine: bool
    """Whether it is this page's operator."""
    remaining_s: float
    """Until the driver has not answered."""


class AudioFacts(Struct, kw_only=True, frozen=True):
    """Whether the robot has microphones to listen to, and a loudspeaker to speak through."""

    listen: bool
    speak: bool


class BaseLimits(Struct, kw_only=True, frozen=True):
    """Limits of the mobile base: speeds (m/s, rad/s) and accelerations (m/s^2, rad/s^2), all positive.

    ``lateral_mps`` is the greatest speed sideways, 0 for a base that cannot move so (a differential drive).
    Forward and sideways speeds are limited together, as a vector within the ellipse of both limits; its change is
    within ``linear_mps2``.
    """

    linear_mps: float
    angular_radps: float
    linear_mps2: float
    angular_radps2: float
    lateral_mps: float


class BatteryState(Struct, kw_only=True, frozen=True):
    """State of the body's battery."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    charge: float
    """Share of the capacity that is left, 0 to 1."""
    voltage_v: float
    """At its terminals, V."""
    current_a: float
    """Into the battery, A: negative while it discharges."""
    charging: bool
    """Whether a charger supplies power, also once the battery is full."""
    remaining_s: float | None
    """Time until it is empty, or full while it charges, at the mean power of the last minute; null: neither."""


class CameraClick(Struct, kw_only=True, frozen=True):
    """A point of a picture of the camera."""

    stamp: float
    """Of the picture, at most 3 s old."""
    u: float
    """From its left edge, as a share of its width."""
    v: float
    """From its top edge, as a share of its height."""


class CameraPoint(Struct, kw_only=True, frozen=True):
    """A point on the map (m)."""

    x: float
    y: float
    z: float
    """Above the floor."""
    measured: bool
    """By the camera's depth; else it is where the ray meets the floor, at most 4 m from the camera."""


class Caution(Struct, kw_only=True, frozen=True):
    """A warning about a program's configuration: a ``title`` of a few words, and a ``text`` of one sentence with the
    reason and the remedy. ``where``: file and line, "" if unknown.
    """

    title: str
    text: str
    where: str


class ChangedStrategy(Struct, kw_only=True, frozen=True):
    """What attention reckons with of a strategy."""

    name: str
    utility: float
    """Less than declared while a perception works badly."""
    costs: dict[str, float]
    """What it uses of each resource."""


class ChannelList(Struct, kw_only=True, frozen=True):
    """Every channel."""

    channels: list[ChannelReport]


class ChannelReport(Struct, kw_only=True, frozen=True):
    """One channel of the table and what goes through it."""

    name: str
    title: str
    type: str
    frame: str
    rate_hz: float | None
    """Nominal rate; null for a channel of events."""
    expected_hz: float | None
    """Rate that attention asks for; 0 when closed, null for events."""
    measured_hz: float | None
    """Messages a second over the last two seconds."""
    decimable: bool
    wanted: bool
    """Whether anything listens."""
    producer: str | None
    """`Module.port`; null: fed from outside the graph."""
    published: int
    state: Literal["closed", "live", "stale", "waiting"]
    """`stale`: older than the rate asked for allows, or its module is down. `closed`: not wanted."""
    age_ms: float | None
    """Age of the newest message."""
    stale_after_ms: float | None
    """Age beyond which it is stale; null for events and when closed."""
    subscriptions: dict[str, SubscriptionCounters]
    """Counters by consumer."""


class Channels(Struct, kw_only=True, frozen=True):
    """Whether there are such pictures, scans and clouds."""

    camera: bool
    panorama: bool
    map: bool
    costmap: bool
    scan: bool
    point_cloud: bool


class CurrentMap(Struct, kw_only=True, frozen=True):
    """The map in use."""

    available: bool
    """Whether this program makes maps; if not, nothing of this can be asked."""
    name: str
    """Empty while it has none."""
    state: Literal["lost", "mapping", "searching", "tracking"] | None
    """Of the robot's place on it, as on the live stream; null before it is known."""
    stamp: float | None
    """When that was so (robot's clock, s)."""


class Desire(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """One desire of the Intention Workspace."""

    id: str
    class_: str
    intensity: float
    """How much it is desired, over 0 and at most 8."""
    utility: float
    """Utility desired, 0 to 8; 0 inhibits the class."""
    security: bool
    """Whether it must be fulfilled."""
    params: dict[str, Any]
    """Parameters as the class declares them."""
    source: Source
    created: float
    """Seconds of the robot's clock (Unix epoch)."""
    expires: float | None
    """When it expires (robot's clock, s); null: never."""
    modulation: Modulation | None
    """What an emotion adds to its intensity (docs/emotions.md); null: nothing."""


class DesireChange(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A change of a desire; members left out stay."""

    intensity: float | UnsetType = UNSET
    utility: float | UnsetType = UNSET
    security: bool | UnsetType = UNSET
    params: dict[str, Any] | UnsetType = UNSET
    """All parameters; they replace the former ones, and those left out take their default."""
    ttl: float | UnsetType | None = UNSET
    """Seconds from now; null: it stays."""


class DesireClassList(Struct, kw_only=True, frozen=True):
    """Every desire class, in the order the console shows them, and the ends of the scales."""

    classes: list[DesireClassReport]
    scale: Scale


class DesireClassReport(Struct, kw_only=True, frozen=True):
    """What can be desired."""

    name: str
    title: str
    description: str
    schema: dict[str, Any]
    """JSON Schema of `params`."""
    served: bool
    """Whether a strategy of this program's modules serves it; else no desire for it is fulfilled."""
    achievement: bool
    """Whether a desire for it leaves by itself once it is accomplished."""


class DesireProgress(Struct, kw_only=True, frozen=True):
    """Whether a desire is intended and exploited now, and since when it has been so, or not."""

    id: str
    """Of the desire."""
    intended: bool
    """It is the strongest of its class, and attention selected a strategy for it."""
    exploited: bool
    """A behavior's commands for it pass its arbiter; of a perception: what was selected for it works."""
    intended_since: float | None
    """Since when `intended` is what it is (robot's clock, s); null: since it came."""
    exploited_since: float | None
    """The same of `exploited`."""


class DesireReport(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A desire, and what became of it."""

    id: str
    class_: str
    intensity: float
    """How much it is desired, over 0 and at most 8."""
    utility: float
    """Utility desired, 0 to 8; 0 inhibits the class."""
    security: bool
    """Whether it must be fulfilled."""
    params: dict[str, Any]
    """Parameters as the class declares them."""
    source: Source
    created: float
    """Seconds of the robot's clock (Unix epoch)."""
    expires: float | None
    """When it expires (robot's clock, s); null: never."""
    modulation: Modulation | None
    """What an emotion adds to its intensity (docs/emotions.md); null: nothing."""
    outcome: Literal["done", "expired", "failed", "withdrawn"] | None
    """What a behavior reported last; without a report, why it left; null: nothing became of it yet."""
    behavior: str
    """Name of the module that reported the outcome; empty: none did."""
    reason: str
    """Of the report, in words."""
    ended: float | None
    """When it left (robot's clock, s); null: it is still desired."""


class Desires(Struct, kw_only=True, frozen=True):
    """Every desire in the Intention Workspace, in the order they came."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    desires: list[Desire]
    exploited: list[str]
    """Ids of those that a behavior serves by commands that its arbiter lets through now, or for which a perception
    works.
    """
    accomplishments: list[Accomplishment]
    """The last report on each of `desires` on which there is one."""
    ended: list[DesireReport]
    """The last that left, at most 5, the newest first."""
    progress: list[DesireProgress]
    """Of each of `desires`; empty in recordings of older programs."""


class Driver(Struct, kw_only=True, frozen=True):
    """Who has the wheel."""

    operator: str
    mine: bool
    """Whether it is this page's operator."""
    holds: bool
    """Whether they hold a drive command just now."""


class EStop(Struct, kw_only=True, frozen=True):
    """The request to the guard; GET /api/v1/robot shows within 50 ms what it did."""

    e_stop: Literal["latched", "released"]
    stamp: float
    """The robot's clock then (s): what a release names by `seen`."""


class EmotionLevel(Struct, kw_only=True, frozen=True):
    """One emotion."""

    emotion: Literal["anger", "fear", "joy", "sadness"]
    intensity: float
    """0 to 1."""
    sources: list[EmotionSource]
    """What has fed it, the greatest share first, at most 5."""


class EmotionSource(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A desire class that an emotion comes from."""

    class_: str
    share: float
    """Its part of the emotion's intensity, over 0 and at most 1."""
    neglected: bool
    """Whether it is desired, and not exploited, now."""


class EmotionState(Struct, kw_only=True, frozen=True):
    """What is felt; published on change, at most once a second."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    emotions: list[EmotionLevel]
    """Joy, anger, sadness, fear, in this order."""
    modulates: bool
    """Whether emotions raise the intensity of desires that are ignored."""
    raised: list[RaisedIntensity]
    """The desires that are raised now."""
    shows: bool
    """Whether face and voice show what is felt."""
    shown: ShownEmotion | None
    """What they show now; null: nothing."""


class EpisodeDeed(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A desire that led to the accomplishment of an episode."""

    class_: str
    params: dict[str, Any]
    weight: float
    """In which share of the last times, over 0 and at most 1."""


class EpisodeEvent(Struct, kw_only=True, frozen=True):
    """An event of an episode, in its order."""

    event: int
    weight: float
    """Over 0 and at most 1: the later, the greater."""


class EpisodeReport(Struct, kw_only=True, frozen=True):
    """An episode as it is kept."""

    id: int
    times: int
    first: float
    """When it ended first (robot's clock, s)."""
    last: float
    """When it ended last (robot's clock, s)."""
    learning_rate: float
    """How fast it is overwritten, 0.1 to 1."""
    vigilance: float
    """The match from which it is recognized, 0.45 to 0.85."""
    events: list[EpisodeEvent]
    deeds: list[EpisodeDeed]


class EpisodeSummary(Struct, kw_only=True, frozen=True):
    """An episode in a few words."""

    id: int
    times: int
    """How often it has happened."""
    first: float
    """When it ended first (robot's clock, s)."""
    last: float
    """When it ended last (robot's clock, s)."""
    events: int
    """How many it has."""
    items: list[MemoryItem]
    """The firmest of its events, at most 8."""
    deeds: list[str]
    """Classes of desires that led to its accomplishment."""


class EventList(Struct, kw_only=True, frozen=True):
    """Events, oldest first."""

    events: list[TimelineEvent]


class FieldProblem(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """The error in one field."""

    field: str
    """Dotted path of the field: `params.rate`, `query.limit`."""
    message: str
    """What is allowed there."""
    kind: str | UnsetType = UNSET
    """The rule that the value breaks, as `greater_than`: for other languages. Empty: none."""
    values: dict[str, str | float] | UnsetType = UNSET
    """What `kind` says, as `{"gt": 0}`, and the value that was `given`."""


class FleetReport(Struct, kw_only=True, frozen=True):
    """This robot first, then the others in the order of the fleet's file."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    robots: list[FleetRobot]


class FleetRobot(Struct, kw_only=True, frozen=True):
    """One robot, as its own console answered just now."""

    name: str
    """Its name in the fleet; empty while it has not answered."""
    body: str
    """What kind of robot it is."""
    url: str
    """Its own console; empty: this one."""
    state: Literal["problem", "refused", "stopped", "unreachable", "well"]
    """stopped: its emergency stop is latched; problem: it cannot be driven as it is, or has another's name; refused:
    its console asks for another login; unreachable: it does not answer.
    """
    detail: str
    """The state in words, where there is more to say."""
    driver: str | None
    """The operator who drives it."""
    exploited: str | None
    """The behavior that drives its base."""
    charge: float | None
    """Share of its battery's capacity that is left, 0 to 1; null: not known."""
    simulated: bool


class GivenUpModel(Struct, kw_only=True, frozen=True):
    """A goal that the robot has given up."""

    stamp: float
    goal: GoalPoseModel
    reason: str
    """Why, in words."""


class Goal(Struct, kw_only=True, frozen=True):
    """The goal desired, and the state of navigation."""

    desire: Desire | None
    """The strongest desire of class GoTo; null: there is none."""
    navigation: NavigationModel | None
    """null: this program goes nowhere by itself."""


class GoalPoseModel(Struct, kw_only=True, frozen=True):
    """A goal on the map."""

    x: float
    y: float
    theta: float | None
    """null: any heading."""


class GoalRequest(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A goal for the robot: ``x`` and ``y``, or ``place``."""

    x: float | UnsetType | None = UNSET
    """On the map (m)."""
    y: float | UnsetType | None = UNSET
    """On the map (m)."""
    place: str | UnsetType | None = UNSET
    """Id of a place of the map, instead of `x`, `y` and `heading`."""
    heading: float | UnsetType | None = UNSET
    """On the map (rad); null: any heading."""
    speed: float | UnsetType | None = UNSET
    """Share of the robot's greatest speed; null: as usual."""


class GridInfo(Struct, kw_only=True, frozen=True):
    """What the picture that follows, of the same `seq`, shows."""

    seq: int
    """Grows."""
    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    frame: str
    """`map` or `odom`."""
    version: int
    resolution_m: float
    """Of a pixel."""
    origin: tuple[float, float]
    """x, y of the picture's lower left corner."""
    width: int
    height: int


class GroupReport(Struct, kw_only=True, frozen=True):
    """State of the guard of one group of joints."""

    group: str
    """Its name in the body's file, such as head."""
    state: str
    """idle, moving, holding, yielding, refused or silent."""
    reason: str
    """The same in words, where there is more to say."""
    exploited: str | None
    """The behavior that moves it; null: none."""
    speed_radps: float
    """The fastest of its joints, as measured."""


class Guard(Struct, kw_only=True, frozen=True):
    """State of the guard."""

    state: str
    """idle, driving, stale_command, e_stopped, sensor_failure, waiting or silent."""
    reason: str
    e_stopped: bool
    command_age_ms: float | None
    applied: Velocity


class Health(Struct, kw_only=True, frozen=True):
    """Health of the program."""

    status: Literal["degraded", "ok"]
    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    problems: list[str]
    """Modules that do not run, and what else is wrong."""


class HeardWords(Struct, kw_only=True, frozen=True):
    """An utterance heard while words were listened for, also where it was none of them."""

    stamp: float
    """When the utterance began: seconds of the robot's clock."""
    text: str
    """The word or phrase that was said; empty where that is unsure."""
    unsure: bool
    """Whether to ask again: nothing may be done upon it."""
    confidence: float
    """Of `likeliest`, 0 to 1."""
    likeliest: str
    """Which of the words is the likeliest, also where it is unsure; empty: none."""
    direction: tuple[float, float, float]
    """Where it came from: a unit vector in `base_link`, from the array's middle."""
    words: list[str]
    """What was listened for."""
    language: str
    """Of the words, as `en`."""


class Hello(Struct, kw_only=True, frozen=True):
    """What can be seen and done here."""

    protocol: Literal[1]
    session: str
    """Id of this connection."""
    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    robot: RobotFacts
    scale: Scale
    classes: list[DesireClassReport]
    channels: Channels
    role: Literal["operator", "spectator", "supervisor"]
    """What this connection may do."""
    drive: bool
    """Whether an operator can drive here."""
    head: bool
    """Whether an operator can turn a head here."""
    audio: AudioFacts
    vp9: bool
    """Whether the camera's pictures come as VP9 to pages that say they decode it."""
    playback: PlaybackReport | None
    """null: not a recording."""


class IntentionReport(Struct, kw_only=True, frozen=True):
    """The intention at work: what was selected, what follows from it, and why. Published when it is put in force,
    and again once its reasons are complete.
    """

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    strategies: list[SelectedStrategy]
    fulfilled: list[str]
    """Classes whose strongest desire is fulfilled."""
    omega: float
    """Ω, what the selection is worth (thesis, equation 4.9)."""
    bound: float | None
    """No selection can be worth more; equal to `omega` when proven, null where none is known."""
    use: dict[str, ResourceUse]
    filters: dict[str, float | None]
    """φ of every filter that attention controls."""
    proven: bool
    """Whether no better selection exists."""
    solve_ms: float
    relaxed: list[str]
    """Security desires that could not be kept."""
    reasons: dict[str, Reason]
    """By desired class."""
    parameters: dict[str, dict[str, Any]]
    """What each module was handed."""
    desires: dict[str, str]
    """Id of the strongest desire of each class that it answers."""
    asked: dict[str, Asked]
    """By class, what that desire asked for; empty in recordings of older programs."""
    previous: list[str]
    """Strategies that were selected before; of equals, they stay."""
    changed: list[ChangedStrategy]
    """Strategies that cost or produce otherwise than in the table that the program began with."""
    weights: OmegaWeights
    """What Ω is made of."""


class Jump(Struct, kw_only=True, frozen=True):
    """Where a recording goes on."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""


class KeptMap(Struct, kw_only=True, frozen=True):
    """A map that is kept."""

    name: str
    in_use: bool
    saved: float
    """Unix time (s)."""
    size_m: tuple[float, float]
    """Width and height of its picture."""
    resolution_m: float
    """Of one cell, and of one pixel."""
    known_m2: float
    """How much floor and wall of it is known."""
    extendable: bool
    """Whether it can go on growing when it is loaded."""
    zones: int
    """How many it has."""
    problem: str | None
    """Why it cannot be used, in words."""


class LandmarkList(Struct, kw_only=True, frozen=True):
    """What was found, each in its `frame`."""

    landmarks: list[LandmarkReport]


class LandmarkReport(Struct, kw_only=True, frozen=True):
    """A QR code found: where its centre is in `frame` (m)."""

    text: str
    x: float
    y: float
    z: float
    sigma_m: float
    """Standard deviation along each axis."""
    sightings: int
    first_seen: float
    """Seconds of the robot's clock (Unix epoch)."""
    last_seen: float
    """Seconds of the robot's clock (Unix epoch)."""
    heading: float | None
    """Direction in `frame` (rad) of its outward normal; null: unknown."""
    heading_sigma: float | None
    """Standard deviation of `heading` (rad)."""
    id: int
    """A number that it keeps on its map: one text may hang in several places."""
    frame: str
    """`map` once the robot was localized on it, else `odom`."""


class LaneBuckets(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A lane before now; of each bucket the rate's last value, its least and its greatest (null: there was none)."""

    class_: str
    rate: list[float | None]
    """The last of each bucket."""
    low: list[float | None]
    """Empty where every sample is a bucket."""
    high: list[float | None]
    """Empty where every sample is a bucket."""
    changes: list[LaneChange]
    """Oldest first; of more than two in a bucket the most closed and the last. The first holds from the start."""


class LaneChange(Struct, kw_only=True, frozen=True):
    """What a lane was, from ``stamp`` until the next change."""

    stamp: float
    """Robot's clock (s)."""
    intensity: float | None
    utility: float | None
    divisor: float | None
    """φ: one message in φ passes; null: none passes."""
    divisors: dict[str, float | None]
    """By filter, `Module.port`."""
    state: Literal["degraded", "fulfilled", "inhibited", "needed", "undesired", "unfulfilled"]
    text: str


class LanePast(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A lane before now."""

    class_: str
    rate: list[float | None]
    """One for each stamp."""
    spells: list[LaneSpell]


class LaneRow(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A desire class: how much it is desired, what attention gives it, and why."""

    class_: str
    intensity: float | None
    """Of its strongest desire; null: there is none."""
    utility: float | None
    """Desired by that; null: there is none."""
    rate: float | None
    """Messages let through over messages offered, in the last second; 0 when closed, null: none was offered."""
    divisor: float | None
    """φ: one message in φ passes; null: none passes."""
    divisors: dict[str, float | None]
    """By filter, `Module.port`, of its strategies at work."""
    state: Literal["degraded", "fulfilled", "inhibited", "needed", "undesired", "unfulfilled"]
    text: str


class LaneSpell(Struct, kw_only=True, frozen=True):
    """What a lane was, from one sample until the next spell's."""

    at: int
    """Number of the sample."""
    intensity: float | None
    utility: float | None
    divisor: float | None
    """φ: one message in φ passes; null: none passes."""
    divisors: dict[str, float | None]
    """By filter, `Module.port`."""
    state: Literal["degraded", "fulfilled", "inhibited", "needed", "undesired", "unfulfilled"]
    text: str


class Lanes(Struct, kw_only=True, frozen=True):
    """20 times a second: one row for each desire class, in a fixed order."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    rows: list[LaneRow]


class LanesHistory(Struct, kw_only=True, frozen=True):
    """Once, before the first `lanes`, and after a `jump`: what they were."""

    stamps: list[float]
    rows: list[LanePast]


class LanesPast(Struct, kw_only=True, frozen=True):
    """What the lanes were in a stretch of time. Stamps are of the robot's clock (s)."""

    oldest: float | None
    """Stamp of the oldest sample that is kept; null: there is none."""
    bucket_s: float
    """Width of a bucket; 0: every sample is one."""
    stamps: list[float]
    """Of the first sample of each bucket."""
    ends: list[float]
    """Of its last."""
    rows: list[LaneBuckets]


class LinkChange(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """How the link is shaped from now on; members left out shape nothing."""

    delay_ms: float | UnsetType = UNSET
    """Added to a round trip, half of it each way."""
    jitter_ms: float | UnsetType = UNSET
    """The delay varies by as much; at most the delay."""
    loss_percent: float | UnsetType = UNSET
    """Packets that are lost and sent again."""
    rate_mbit: float | UnsetType | None = UNSET
    """Mbit/s each way; null: not bounded."""


class LinkReport(Struct, kw_only=True, frozen=True):
    """How every stream between the program and its pages is delayed and bounded, for tests; not by the real network."""

    shaped: bool
    """Whether it is at all."""
    delay_ms: float
    """Added to a round trip, half of it each way."""
    jitter_ms: float
    """The delay varies by as much up and down."""
    loss_percent: float
    """Packets that are lost and sent again."""
    rate_mbit: float | None
    """Mbit/s each way; null: not bounded."""
    text: str
    """The same in words; empty where nothing is shaped."""


class LoadReport(Struct, kw_only=True, frozen=True):
    """What the modules take of the computer, once a second."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    window_s: float
    """The time that it was measured over."""
    process_cpu: float
    """Per cent of one core."""
    budget: float | None
    """Per cent that attention may give; null: no limit."""
    modules: list[ModuleReport]
    loop: LoopReport | None
    """What attention makes of it; null: its loop is not closed."""


class LoadRequest(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """How to take a map into use."""

    pose: PoseRequest | UnsetType | None = UNSET
    """Rough pose of the robot, within 1 m and 0.5 rad; null: global localization searches for it."""
    extend: bool | UnsetType = UNSET
    """Whether mapping continues in this map; else it is only localized in."""


class LocalizationReport(Struct, kw_only=True, frozen=True):
    """Where the robot is on the map (m and rad)."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    state: Literal["lost", "mapping", "searching", "tracking"]
    map: str
    """Name of the map in use; empty while it has none."""
    x: float
    y: float
    theta: float
    sigma: tuple[float, float, float]
    """Standard deviations of x, y (m) and theta (rad)."""
    X_MO: PoseReport
    """Pose of `odom` on the map."""
    overlap: float
    """Share of the scan that fits the map, 0 to 1."""


class LoginRequest(Struct, kw_only=True, frozen=True):
    """The console's token, or the password of a role."""

    token: str


class LoopReport(Struct, kw_only=True, frozen=True):
    """Attention's closed loop: costs follow what is measured, the budget of the CPU the pressure on the computer."""

    budget: float
    """As it was set, in per cent of one core."""
    share: float
    """What pressure leaves of it, at most 1."""
    used: float
    """CPU of all modules at work for strategies, measured over the last second."""
    waiting: float | None
    """Share of the time they wanted in which the program's threads had no core."""
    room: float | None
    """Idle time of the program's cores, in per cent of one core."""
    stalled: float | None
    """Share of the time in which some task of the computer had no core (PSI)."""
    runnable: float | None
    """Tasks that could run, over those cores."""
    late_ms: float | None
    """How late the event loop was on average."""
    strategies: list[StrategyLoad]
    """Those at work that take CPU."""
    why: str
    """Why costs or share changed last, in words; empty: they never did."""


class LoudNoise(Struct, kw_only=True, frozen=True):
    """A frame of sound much louder than those before it: ``ratio`` of its energy to their moving mean (thesis 4.2).

    ``level_db`` is the frame's level, dB of full scale. ``stamp`` is the time of the frame's first sample.
    """

    stamp: float
    ratio: float
    level_db: float


class MapList(Struct, kw_only=True, frozen=True):
    """Every map that is kept, by name, and the one in use."""

    folder: str
    current: CurrentMap
    maps: list[KeptMap]


class MemoryEvent(Struct, kw_only=True, frozen=True):
    """What was perceived and done at one time."""

    id: int
    items: list[MemoryItem]


class MemoryItem(Struct, kw_only=True, frozen=True):
    """Something that belongs to an event."""

    channel: Literal["desire", "emotion", "object", "person", "place"]
    item: str
    """Which: `someone`, or `person 3` by the number of this run of the program; `code lab` by the place in front of
    which it hangs, else by a number; `word hello`; a place's id on its map; the class of a desire.
    """
    weight: float
    """How firmly it belongs to it, over 0 and at most 1."""


class MemoryReport(Struct, kw_only=True, frozen=True):
    """All that is remembered."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    episodes: list[EpisodeReport]
    """Those that happened last first."""
    events: list[MemoryEvent]


class MemoryState(Struct, kw_only=True, frozen=True):
    """What happens now, as memory sees it, and the episodes it has; published with each change."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    on: bool
    """Whether anything is remembered."""
    problem: str
    """Why nothing is written to the disk, in words; empty: nothing is wrong."""
    under_way: list[MemoryEvent]
    """The last events of the episode under way, at most 12, in order."""
    recognized: int | None
    """The episode that this is like; null: none."""
    match: float
    """How much it is like it, 0 to 1."""
    anticipated: list[AnticipatedEvent]
    """What comes next by that, the next first, at most 5."""
    raised: list[RaisedDesire]
    episodes: list[EpisodeSummary]
    """At most 20, those that happened last first."""
    episode_count: int
    event_count: int


class Modulation(Struct, kw_only=True, frozen=True):
    """The intensity of a desire is raised by an emotion."""

    by: float
    """So much is added to its intensity, over 0; the sum is at most 8."""
    emotion: Literal["anger", "fear", "joy", "sadness"]
    """The emotion that its neglect has fed."""


class ModuleInput(Struct, kw_only=True, frozen=True):
    """A module's input and its counters since the start."""

    divisor: float | None
    """φ: one message in φ passes; null: none passes."""
    received: int
    """Messages offered, or left out by the source on behalf of the filters."""
    passed: int
    """... let through by the filter."""
    decimated: int
    """... stopped by the filter, or left out, as wanted."""
    dropped: int
    """... pushed out of a full inbox."""
    age_ms: float | None
    """Age of the last message when it was taken."""
    name: str
    channel: str


class ModuleList(Struct, kw_only=True, frozen=True):
    """Every module, and the load of the whole process."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    process_cpu: float
    """Per cent of one core."""
    modules: list[ModuleReport]


class ModuleOutput(Struct, kw_only=True, frozen=True):
    """A module's output."""

    name: str
    channel: str | None
    """null: nothing is connected."""
    divisor: float | None
    """φ: one message in φ passes; null: none passes."""
    offered: int


class ModuleReport(Struct, kw_only=True, frozen=True):
    """One module, its load and its counters."""

    name: str
    title: str
    state: Literal["failed", "hung", "running", "starting", "stopped"]
    cpu: float
    """Per cent of one core, over the last second."""
    cpu_budget: float | None
    """What it is expected to stay under."""
    message_cpu_us: float | None
    """CPU time for each message taken (µs)."""
    restarts: int
    problem: str | None
    inputs: list[ModuleInput]
    outputs: list[ModuleOutput]
    role: Literal["actuation", "behaviors", "motivations", "other", "perception", "sensors"]
    """Its layer in the architecture, by the package that it comes from."""


class NavigationModel(Struct, kw_only=True, frozen=True):
    """State of the behavior that drives to a goal; as `navigation` on the live stream."""

    stamp: float
    behavior: str
    """Empty before the first report."""
    state: Literal["idle", "planning", "following", "recovering", "waiting", "arrived", "unreachable"]
    reason: str
    """In words, and what would help."""
    goal: GoalPoseModel | None
    target: GoalPoseModel | None
    """The nearest reachable place, which it drives to."""
    remaining_m: float | None
    recoveries: int
    desire: str | None
    """Id of the strongest desire to go somewhere."""
    path: list[tuple[float, float]]
    """Points on the map (m), at most 200."""
    given_up: GivenUpModel | None
    """The goal given up last, until there is another or DELETE /goal; null: none."""


class NewDesire(Struct, kw_only=True, frozen=True, omit_defaults=True, rename={"class_": "class"}):
    """A desire to create."""

    class_: str
    """A class of GET /api/v1/desire-classes."""
    intensity: float
    """How much it is desired."""
    utility: float
    """Utility desired; 0 inhibits the class."""
    security: bool | UnsetType = UNSET
    """Whether it must be fulfilled."""
    params: dict[str, Any] | UnsetType = UNSET
    """Parameters as the class declares them."""
    ttl: float | UnsetType | None = UNSET
    """Seconds after which it expires; null: it stays until removed."""


class NewPlace(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A place to create."""

    name: str | UnsetType | None = UNSET
    """For people; null: the poster's text, or a name with a number."""
    pose: PlacePose | UnsetType | None = UNSET
    """By its coordinates."""
    here: bool | UnsetType = UNSET
    """Where the robot is now, with the heading that it has."""
    poster: PosterChoice | UnsetType | None = UNSET
    """In front of a poster, looking at it; it moves with the poster as the map is corrected."""
    id: str | UnsetType | None = UNSET
    """Never changes; null: made of the name."""


class NewRecording(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A recording to make."""

    name: str | UnsetType = UNSET
    """Empty: the date and time at which it begins."""
    keep_minutes: float | UnsetType = UNSET
    """0: all into one file; else the last so many minutes are kept."""
    intensity: float | UnsetType = UNSET
    """How much it is desired."""
    utility: float | UnsetType = UNSET
    """Utility desired: how full the recording must be at least."""


class NewRehearsal(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """How a tour is rehearsed."""

    language: str | UnsetType | None = UNSET
    """Of the visitors; left out: the tour's first."""
    people: int | UnsetType = UNSET
    """How many visitors follow."""
    seed: int | UnsetType = UNSET
    """Of how they follow: the same again with the same."""


class NewTourRun(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """How a tour begins."""

    begin: Literal["now", "visitors"] | UnsetType = UNSET
    """Now, or when visitors or the schedule begin it, as the tour says, again and again."""
    language: str | UnsetType | None = UNSET
    """That the robot speaks; left out: the tour's first."""


class NewWebhook(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """Who is called, of what."""

    url: str
    """Where events are posted: http or https."""
    kinds: list[
        Literal[
            "desire",
            "intention",
            "filter",
            "exploitation",
            "restart",
            "overload",
            "guard",
            "solver",
            "capacity",
            "module",
            "stale",
            "goal",
            "percept",
            "battery",
            "accomplishment",
            "tour",
            "rule",
            "memory",
            "emotion",
        ]
    ]
    """Kinds of events of the timeline."""
    subject: str | UnsetType = UNSET
    """Only events about this: a desire class, a module; empty: about anything."""
    secret: str | UnsetType | None = UNSET
    """With which requests are signed: `whsec_` and 24 to 64 bytes in base64; left out: a new one."""


class NewWebhookReport(Struct, kw_only=True, frozen=True):
    """A webhook that has just been made, with its secret, which is not shown again."""

    webhook: WebhookReport
    secret: str
    """The receiver verifies `webhook-signature` with it (Standard Webhooks, scheme v1), and keeps it."""


class Notice(Struct, kw_only=True, frozen=True):
    """Something for this viewer, in words to show."""

    level: Literal["error", "info", "warning"]
    text: str


class OdometryReport(Struct, kw_only=True, frozen=True):
    """Pose in `odom` (m, rad) and measured velocity (m/s, rad/s)."""

    x: float
    y: float
    theta: float
    linear_mps: float
    angular_radps: float
    lateral_mps: float


class OmegaWeights(Struct, kw_only=True, frozen=True):
    """What Ω is made of: intensity·i of what is fulfilled, utility·v of what serves it, spare for each unit left of
    a resource.
    """

    intensity: float
    """Of the intensities of fulfilled desires; 1 in the thesis."""
    utility: float
    """Of produced utilities; 1 in the thesis."""
    spare: float
    """Of each unit of `spare_of` that is left; 0 in the thesis."""
    spare_of: str
    """The resource."""


class OperatorQuestion(Struct, kw_only=True, frozen=True):
    """What the robot asks its operator; without an answer it does what it says."""

    text: str
    """The question."""
    answers: list[
        Literal["agree", "decline", "end", "next", "pause", "repeat", "resume", "retry", "skip", "start", "undo_skip"]
    ]
    """Buttons that answer it."""
    default: str
    """What it does without an answer, in words."""
    until: float
    """When it does that (robot's clock, s)."""


class PageReport(Struct, kw_only=True, frozen=True):
    """A page on the live stream."""

    operator: str
    driving: bool
    rtt_ms: float | None
    """Last round trip that the page measured."""
    late_ms: float | None
    """How old its last message was when it came, at most; null: not known."""
    waits: str
    """Why its driving waits, in words; empty: it does not."""
    waiting: int
    """Frames that wait for it."""
    sent: int
    """Frames sent."""
    replaced: int
    """Frames replaced by a newer one of their kind before they could be sent."""


class Person(Struct, kw_only=True, frozen=True):
    """A person, by all that is perceived of them.

    ``track`` is the number of one uninterrupted perception and ``person`` the identity, which is kept over
    interruptions: None while ``tentative`` (not yet believed to be a person) and while ``unsure`` (a person, but
    one of several known ones, or a new one). A person ``lost`` was not perceived for a second, and is predicted.
    No number is used again.

    ``p_OP`` (m, in ``odom``) is the middle of the face, its height that of people in general where none was seen;
    ``v_O`` (m/s) the velocity over ground, ``covariance`` (2, 2) float64 m² of the place over ground. ``face``
    and ``voice`` are the tracks of what is bound to the person now, None without; ``legs`` whether the laser sees
    them. ``speaking``: the voice sounds now. ``last_seen`` (s, robot's clock) by a camera or the laser.
    """

    track: int
    person: int | None
    state: Literal["confirmed", "lost", "tentative", "unsure"]
    p_OP: tuple[float, float, float]
    v_O: tuple[float, float]
    covariance: list[tuple[float, float]]
    face: int | None
    voice: int | None
    legs: bool
    speaking: bool
    last_seen: float


class Persons(Struct, kw_only=True, frozen=True):
    """All persons at ``stamp``, in the order of their tracks."""

    stamp: float
    persons: list[Person]


class PlaceChange(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A change of a place; members left out stay."""

    name: str | UnsetType = UNSET
    """For people; no two places of a map share one."""
    pose: PlacePose | UnsetType = UNSET
    """By hand: it follows no poster from then on."""


class PlaceList(Struct, kw_only=True, frozen=True):
    """Every place of the map in use, in the order of their making."""

    places: list[PlaceReport]


class PlacePose(Struct, kw_only=True, frozen=True):
    """A pose on the map."""

    x: float
    y: float
    heading: float
    """Heading on the map, left positive."""


class PlaceReplacement(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A place in whole."""

    name: str | UnsetType | None = UNSET
    """For people; null: the poster's text, or a name with a number."""
    pose: PlacePose | UnsetType | None = UNSET
    """By its coordinates."""
    here: bool | UnsetType = UNSET
    """Where the robot is now, with the heading that it has."""
    poster: PosterChoice | UnsetType | None = UNSET
    """In front of a poster, looking at it; it moves with the poster as the map is corrected."""


class PlaceReport(Struct, kw_only=True, frozen=True):
    """A named pose on the map."""

    id: str
    """Never changes."""
    name: str
    """For people; no two places share one."""
    x: float
    """On the map (m)."""
    y: float
    """On the map (m)."""
    heading: float
    """On the map (rad)."""
    source: Literal["hand", "here", "poster"]
    """`hand`: by its coordinates. `here`: where the robot stood. `poster`: in front of one, which it follows."""
    poster: str
    """Text of that poster; empty: none."""
    landmark: int
    """Number of that poster's landmark on this map; 0: none."""
    problem: str
    """Why the robot cannot stand there, or what is doubtful, in words; empty: nothing."""
    etag: str
    """Its version, for `If-Match`. A pose that follows its poster is no new version."""


class PlacedCode(Struct, kw_only=True, frozen=True):
    """A QR code in one image of ``camera``: its ``corners`` (4, 2) float64 px, in the order of ``QRCode``, in the
    image of ``image`` (width, height) px.
    """

    text: str
    camera: str
    stamp: float
    corners: list[tuple[float, float]]
    image: tuple[int, int]


class PlacedFace(Struct, kw_only=True, frozen=True):
    """A face in one image of ``camera``, placed with the robot's pose at ``stamp``.

    ``azimuth`` (left positive) and ``elevation`` (rad) in the axes of B, from the camera as it was then;
    ``panorama`` is both, from where the newest panorama was taken (None: there is none). ``range_m`` from the
    camera, with standard deviation ``range_sigma_m``. ``x``, ``y``, ``z`` (m) is its place in O and ``towards_O``
    the heading (rad in O) in which it has the robot, all None before the pose at ``stamp`` is known. ``box`` is
    left, top, width, height (px) in the image of ``image`` (width, height) px.
    """

    track: int
    camera: str
    stamp: float
    azimuth: float
    elevation: float
    panorama: tuple[float, float] | None
    range_m: float | None
    range_sigma_m: float | None
    x: float | None
    y: float | None
    z: float | None
    towards_O: float | None
    score: float
    box: tuple[float, float, float, float]
    image: tuple[int, int]


class PlacedPercepts(Struct, kw_only=True, frozen=True):
    """What the robot sees and hears at ``stamp``; published when it changes.

    ``faces`` by track and camera, ``sounds`` by track, ``noises`` of the last 2 s, ``codes`` by text and camera.
    """

    stamp: float
    faces: list[PlacedFace]
    sounds: list[PlacedSound]
    noises: list[LoudNoise]
    codes: list[PlacedCode]


class PlacedSound(Struct, kw_only=True, frozen=True):
    """A tracked sound, placed with the robot's pose at ``stamp``: angles and place as in ``PlacedFace``.

    Angles and ``range_m`` are from the microphones' middle, which is at ``p_OA`` (m in O); ``v_O`` is the
    direction as a unit vector in the axes of O. Place and range are None where the distance is not known, all of
    O before the pose is. ``active``: it sounds now, else it did last at ``last_active``; ``speech`` is None while
    nothing has judged it.
    """

    track: int
    stamp: float
    azimuth: float
    elevation: float
    panorama: tuple[float, float] | None
    range_m: float | None
    range_sigma_m: float | None
    x: float | None
    y: float | None
    z: float | None
    p_OA: tuple[float, float, float] | None
    v_O: tuple[float, float, float] | None
    power: float
    level_db: float
    active: bool
    last_active: float
    speech: float | None


class PlaybackChange(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A change of the playback; members left out stay."""

    playing: bool | UnsetType | None = UNSET
    speed: float | UnsetType | None = UNSET
    """Seconds of the recording in a real second; null: as fast as possible, nothing dropped."""
    position: float | UnsetType | None = UNSET
    """Go there (stamp of the recording, s)."""


class PlaybackReport(Struct, kw_only=True, frozen=True):
    """State of the playback; stamps are the recording's."""

    file: str
    """Name of the recording's file."""
    begin: float
    """Seconds of the robot's clock (Unix epoch)."""
    end: float
    """Seconds of the robot's clock (Unix epoch)."""
    position: float
    """Seconds of the robot's clock (Unix epoch)."""
    speed: float | None
    """Seconds of the recording in a real second; null: as fast as possible, nothing dropped."""
    playing: bool
    """Whether time goes on, or will after the seek under way."""
    phase: Literal["ended", "paused", "playing", "seeking"]
    problem: str | None
    """Why it cannot go on: the part of the recording that cannot be read."""


class Pong(Struct, kw_only=True, frozen=True):
    """The answer to `ping`."""

    t: float | None
    """As it was sent."""
    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""


class PoseReport(Struct, kw_only=True, frozen=True):
    """A pose: m and rad."""

    x: float
    y: float
    theta: float


class PoseRequest(Struct, kw_only=True, frozen=True):
    """A pose on the map."""

    x: float
    y: float
    theta: float
    """Heading on the map, left positive."""


class PosterChoice(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A poster (a QR code) that was found on the map."""

    text: str
    """What it says."""
    near: tuple[float, float] | UnsetType | None = UNSET
    """x and y (m) on the map: of several with this text the nearest to there; null: the first."""


class ProblemDocument(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A refusal (RFC 9457)."""

    type: str
    """The kind of problem: `urn:hbba:problem:` and a stable name."""
    title: str
    """The kind of problem in words."""
    status: int
    """The HTTP status."""
    detail: str
    """What happened this time, and what is allowed."""
    errors: list[FieldProblem] | UnsetType = UNSET
    """Field by field, where fields are wrong."""


class RaisedDesire(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A desire of memory's."""

    id: str
    """Of the desire."""
    class_: str
    intensity: float
    episode: int
    """The episode that is the reason."""
    why: str
    """In words."""


class RaisedIntensity(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A desire whose intensity is raised."""

    id: str
    """Of the desire."""
    class_: str
    by: float
    emotion: Literal["anger", "fear", "joy", "sadness"]


class Reason(Struct, kw_only=True, frozen=True):
    """Why a desired class gets what it gets."""

    state: Literal["degraded", "fulfilled", "inhibited", "unfulfilled"]
    utility: float
    """The utility it gets."""
    wanted: float
    """The utility desired."""
    best: float
    """The most that any selection could give it."""
    text: str
    """The reason in words."""
    alternatives: list[Alternative]
    searched: bool
    """Whether the search for alternatives was complete."""
    remark: str
    """What lessens the utility that its strategies produce now; empty: nothing."""


class RecorderReport(Struct, kw_only=True, frozen=True):
    """State of the Recorder."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    state: Literal["idle", "recording", "ring", "stopped"]
    """`ring`: the last minutes are kept. `stopped`: by itself, though still desired; see `reason`."""
    name: str
    """The recording's; empty while idle."""
    began: float | None
    """When it began (robot's clock, s)."""
    duration_s: float
    bytes: int
    """On disk so far."""
    messages: int
    dropped: int
    """Messages that could not be queued for the disk."""
    queued_bytes: int
    """What waits for the disk now."""
    keep_minutes: float
    """Of the ring; 0: everything goes into one file."""
    desired: bool
    """Whether there is a desire for a recording."""
    reason: str
    """Why it does not record though it is desired, in words; empty when all is well."""
    available: bool
    """Whether it runs and attention has a strategy for it."""


class RecordingList(Struct, kw_only=True, frozen=True):
    """Every recording, the newest first, and what the Recorder does."""

    folder: str
    free_bytes: int
    """Room left on its disk."""
    recorder: RecorderReport | None
    """null: this program has no Recorder."""
    replay: ReplayReport | None
    """The replay that this console started, while it runs."""
    recordings: list[RecordingReport]


class RecordingReport(Struct, kw_only=True, frozen=True):
    """One recording."""

    name: str
    bytes: int
    duration_s: float | None
    """From its first message to its last; null where it is not known."""
    began: float | None
    """Its first message (robot's clock, s); null where it is not known."""
    state: Literal["complete", "recording", "unfinished"]
    """`unfinished`: it was never closed; `hbba log repair` makes it readable."""
    robot: str
    """The robot's name; empty where the file does not say."""


class Rehearsal(Struct, kw_only=True, frozen=True):
    """A tour as it was rehearsed."""

    tour: str
    language: str
    outcome: str
    """Why it ended, in words."""
    duration_s: float
    """Since the rehearsal's begin, s."""
    driven_m: float
    stops: list[str]
    """Ids of those that were presented, in order."""
    states: list[RehearsedState]
    subtitles: list[Subtitle]
    path: list[RehearsedPose]
    problems: list[RehearsalProblem]


class RehearsalProblem(Struct, kw_only=True, frozen=True):
    """What would go wrong. An ``error`` keeps the tour from being led as it is written; a ``warning`` does not."""

    severity: Literal["error", "warning"]
    stop: str
    """Id of the stop; empty: none."""
    message: str
    """One sentence."""
    at_s: float | None


class RehearsalReport(Struct, kw_only=True, frozen=True):
    """The rehearsal that is under way, or the last."""

    state: Literal["done", "failed", "none", "running"]
    tour: str
    """Id of the tour; empty: there was none."""
    language: str
    """Of the visitors."""
    began: float | None
    """Unix time, s."""
    seconds: float
    """How much of the tour was played (s)."""
    stop: str
    """Id of the stop that it is at; empty: none."""
    problem: str
    """Why it failed, in words; empty: it did not."""
    can_be_led: bool | None
    """Whether nothing keeps the tour from being led; null: not known."""
    result: Rehearsal | None
    """What was found; null: nothing yet."""


class RehearsedPose(Struct, kw_only=True, frozen=True):
    """Where the robot was, on the map (m, rad), and how far the farthest visitor was from it (m; null: nobody)."""

    at_s: float
    """Since the rehearsal's begin, s."""
    x: float
    y: float
    heading: float
    farthest_m: float | None


class RehearsedState(Struct, kw_only=True, frozen=True):
    """A state of the guide, as it began."""

    at_s: float
    """Since the rehearsal's begin, s."""
    state: str
    stop: str
    """Id of the stop; empty: none."""
    reason: str
    """In words; may be empty."""


class RenameRequest(Struct, kw_only=True, frozen=True):
    """A change of a map."""

    name: str
    """The new name."""


class ReplayReport(Struct, kw_only=True, frozen=True):
    """A replay that runs."""

    name: str
    """The recording replayed."""
    url: str
    """Its console's address, with the token behind `#` where there is one."""


class ResourceChange(Struct, kw_only=True, frozen=True):
    """A new budget; attention selects again at once."""

    capacity: float
    """How much of it attention may give, in its unit; thousandths are the finest step."""


class ResourceList(Struct, kw_only=True, frozen=True):
    """Every resource."""

    resources: list[ResourceReport]


class ResourceReport(Struct, kw_only=True, frozen=True):
    """What strategies share."""

    name: str
    capacity: float
    """How much of it attention may give now."""
    declared: float
    """Its capacity in configuration."""
    used: float
    """What the intention at work uses of it."""
    budget: float
    """As it was set last; `capacity` is less while others press on the computer."""
    unit: str
    description: str


class ResourceUse(Struct, kw_only=True, frozen=True):
    """What is used of a resource."""

    used: float
    capacity: float
    unit: str


class RobotFacts(Struct, kw_only=True, frozen=True):
    """The body and its limits."""

    name: str
    called: str
    """What this robot is called among others (`console.name`); its `name` without one."""
    simulated: bool
    replayed: bool
    """Whether it is the body of a replay: it can neither be driven nor stopped."""
    limits: BaseLimits
    footprint: list[tuple[float, float]]
    """Corners of its outline (m, in base_link), counter-clockwise; empty for one that does not move."""
    cautions: list[Caution]


class RobotReport(Struct, kw_only=True, frozen=True):
    """The robot's state."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    robot: RobotFacts
    guard: Guard
    world_rate: float
    odometry: OdometryReport | None
    driver: str | None
    """The operator who drives."""
    exploited: str | None
    """The behavior that drives the base."""
    landmarks: list[LandmarkReport]
    battery: BatteryState | None
    """null: the body has none, or has not reported it yet."""


class RouteLegReport(Struct, kw_only=True, frozen=True):
    """A way from one point of a route to the next."""

    state: Literal["near", "none", "way"]
    """`way`: it leads there. `near`: to the nearest place that can be reached. `none`: it cannot be driven."""
    reason: str
    """Why it does not lead there, or what is special about it, in words; empty: nothing."""
    length_m: float
    duration_s: float
    """About how long it takes if nothing is in the way, with turns on the spot."""
    path: list[tuple[float, float]]
    """Its corners x, y on the map (m), at most 200."""


class RoutePoint(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A point of a route: a ``place``, or ``x`` and ``y``."""

    place: str | UnsetType | None = UNSET
    """Id of a place of the map in use."""
    x: float | UnsetType | None = UNSET
    """On the map (m)."""
    y: float | UnsetType | None = UNSET
    """On the map (m)."""
    heading: float | UnsetType | None = UNSET
    """On the map (rad); null: any heading."""


class RouteReport(Struct, kw_only=True, frozen=True):
    """A route, leg by leg."""

    map: str
    """The map in use; empty: it has no name yet."""
    legs: list[RouteLegReport]
    """One less than points."""
    length_m: float
    """Of all legs that can be driven."""
    duration_s: float
    """Of all legs that can be driven."""


class RouteRequest(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """Points to drive to, one after another."""

    points: list[RoutePoint]
    speed: float | UnsetType = UNSET
    """Share of the robot's greatest speed."""


class RuleReport(Struct, kw_only=True, frozen=True):
    """A rule by which something is desired (docs/rules.md), and what it did."""

    name: str
    about: str
    """What it is for, in words; may be empty."""
    words: str
    """When it applies, in words."""
    file: str
    """The file that it is in."""
    line: int
    """Its line there, from 1."""
    enabled: bool
    holds: bool | None
    """Of a rule with `while`: whether it applies now; null of others."""
    fired: int
    """How often it applied."""
    last_fired: float | None
    """When it applied last (robot's clock, s); null: never."""
    last_event: str
    """What made it apply then, in words."""
    desires: list[str]
    """Ids of the desires that there are by it."""
    problem: str
    """Why something it should have done was not done, when it applied last."""


class RulesReport(Struct, kw_only=True, frozen=True):
    """The rules in force, in their order; published when one applies, and when their files change."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    rules: list[RuleReport]
    files: list[str]
    """The files that they are read from."""
    problem: str
    """Why the files, as they are now, are not in force: file, line and mistake; empty: they are."""


class RunReport(Struct, kw_only=True, frozen=True):
    """What a run of a tour was."""

    run: str
    """Its id."""
    tour: str
    """Id of the tour."""
    title: dict[str, str]
    """Of the tour, by language."""
    language: str
    """That the robot spoke."""
    began: float
    """Unix time, s."""
    ended: float | None
    """Unix time, s; null: it is under way."""
    outcome: str
    """Why it ended, in words; empty: it has not."""
    agreed: bool
    """Whether visitors came along."""
    people_begin: int
    """How many were seen when it began."""
    people_most: int
    """The most that were seen at once."""
    people_end: int
    """How many were seen at the farewell."""
    driven_m: float
    """The way that was driven (m)."""
    waits: int
    """How often it waited for visitors, or looked back for them."""
    waited_s: float
    """How long in all."""
    pauses: int
    paused_s: float
    stops: list[StopReport]
    """In the order of the way; one that was gone to twice is there twice."""
    failures: list[TourFailure]


class RunReportList(Struct, kw_only=True, frozen=True):
    """Reports on runs of tours, the newest first."""

    reports: list[RunReport]


class SaliencyMap(Struct, kw_only=True, frozen=True):
    """How salient all directions around the head are at ``stamp``.

    ``cells`` (rows, columns) uint8: 255 is the saliency ``full``, or more. Rows go from the top down, ``step``
    rad each, with level in the middle; columns from azimuth +π to -π (left positive) in the axes of B.
    """

    stamp: float
    step: float
    full: float
    cells: list[list[int]]


class SalientRegion(Struct, kw_only=True, frozen=True):
    """A direction that stands out: ``azimuth`` (left positive) and ``elevation`` (rad) from the head, in B's axes.

    ``saliency`` is the sum of the other members, what each feature gives to it, weighted with its gain.
    """

    azimuth: float
    elevation: float
    saliency: float
    motion: float
    color: float
    contrast: float
    faces: float
    sounds: float


class SalientRegions(Struct, kw_only=True, frozen=True):
    """The most salient regions at ``stamp``, the most salient first, three at most; directions are from ``p_BH``,
    the middle of the sphere around the head (m in B).
    """

    stamp: float
    p_BH: tuple[float, float, float]
    regions: list[SalientRegion]


class SaveRequest(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """The part of the ring to keep."""

    minutes: float | UnsetType | None = UNSET
    """The last so many; null: all there are."""
    name: str | UnsetType = UNSET
    """Empty: a name made of the time."""


class Saved(Struct, kw_only=True, frozen=True):
    """The recording made of the ring."""

    name: str


class Scale(Struct, kw_only=True, frozen=True):
    """The ends of the scales of desires."""

    intensity: float
    utility: float


class SceneAddress(Struct, kw_only=True, frozen=True):
    """Where a page takes the 3D view for a frame from."""

    url: str | None
    """On its own port; null: from the console's, at `viser/`."""


class SceneClick(Struct, kw_only=True, frozen=True):
    """A point of a 3D view."""

    viewer: str
    """The view's name for itself, as `GET /viewers` lists it."""
    u: float
    """From its left edge, as a share of its width."""
    v: float
    """From its top edge, as a share of its height."""


class ScenePoint(Struct, kw_only=True, frozen=True):
    """What a point of a 3D view shows."""

    kind: Literal["floor", "nothing", "poster", "seen", "wall"]
    """`poster`: one that was found; `wall`: of the map; `seen`: by the depth camera; `nothing`: the sky."""
    frame: Literal["map", "odom"]
    """`odom` while it is not known where the robot is on the map."""
    x: float | None
    """In m, as `y` and `z`: of a poster its middle; null: nothing is there."""
    y: float | None
    z: float | None
    """Above the floor."""
    text: str | None
    """What the poster says."""
    landmark: int | None
    """The poster's `id`, which it keeps on its map."""


class SelectedStrategy(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """A strategy at work."""

    name: str
    class_: str
    utility: float
    filters: dict[str, float | None]
    costs: dict[str, float]


class Session(Struct, kw_only=True, frozen=True):
    """That this client may use the console."""

    authenticated: Literal[True]
    token_needed: bool
    role: Literal["operator", "spectator", "supervisor"]
    """What it may do here."""


class ShownEmotion(Struct, kw_only=True, frozen=True):
    """The emotion that face and voice show, one at a time."""

    emotion: Literal["anger", "fear", "joy", "sadness"]
    strength: float
    """How strongly it shows: over 0, to 1."""
    desire: str
    """Id of the desire Express that is stated for the face; empty: none, since another expression is desired, or the
    robot has no face.
    """


class ShownMedia(Struct, kw_only=True, frozen=True):
    """A picture or a video that visitors are shown."""

    file: str
    """Its path in the folder of tours."""
    alt: dict[str, str]
    """What it shows, by language."""
    video: bool
    """Whether it is a video."""


class Source(Struct, kw_only=True, frozen=True):
    """The author of a desire: a motivation of the robot, an operator at the console or a REST client, by name; of a
    motivation that goes by rules, the rule, its event and the time.
    """

    kind: Literal["motivation", "operator", "rest"]
    name: str
    rule: str
    """The rule that it came by; empty: by none."""
    event: str
    """What made the rule apply, in words; empty without a rule."""
    applied: float | None
    """When the rule applied (robot's clock, s); null without a rule."""
    motive: Literal["emotional", "instinctive", "rational"] | None
    """Of a motivation, its kind: `instinctive` (what the robot itself needs), `rational` (its task) or `emotional`
    (conflicts, feelings); null: it is no motivation, or says none.
    """


class SourceState(Struct, kw_only=True, frozen=True):
    """Freshness of a channel: its measured and its expected rate."""

    channel: str
    state: Literal["closed", "live", "stale", "waiting"]
    age_ms: float | None
    rate_hz: float | None
    expected_hz: float | None


class Speaker(Struct, kw_only=True, frozen=True):
    """The operator who speaks through the robot."""

    operator: str
    mine: bool
    """Whether it is this page's operator."""


class Speech(Struct, kw_only=True, frozen=True):
    """What the robot says now, for subtitles and for its mouth; published with each change."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    state: Literal["silent", "speaking"]
    text: str
    """The sentence that is said, or was said last."""
    word_begin: int
    """The word of it that is said: its first character, from 0."""
    word_end: int
    """The character after its last; equal to the first before the first word."""
    viseme: str
    """The mouth: `closed`, `teeth`, `narrow`, `spread`, `mid`, `open`, `round` or `pursed`."""
    language: str
    """Of the text, as `en`."""
    desire: str
    """Id of the desire that is being fulfilled; empty while silent."""
    waiting: int
    """Number of other texts that wait."""


class Status(Struct, kw_only=True, frozen=True):
    """Guard, pose, driver, freshness of every source."""

    seq: int
    """Grows."""
    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    guard: Guard
    world_rate: float
    odometry: OdometryReport | None
    driver: Driver | None
    asker: Asker | None
    speaker: Speaker | None
    exploited: str | None
    """The behavior that drives."""
    limited: str
    """Why the collision monitor slowed or stopped it, in words; empty: it did not."""
    groups: list[GroupReport]
    """The actuator groups but for the base."""
    waits: str
    """Why this viewer's driving waits, its commands coming too late; empty: it does not."""
    sources: list[SourceState]
    slowed: str
    """Why this viewer drives slower than its stick says; empty: it does not."""
    share: float
    """The share of the speeds of its stick that this viewer is given for it, 0 to 1."""


class StopReport(Struct, kw_only=True, frozen=True):
    """What became of one stop."""

    stop: str
    """Its id."""
    began: float
    """When the robot set out for it (Unix time, s)."""
    arrived: float | None
    """When it was there (Unix time, s); null: never."""
    ended: float | None
    """When it was presented, or left (Unix time, s); null: not yet."""
    presented: bool
    """Whether all of it was presented."""
    skipped: bool
    """Whether people skipped it."""
    people: int
    """The most people that were seen there at once."""
    questions: dict[str, int]
    """How often each question was asked, by its id."""


class StrategyList(Struct, kw_only=True, frozen=True):
    """Every strategy, in table order."""

    strategies: list[StrategyReport]


class StrategyLoad(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """CPU of a strategy at work, in per cent of one core."""

    name: str
    class_: str
    declared: float
    """As its file says, or as calibrated on this computer."""
    measured: float | None
    """Over the last second; null: it was not at work all that time."""
    estimated: float
    """By all that was measured."""
    used: float
    """What attention reckons with."""


class StrategyReport(Struct, kw_only=True, frozen=True, rename={"class_": "class"}):
    """One way to serve a desire class."""

    name: str
    class_: str
    utility: float
    """Produced utility v, over 0 and at most 8, as attention reckons now."""
    requires: dict[str, float]
    """Utility needed of other classes."""
    filters: dict[str, float | None]
    """φ by `Module.port`."""
    parameters: dict[str, dict[str, Any]]
    """What modules are handed while it is selected, by module."""
    costs: dict[str, float]
    """What it uses of each resource, as attention reckons now."""
    selected: bool
    declared: str | None
    """File and line."""
    declared_costs: dict[str, float]
    """As declared there, or calibrated on this computer."""
    declared_utility: float
    """As declared there: `utility` is less while a perception works badly."""


class SubscriptionCounters(Struct, kw_only=True, frozen=True):
    """The counters of one consumer's end of a channel, since the start."""

    divisor: float | None
    """φ: one message in φ passes; null: none passes."""
    received: int
    """Messages offered, or left out by the source on behalf of the filters."""
    passed: int
    """... let through by the filter."""
    decimated: int
    """... stopped by the filter, or left out, as wanted."""
    dropped: int
    """... pushed out of a full inbox."""
    age_ms: float | None
    """Age of the last message when it was taken."""


class Subtitle(Struct, kw_only=True, frozen=True):
    """A sentence that was said."""

    at_s: float
    """Since the rehearsal's begin, s."""
    until_s: float
    """Since the rehearsal's begin, s."""
    text: str
    language: str


class SupposedDesire(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """What the strongest desire of a class is supposed to ask for."""

    intensity: float
    utility: float | UnsetType = UNSET
    """0 inhibits the class."""
    security: bool | UnsetType = UNSET


class TimelineEvent(Struct, kw_only=True, frozen=True):
    """One event of the timeline; ``data`` is JSON as it is."""

    id: int
    """Grows by one from 1."""
    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    kind: Literal[
        "accomplishment",
        "battery",
        "capacity",
        "desire",
        "emotion",
        "exploitation",
        "filter",
        "goal",
        "guard",
        "intention",
        "memory",
        "module",
        "overload",
        "percept",
        "restart",
        "rule",
        "solver",
        "stale",
        "tour",
    ]
    subject: str
    """What it is about: a desire class, a module, a filter."""
    text: str
    """One sentence."""
    data: dict[str, Any]


class TourFailure(Struct, kw_only=True, frozen=True):
    """Something on a tour that failed."""

    stop: str
    """Id of the stop."""
    what: str
    """In words."""


class TourList(Struct, kw_only=True, frozen=True):
    """Every tour, by id."""

    folder: str
    """Of the user's tours, on the robot's computer."""
    tours: list[TourSummary]


class TourMedia(Struct, kw_only=True, frozen=True):
    """A picture or a video that tours can show."""

    file: str
    """As a tour's `show` names it."""
    type: str
    video: bool
    """Whether it is a video."""
    size: int
    """In bytes."""
    changed: float
    """Unix time, s."""
    shipped: bool
    """Whether it came with the program."""
    tours: list[str]
    """Ids of the tours that show it."""


class TourMediaList(Struct, kw_only=True, frozen=True):
    """All that tours can show, by name."""

    media: list[TourMedia]
    largest_picture: int
    """Pictures with more bytes are not taken."""
    largest_video: int
    """Videos with more bytes are not taken."""


class TourPress(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """One thing that is done with the tour under way."""

    button: (
        Literal["start", "agree", "decline", "next", "pause", "resume", "retry", "skip", "undo_skip", "repeat", "end"]
        | UnsetType
        | None
    ) = UNSET
    """A button, one of `buttons` now."""
    stop: str | UnsetType | None = UNSET
    """Id of a stop to go to."""
    ask: str | UnsetType | None = UNSET
    """Id of a question that a visitor asks, one of `questions` now."""


class TourProblemReport(Struct, kw_only=True, frozen=True):
    """A problem of a tour."""

    field: str
    """The value that it is about, as `stops.0.place`."""
    message: str
    severity: Literal["error", "mistake", "warning"]
    """`mistake`: not kept; `error`: kept, and cannot run; `warning`: runs all the same."""


class TourProgress(Struct, kw_only=True, frozen=True):
    """How the tour that is under way goes, or waits for visitors; published with each change."""

    stamp: float
    """Seconds of the robot's clock (Unix epoch)."""
    run: str
    """Id of the run; empty before the first."""
    tour: str
    """Id of the tour; empty: none is under way, and none waits for visitors."""
    title: dict[str, str]
    """Of the tour, by language."""
    language: str
    """That the robot speaks."""
    languages: list[str]
    waits: bool
    """Whether visitors and the schedule begin it, again and again."""
    state: Literal[
        "answering",
        "blocked",
        "confirming",
        "going_home",
        "idle",
        "inviting",
        "leading",
        "listening",
        "lost",
        "parting",
        "paused",
        "presenting",
        "searching",
        "turning",
        "waiting",
    ]
    since: float
    """When the state began (robot's clock, s)."""
    reason: str
    """Why it is in this state, in words; may be empty."""
    stop: str
    """Id of the stop that it is at, or on the way to; empty: none."""
    stop_title: dict[str, str]
    """By language."""
    number: int
    """Of the stop among those that are not left out, from 1; 0: none."""
    stops: int
    """How many there are that are not left out."""
    step: int
    """Of the stop, greeting or farewell, from 1; 0: none."""
    steps: int
    text: dict[str, str]
    """What is said in this step, by language; none: nothing."""
    sentence: int
    """Which sentence of it, from 0."""
    shown: ShownMedia | None
    """What visitors are shown; null: nothing."""
    press: dict[str, str]
    """What the button `next` is called, by language; none: it is not waited for."""
    questions: list[TourQuestion]
    """That visitors may ask now."""
    buttons: list[
        Literal["agree", "decline", "end", "next", "pause", "repeat", "resume", "retry", "skip", "start", "undo_skip"]
    ]
    """That do something now."""
    question: OperatorQuestion | None
    """That the operator is asked; null: none."""
    people: int
    """How many are seen."""
    farthest_m: float | None
    """The distance of the farthest of them (m); null: none is seen."""
    presented: list[str]
    """Ids of the stops that were presented."""
    skipped: list[str]
    """Ids of the stops that were skipped."""
    failures: list[TourFailure]


class TourQuestion(Struct, kw_only=True, frozen=True):
    """A question that visitors may ask at a stop."""

    id: str
    question: dict[str, str]
    """By language."""


class TourReport(Struct, kw_only=True, frozen=True):
    """A tour, and what is to be said of it."""

    tour: dict[str, Any]
    """As `GET /tour-schema` describes it, every member there."""
    shipped: bool
    """Whether it came with the program and was not changed."""
    can_undo: bool
    can_redo: bool
    problems: list[TourProblemReport]
    """The worst first."""


class TourRunReport(Struct, kw_only=True, frozen=True):
    """The tour that is under way."""

    progress: TourProgress
    """How it goes now."""
    report: RunReport | None
    """What the run has been so far, or the last one was; null: none."""


class TourSummary(Struct, kw_only=True, frozen=True):
    """A tour in the list of all."""

    id: str
    title: dict[str, str]
    """By language."""
    languages: list[str]
    map: str
    stops: int
    """How many are not left out."""
    shipped: bool
    """Whether it came with the program and was not changed."""
    etag: str
    errors: int
    """Problems for which it cannot run."""
    warnings: int
    problem: str | None
    """Why its file cannot be read, in words; all else is empty then."""


class TourVerdict(Struct, kw_only=True, frozen=True):
    """What became of a check."""

    runs: bool
    """Whether it has neither mistakes nor errors."""
    problems: list[TourProblemReport]
    """The worst first."""


class Velocity(Struct, kw_only=True, frozen=True):
    """Forward m/s, turn rad/s and sideways m/s (left positive)."""

    linear_mps: float
    angular_radps: float
    lateral_mps: float


class ViewReport(Struct, kw_only=True, frozen=True):
    """A 3D view."""

    viewer: str
    lag_ms: float | None
    """From the robot to the drawn frame and back, smoothed."""
    points: int
    """Points it is sent of each cloud, so that the lag stays under 200 ms."""
    period_ms: float
    """Time left between two updates, so that its page keeps time for its keys."""
    sent_bytes: int


class ViewerList(Struct, kw_only=True, frozen=True):
    """Connected pages and 3D views."""

    pages: list[PageReport]
    views: list[ViewReport]


class VisitorKey(Struct, kw_only=True, frozen=True):
    """The key of a link for visitors."""

    key: str


class VisitorLink(Struct, kw_only=True, frozen=True):
    """The way in for phones of visitors."""

    url: str
    """Of the page for visitors, with the key of this run; empty: there is no way in now."""
    code: list[str]
    """The same as a QR code: its rows from the top, `1` for each black module."""
    problem: str
    """Why phones do not get in by it, in words; empty: they do."""


class VisitorPress(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """One thing that a visitor presses."""

    button: Literal["start", "agree", "decline", "next"] | UnsetType | None = UNSET
    """One of `buttons` now."""
    ask: str | UnsetType | None = UNSET
    """Id of a question, one of `questions` now."""


class WebhookList(Struct, kw_only=True, frozen=True):
    """Every webhook, in the order of their making."""

    webhooks: list[WebhookReport]


class WebhookReport(Struct, kw_only=True, frozen=True):
    """Events of the timeline that are posted to a URL."""

    id: str
    url: str
    kinds: list[
        Literal[
            "accomplishment",
            "battery",
            "capacity",
            "desire",
            "emotion",
            "exploitation",
            "filter",
            "goal",
            "guard",
            "intention",
            "memory",
            "module",
            "overload",
            "percept",
            "restart",
            "rule",
            "solver",
            "stale",
            "tour",
        ]
    ]
    """Events of these kinds are posted."""
    subject: str
    """Only events about this: a desire class, a module, a person's code; empty: all."""
    state: Literal["delivering", "gone", "idle", "retrying"]
    waiting: int
    """Events that wait to be delivered, the one under way included."""
    delivered: int
    """Events delivered since the program was started."""
    dropped: int
    """Events given up since the program was started: too old, or too many waited."""
    problem: str
    """Why the last attempt failed, in words; empty: it did not."""
    succeeded: float | None
    """When an event was delivered last (robot's clock, s); null: never."""


class WebhookTrial(Struct, kw_only=True, frozen=True):
    """What became of an event that was posted for a trial."""

    delivered: bool
    status: int | None
    """The receiver's HTTP status; null: it did not answer."""
    problem: str
    """What went wrong, in words; empty: nothing."""


class WhatIf(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """What is supposed; all else is as it is."""

    desires: dict[str, SupposedDesire | None] | UnsetType = UNSET
    """By class; null: none of that class."""
    costs: dict[str, dict[str, float]] | UnsetType = UNSET
    """By strategy and resource."""
    capacities: dict[str, float] | UnsetType = UNSET
    """By resource."""


class Withdrawn(Struct, kw_only=True, frozen=True):
    """Desires to record that were withdrawn, and those that remain."""

    withdrawn: list[str]
    """Ids of the desires withdrawn."""
    remaining: list[Desire]
    """Those of motivations, which go on."""


class ZoneList(Struct, kw_only=True, frozen=True):
    """Every zone of the map."""

    zones: list[ZoneReport]


class ZoneReport(Struct, kw_only=True, frozen=True):
    """A part of the map to keep out of, or to drive slowly in."""

    name: str
    """What people call it; no two share one."""
    kind: Literal["keep_out", "slow"]
    polygon: list[tuple[float, float]]
    """Its corners, x and y on the map (m)."""
    speed: float
    """Share of the robot's greatest speed allowed in it; means nothing to `keep_out`."""


class ZoneRequest(Struct, kw_only=True, frozen=True, omit_defaults=True):
    """A part of the map with a rule for driving in it."""

    name: str
    """Unique name for people."""
    kind: Literal["keep_out", "slow"]
    """The robot keeps out of it, or drives slowly in it."""
    polygon: list[tuple[float, float]]
    """Its corners, x and y on the map (m)."""
    speed: float | UnsetType = UNSET
    """Share of the robot's greatest speed allowed in it; means nothing to `keep_out`."""


class ZonesRequest(Struct, kw_only=True, frozen=True):
    """Every zone of the map."""

    zones: list[ZoneRequest]


#: The live stream's messages by type.
LIVE: dict[str, type[Struct]] = {
    "battery": BatteryState,
    "costmap_info": GridInfo,
    "desires": Desires,
    "emotions": EmotionState,
    "events": EventList,
    "heard_words": HeardWords,
    "hello": Hello,
    "intention": IntentionReport,
    "jump": Jump,
    "landmarks": LandmarkList,
    "lanes": Lanes,
    "lanes_history": LanesHistory,
    "link": LinkReport,
    "load": LoadReport,
    "localization": LocalizationReport,
    "map_info": GridInfo,
    "memory": MemoryState,
    "navigation": NavigationModel,
    "notice": Notice,
    "perceived": PlacedPercepts,
    "persons": Persons,
    "places": PlaceList,
    "playback": PlaybackReport,
    "pong": Pong,
    "recorder": RecorderReport,
    "rules": RulesReport,
    "saliency": SaliencyMap,
    "salient_regions": SalientRegions,
    "speech": Speech,
    "status": Status,
    "tour": TourProgress,
    "zones": ZoneList,
}

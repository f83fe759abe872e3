"""TourGuide on the bench, on a floor without walls: what it desires is done, and visitors follow, or do not."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict

from app.attention.desires import Desire, DesireClass, DesireClasses, Source
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2, Pose3, wrap_angle
from app.maps.map_service import MapService, MapUnavailable
from app.messages import (
    Accomplishment,
    BatteryState,
    Exploitation,
    Face,
    Faces,
    HeardWords,
    Landmarks,
    LinkStatus,
    Localization,
    LoudNoise,
    NavigationStatus,
    Odometry,
    Person,
    Persons,
    PersonState,
    Place,
    Places,
    QRCode,
    QRCodes,
    SoundSource,
    SoundSources,
    Speech,
    TourButton,
    TourProgress,
    TourState,
    Twist,
)
from app.speech.text_spans import sentences_of
from app.tours.library import TourLibrary
from app.tours.model import Tour
from app.tours.run_library import RunLibrary
from app.tours.run_service import TourRunServer, TourRunService
from app.tours.store import TourStore
from tests.modules.fakes import Bench, drain

PORTS = {
    "faces": Faces,
    "persons": Persons,
    "sources": SoundSources,
    "noises": LoudNoise,
    "words": HeardWords,
    "codes": QRCodes,
    "speech": Speech,
    "odometry": Odometry,
    "localization": Localization,
    "places": Places,
    "landmarks": Landmarks,
    "navigation": NavigationStatus,
    "exploitation": Exploitation,
    "status": LinkStatus,
    "battery": BatteryState,
}
STEP_S = 0.2
SPEED_MPS, TURN_RADPS = 1.0, 1.0
#: Time (s) that a sentence takes.
SENTENCE_S = 1.5
#: Faces are seen so far (m), ahead.
SIGHT_M = 5.0


class Anything(BaseModel):
    """Parameters of any kind."""

    model_config = ConfigDict(extra="allow")


ACHIEVED = ("GoTo", "Say", "PointAt")
MAINTAINED = (
    *("RotateToHeading", "TrackFace", "LookAt", "Dock", "Express"),
    *("LocateFaces", "LocateVoices", "DetectNoises", "FindQRCodes", "SLAM", "ListenForWords", "TrackPersons"),
)
CLASSES = (
    *(DesireClass(name, name, name, Anything, achievement=True) for name in ACHIEVED),
    *(DesireClass(name, name, name, Anything) for name in MAINTAINED),
)


@dataclass(slots=True)
class Visitor:
    """A person at ``x``, ``y`` (m) who follows the robot to ``keeps_m`` from it at ``mps``; ``looks`` at it or away."""

    x: float
    y: float
    mps: float = 1.0
    keeps_m: float = 1.2
    looks: bool = True

    def step(self, robot: Pose2) -> None:
        """Go nearer."""
        left = math.dist((self.x, self.y), (robot.x, robot.y))
        if left > self.keeps_m:
            share = min(self.mps * STEP_S / left, 1 - self.keeps_m / left)
            self.x += share * (robot.x - self.x)
            self.y += share * (robot.y - self.y)


class LabMaps:
    """A MapServer of which the guide asks the name, and to load one of the maps that it ``has``."""

    def __init__(self) -> None:
        self.name = "lab"
        self.has: tuple[str, ...] = ("lab",)
        self.loaded: list[tuple[str, Pose2 | None]] = []

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        if name not in self.has:
            raise MapUnavailable(f"there is no map {name}")
        self.name = name
        self.loaded.append((name, X_MB))


class LedLab:
    """``async with LedLab(tmp_path, tour, places) as lab``; visitors, battery and the rest are attributes to set."""

    def __init__(self, folder: Path, tour: Tour, places: Mapping[str, Pose2]) -> None:
        self.tour = tour
        self.places = tuple(Place(id_, id_, at.x, at.y, at.theta) for id_, at in places.items())
        self.workspace = IntentionWorkspace(DesireClasses(CLASSES), lambda: self.bench.clock.now())
        self.timeline = Timeline(500, lambda: self.bench.clock.now())
        self.runs = RunLibrary(folder / "runs")
        self.service = TourRunService()
        tours = TourStore(TourLibrary(folder / "tours"))
        if tour.id not in tours.names():
            tours.create(tour)
        self.maps = LabMaps()
        maps = MapService()
        maps.attach(self.maps)  # type: ignore[arg-type]  # what the guide asks of it
        self.bench = Bench(
            "app.modules.motivations.tour_guide.tour_guide:TourGuide",
            inputs=PORTS,
            outputs={"progress": TourProgress},
            services={
                IntentionWorkspace: self.workspace,
                Timeline: self.timeline,
                RunLibrary: self.runs,
                TourRunService: self.service,
                TourStore: tours,
                MapService: maps,
            },
        )
        self.robot = Pose2()
        self.visitors: list[Visitor] = []
        self.battery, self.e_stop, self.by_hand, self.blocked = 0.9, False, False, False
        self.localization, self.speaks, self.laser = "tracking", False, True
        #: Where the way to a goal leads first, if not straight there.
        self.detour: tuple[float, float] | None = None
        self.states: list[TourState] = ["idle"]
        self.said: list[str] = []
        self.driven_m = 0.0
        self._fed: tuple[object, ...] = ()
        self._spoken_s: dict[str, float] = {}

    async def __aenter__(self) -> LedLab:
        await self.bench.__aenter__()
        self._progress = self.bench.listen("progress")
        await self.live(1.0)
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.bench.__aexit__(*error)

    @property
    def server(self) -> TourRunServer:
        return self.service.server

    @property
    def progress(self) -> TourProgress:
        return self.server.progress

    def start(self, *, waits: bool = False, language: str = "en") -> None:
        self.server.start_tour(self.tour, language=language, waits=waits)

    def press(self, button: TourButton) -> None:
        self.server.press(button)

    def desired(self, cls: str) -> Desire | None:
        """The guide's desire of a class."""
        found = [each for each in self.workspace.desires() if each.cls == cls and each.source.name == "Tested"]
        return found[0] if found else None

    def moving(self) -> list[str]:
        """Classes of its desires that move the base."""
        return [cls for cls in ("GoTo", "RotateToHeading", "Dock") if self.desired(cls) is not None]

    def hear(self, text: str) -> None:
        now = self.bench.clock.now()
        heard = HeardWords(
            now, text, False, confidence=1.0, likeliest=text, direction=(1, 0, 0), words=(text,), language="en"
        )
        self.bench.feed("words", heard)

    def show(self, *codes: QRCode) -> None:
        """A camera reads ``codes``."""
        now = self.bench.clock.now()
        self.bench.feed("codes", QRCodes(now, "kinect", 640, 480, Pose3.identity(), codes))

    def clap(self) -> None:
        """A loud noise; where a visitor speaks, it is a call."""
        self.bench.feed("noises", LoudNoise(self.bench.clock.now(), 20.0, -10.0))

    def send(self, x: float, y: float, intensity: float = 8.0) -> Desire:
        """An operator's goal."""
        source = Source("operator", "ada")
        return self.workspace.add("GoTo", intensity=intensity, utility=4, params={"x": x, "y": y}, source=source)

    async def live(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            await self._step()

    async def until(self, *states: TourState, limit_s: float = 600.0, each: Callable[[], None] = lambda: None) -> None:
        """Live until one of ``states``."""
        for _ in range(round(limit_s / STEP_S)):
            if self.progress.state in states:
                return
            each()
            await self._step()
        raise AssertionError(f"never {states}: {self.states}, {self.progress.reason}")

    async def _step(self) -> None:
        now = self.bench.clock.now()
        self._act(now)
        for visitor in self.visitors:
            visitor.step(self.robot)
        feed, zero = self.bench.feed, Twist(now, 0.0, 0.0)
        feed("odometry", Odometry(now, self.robot, 0.0, 0.0))
        if self.by_hand:
            feed("exploitation", Exploitation(now, "Teleop", zero))
        pose = (round(self.robot.x), round(self.robot.y), round(self.robot.theta))
        state_now = (self.e_stop, self.battery, self.localization, self.maps.name, pose)
        if state_now != self._fed:
            self._fed = state_now
            feed("places", Places(now, self.places))
            feed("localization", self._localized(now))
            feed("status", LinkStatus(now, "idle", "", self.e_stop, None, zero, 1.0))
            feed("battery", BatteryState(now, self.battery, 24.0, -1.0, charging=False, remaining_s=None))
        feed("faces", Faces(now, "kinect", 640, 480, Pose3.identity(), tuple(self._faces())))
        if self.desired("TrackPersons") is not None:
            feed("persons", Persons(now, tuple(self._persons(now))))
        if self.speaks:
            feed("sources", SoundSources(now, (0.0, 0.0, 1.0), (self._voice(),)))
        await self.bench.clock.sleep(STEP_S)
        for progress in drain(self._progress):
            if progress.state != self.states[-1]:
                self.states.append(progress.state)

    def _localized(self, now: float) -> Localization:
        return Localization(now, Pose2(), self.robot, np.eye(3), self.localization, 1.0, self.maps.name)

    def _faces(self) -> Iterable[Face]:
        for track, visitor in enumerate(self.visitors, 1):
            p_B = self.robot.inverse() @ Pose2(visitor.x, visitor.y)
            far = math.hypot(p_B.x, p_B.y)
            if visitor.looks and p_B.x > 0 and far <= SIGHT_M:
                corners = np.zeros((5, 2), np.float32)
                yield Face(track, 0.9, (0, 0, 9, 9), corners, (p_B.x, p_B.y, 1.6), np.eye(3), far, 0.1)

    def _persons(self, now: float) -> Iterable[Person]:
        """By their legs, where the robot has its laser."""
        for track, visitor in enumerate(self.visitors, 1):
            if self.laser and (self.robot.inverse() @ Pose2(visitor.x, visitor.y)).x > 0:
                yield person(track, visitor.x, visitor.y, last_seen=now)

    def _voice(self) -> SoundSource:
        p_B = self.robot.inverse() @ Pose2(self.visitors[0].x, self.visitors[0].y)
        far = math.hypot(p_B.x, p_B.y)
        return SoundSource(1, (p_B.x / far, p_B.y / far, 0.0), 0.5, -20.0, True, 0.9, math.nan, math.nan)

    def _act(self, now: float) -> None:
        """Whatever is desired most of each class is done."""
        if self.e_stop or self.by_hand:
            return
        wanted = self.workspace.strongest()
        if (go := wanted.get("GoTo")) is not None:
            self._go(now, go)
        elif (turn := wanted.get("RotateToHeading")) is not None:
            left = wrap_angle(turn.params["heading"] - self.robot.theta)
            step = math.copysign(min(abs(left), TURN_RADPS * STEP_S), left)
            self.robot = Pose2(self.robot.x, self.robot.y, wrap_angle(self.robot.theta + step))
        texts = [desire for desire in self.workspace.desires() if desire.cls == "Say"]
        if texts:
            self._say(now, texts[0])
        for desire in self.workspace.desires():
            if desire.cls == "PointAt":
                self.workspace.accomplish(Accomplishment(now, desire.id, "PointAt", "done"))

    def _go(self, now: float, go: Desire) -> None:
        x, y = self.detour or (go.params["x"], go.params["y"])
        left = math.dist((x, y), (self.robot.x, self.robot.y))
        state = "waiting" if self.blocked else "following"
        self.bench.feed("navigation", NavigationStatus(now, "PlanAndFollowPath", state, "", Pose2(x, y)))
        if self.blocked:
            return
        if left < 0.1 and self.detour is not None:
            self.detour = None
            return
        if left < 0.1:
            heading = go.params.get("heading")
            theta = self.robot.theta if heading is None else heading
            self.robot = Pose2(x, y, theta)
            self.workspace.accomplish(Accomplishment(now, go.id, "PlanAndFollowPath", "done"))
            return
        step = min(SPEED_MPS * go.params.get("speed", 1.0) * STEP_S, left)
        self.driven_m += step
        heading = math.atan2(y - self.robot.y, x - self.robot.x)
        self.robot = Pose2(self.robot.x + step * math.cos(heading), self.robot.y + step * math.sin(heading), heading)

    def _say(self, now: float, desire: Desire) -> None:
        text, spoken_s = desire.params["text"], self._spoken_s.get(desire.id, 0.0)
        spans = sentences_of(text)
        number = int(spoken_s / SENTENCE_S)
        if desire.id not in self._spoken_s:
            self.said.append(text)
        self._spoken_s[desire.id] = spoken_s + STEP_S
        if number >= len(spans):
            self.workspace.accomplish(Accomplishment(now, desire.id, "Say", "done"))
            return
        begin, end = spans[number]
        speech = Speech(
            now, "speaking", text[begin:end], 0, 1, viseme="open", language="en", desire=desire.id, waiting=0
        )
        self.bench.feed("speech", speech)


def person(track: int, x: float, y: float, *, state: PersonState = "confirmed", last_seen: float = 0.0) -> Person:
    """A person at ``x``, ``y`` (m in odom) whose legs are seen."""
    return Person(
        track,
        track if state in ("confirmed", "lost") else None,
        state,
        p_OP=(x, y, 1.6),
        v_O=(0.0, 0.0),
        covariance=np.eye(2),
        face=None,
        voice=None,
        legs=state != "lost",
        speaking=False,
        last_seen=last_seen,
    )


def failed(lab: LedLab, cls: str, why: str = "it cannot") -> None:
    """The guide's desire of this class fails."""
    desire = lab.desired(cls)
    assert desire is not None
    lab.workspace.accomplish(Accomplishment(lab.bench.clock.now(), desire.id, "Tested", "failed", why))

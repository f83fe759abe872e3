"""The scene of four people for ten minutes at little cost: laser, odometry and truth simulated, faces and voices drawn.

The robot drives its legs of ``config/scenarios/people.yaml`` in the simulated world, without cameras and microphones.
Faces are seen by the shares that docs/faces.md measures (Kinect within 5 m of its 57°; panorama by distance) of people
who look within 60° of the robot and whom nobody hides; directions err by 0.7° and 1.1°, distances of the Kinect as its
depths, those of the panorama by the person's height. The face tracker numbers them. Of voices, while they sound and
from 0.3 s on, nine of ten are located, with an error of 1.5° for a sentence and 1° more each time. What is worn is seen
with its light and noise, and a tenth of something else. The map is of the same drive without people.
"""

from __future__ import annotations

import math
import pickle
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base import paths
from app.base.geometry import Pose2, Pose3, wrap_angle
from app.experiments.script import StickCommand, Waypoint, in_the_way, load_script, steer
from app.experiments.simulated import simulated_program
from app.messages import (
    Face,
    Faces,
    GroundTruth,
    LaserScan,
    Localization,
    OccupancyGrid,
    Odometry,
    PersonTruth,
    SoundSource,
    SoundSources,
    Twist,
    read_only,
)
from app.modules.perception.faces.face_position import FaceSighting
from app.modules.perception.faces.face_tracks import FaceTracks
from app.modules.perception.faces.yunet import Detection
from app.modules.perception.height_prior import range_from_height
from app.robots.factory import simulated_parts
from app.robots.simulated import link_protocol
from app.robots.simulated.acoustics.sound_library import ClipLibrary
from app.robots.simulated.lockstep import without_threads
from app.robots.simulated.lockstep_world import LockstepWorld
from app.robots.simulated.scenery.scenario_config import ScenarioConfig, load_scenario
from benchmarks.people_scene import SCANS, SCENARIO, Torsos, Truth, Worn, scenario_of

#: Periods (s) of images of both cameras, of sounds, and of the truth.
KINECT_S, PANORAMA_S, SOUND_S, TRUTH_S = 0.267, 0.4, 0.08, 0.05
KINECT_REACH_M, KINECT_HALF_RAD = 5.0, math.radians(28.5)
PANORAMA_HALF_RAD = math.radians(85)
#: Shares of faces found in the panorama, by distance (docs/faces.md).
DISTANCES_M, FOUND = (2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0), (1.0, 0.88, 0.63, 0.38, 0.25, 0.12, 0.0)
LOOKS_RAD, BODY_M = math.radians(60), 0.22
_AHEAD = (-math.pi / 2, 0.0, -math.pi / 2)
X_BKINECT = Pose3.from_translation_rpy((0.1, 0.0, 1.3), _AHEAD)
X_BPANORAMA = Pose3.from_translation_rpy((0.1, 0.0, 0.89), _AHEAD)
P_BA = (0.0, 0.0, 0.7)
_LANDMARKS: NDArray[np.float32] = read_only(np.zeros((5, 2), np.float32))


class Drive:
    """The robot in its world, driving its legs again and again; the newest of what its streams gave."""

    def __init__(self, scenario: ScenarioConfig | None) -> None:
        program = simulated_program(scenario=paths.config_dir() / "scenarios" / SCENARIO)
        robot, world, _ = simulated_parts(program.body)
        self.scans: list[LaserScan] = []
        self.odometry: list[Odometry] = []
        self.newest_scan: LaserScan | None = None
        self.X_WB = Pose2(robot.start.x, robot.start.y, math.radians(robot.start.heading_deg))
        self.world = LockstepWorld(without_threads(robot, cameras=False), world, scenario, self._take)
        self.world.demand("hokuyo", math.inf)
        self.world.demand("ground_truth", math.inf)
        self._limits = robot.limits
        self._legs = load_script(program.scenario)
        self._leg, self._until, self._turning, self._stuck = 0, -1.0, False, 0
        self.turns = 0

    @property
    def now(self) -> float:
        """Simulated seconds."""
        return self.turns * self.world.turn_s

    def turn(self) -> None:
        """Advance by one turn of the world."""
        self.scans, self.odometry = [], []
        self.turns += 1
        self.world.lockstep(self.now, 0.0)
        if self.turns % round(0.05 / self.world.turn_s) == 0:
            sticks = self._sticks(self._legs[self._leg])
            linear, angular = sticks.linear * self._limits.linear_mps, sticks.angular * self._limits.angular_radps
            self.world.accept(link_protocol.request(Twist(self.now, linear, angular)))

    def _sticks(self, leg: Waypoint) -> StickCommand:
        if leg.pause is not None:
            self._until = self.now + leg.pause if self._until < 0 else self._until
            if self.now >= self._until:
                self._next()
            return StickCommand()
        sticks = steer(leg, self.X_WB, self._turning)
        self._turning = sticks.turning
        blocked = not sticks.turning and self.newest_scan is not None and in_the_way(self.newest_scan) is not None
        self._stuck = self._stuck + 1 if blocked else 0
        if sticks.done or self._stuck > 200:
            self._next()
            return StickCommand()
        return StickCommand() if blocked else sticks

    def _next(self) -> None:
        self._leg, self._until, self._turning, self._stuck = (self._leg + 1) % len(self._legs), -1.0, False, 0

    def _take(self, stream: str, message: object) -> None:
        match message:
            case LaserScan():
                self.newest_scan = message
                self.scans.append(message)
            case Odometry():
                self.odometry.append(message)
            case GroundTruth():
                self.X_WB = message.X_WB


def model(seconds: float, path: Path, seed: int = 1) -> None:
    """Write so many seconds of the scene to ``path``, as ``people_scene.record`` does."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = load_scenario(scenario_of(seed, Path(folder)))
    grid = _mapped(80.0)
    with path.open("wb") as file:
        for message in _perceived(Drive(scenario), grid, seconds, np.random.default_rng(seed)):
            pickle.dump(message, file, protocol=5)


def _mapped(seconds: float) -> OccupancyGrid:
    """The map in the world's frame, of what the laser meets twice where nobody is."""
    drive, size = Drive(None), (340, 460)
    hits = np.zeros(size, np.int32)
    count = 0
    while drive.now < seconds:
        drive.turn()
        for scan in drive.scans:
            count += 1
            if count % 10:
                continue
            angles = scan.angle_min + scan.angle_increment * np.arange(scan.ranges.size)
            met = scan.ranges < scan.range_max
            in_L = np.stack((np.cos(angles), np.sin(angles), np.zeros_like(angles)), axis=-1) * scan.ranges[:, None]
            points = (drive.X_WB.to_pose3() @ scan.X_BL).transform(in_L[met].astype(np.float64))[:, :2]
            columns, rows = np.floor((points + 0.5) / 0.05).astype(np.intp).T
            inside = (rows >= 0) & (columns >= 0) & (rows < size[0]) & (columns < size[1])
            np.add.at(hits, (rows[inside], columns[inside]), 1)
    drive.world.close()
    cells = np.where(hits >= 2, 100, 0).astype(np.int8)
    return OccupancyGrid(0.0, "map", read_only(cells), 0.05, (-0.5, -0.5), 1)


def _perceived(drive: Drive, grid: OccupancyGrid, seconds: float, rng: np.random.Generator) -> Iterator[object]:
    library = ClipLibrary(16_000, -32.0)
    faces, senses = FaceTracks(), _Senses(rng)
    shirts = {actor.name: actor.config.shirt for actor in drive.world.scenario_state.actors}
    due = dict.fromkeys(("kinect", "panorama", "sound", "truth"), 0.0)
    scans = 0
    X_OB = Pose2()
    yield grid
    while drive.now < seconds:
        drive.turn()
        now, X_WB, people = drive.now, drive.X_WB, drive.world.scenario_state.people
        for odometry in drive.odometry:
            X_OB = odometry.X_OB
            yield odometry
        for scan in drive.scans:
            scans += 1
            if scans % SCANS == 0:
                X_MO = X_WB @ X_OB.inverse()
                yield Localization(now, X_MO, X_WB, read_only(1e-4 * np.eye(3)), "tracking", overlap=1.0, map="")
                yield scan
        for camera, period_s in (("kinect", KINECT_S), ("panorama", PANORAMA_S)):
            if now >= due[camera]:
                due[camera] += period_s
                yield from senses.look(now, camera, (X_WB, X_OB), people, faces, shirts)
        talking, speaking = _speech(drive, library)
        if now >= due["sound"]:
            due["sound"] += SOUND_S
            yield senses.listen(now, X_WB, people, {name: talking[name] for name in speaking})
        if now >= due["truth"]:
            due["truth"] += TRUTH_S
            yield Truth(now, X_WB, people, frozenset(speaking), talking)
    drive.world.close()


def _speech(drive: Drive, library: ClipLibrary) -> tuple[dict[str, str], set[str]]:
    """Sentences by who says them now, and who of these sounds now."""
    state = drive.world.scenario_state
    talking, speaking = {}, set()
    for cue in state.cues:
        after_s = state.time_s - cue.begin_s
        if cue.kind == "speech" and 0 <= after_s < library.get(cue.clip, cue.person).seconds:
            talking[cue.person] = cue.name
            if library.get(cue.clip, cue.person).active(after_s):
                speaking.add(cue.person)
    return talking, speaking


class _Senses:
    """What cameras and microphones give."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        #: Of its own, so that what faces and voices are is not changed by what is worn.
        self._cloth = np.random.default_rng(7)
        #: By sentence: its track, error (rad), and when it began.
        self._voices: dict[str, tuple[int, float, float]] = {}

    def look(
        self,
        stamp: float,
        camera: str,
        poses: tuple[Pose2, Pose2],
        people: tuple[PersonTruth, ...],
        tracks: FaceTracks,
        shirts: Mapping[str, tuple[int, int, int]],
    ) -> Iterator[object]:
        """Faces and torsos in one image, the robot at ``poses`` X_WB and X_OB."""
        X_WB, X_OB = poses
        X_BC = X_BKINECT if camera == "kinect" else X_BPANORAMA
        seen = [person for person in people if self._found(person, camera, X_WB, people)]
        sightings = [self._sighting(person, camera, X_WB, X_BC) for person in seen]
        placed = tracks.see(stamp, camera, sightings, X_OB.to_pose3())
        found = tuple(
            _face(sighting, face.track, face.p_BF, face.covariance)
            for sighting, face in zip(sightings, placed, strict=True)
        )
        pixels = {face.track: _worn(self._rng, shirts[person.name]) for person, face in zip(seen, placed, strict=True)}
        yield Faces(stamp, camera, width=640, height=480, X_BC=X_BC, faces=found)
        yield Torsos(stamp, camera, pixels)
        half = KINECT_HALF_RAD if camera == "kinect" else PANORAMA_HALF_RAD
        worn = []
        for person in people:
            away, azimuth = _polar(person, X_WB)
            if abs(azimuth) < half and not _hidden(person, X_WB, people):
                place = (away * math.cos(azimuth), away * math.sin(azimuth))
                worn.append((place, _worn(self._cloth, shirts[person.name])))
        yield Worn(stamp, camera, X_BC, tuple(worn))

    def _found(self, person: PersonTruth, camera: str, X_WB: Pose2, people: tuple[PersonTruth, ...]) -> bool:
        away, azimuth = _polar(person, X_WB)
        towards = math.atan2(X_WB.y - person.y, X_WB.x - person.x)
        if abs(wrap_angle(person.heading - towards)) > LOOKS_RAD or _hidden(person, X_WB, people):
            return False
        if camera == "kinect":
            return abs(azimuth) < KINECT_HALF_RAD and 0.5 < away < KINECT_REACH_M and self._rng.random() < 0.97
        return abs(azimuth) < PANORAMA_HALF_RAD and bool(self._rng.random() < np.interp(away, DISTANCES_M, FOUND))

    def _sighting(self, person: PersonTruth, camera: str, X_WB: Pose2, X_BC: Pose3) -> FaceSighting:
        x, y = X_WB.inverse().transform(np.array((person.mouth[0], person.mouth[1]))).tolist()
        towards = np.array((x, y, 0.916 * person.height_m)) - X_BC.translation
        away = float(np.linalg.norm(towards))
        sigma = math.radians(0.7 if camera == "kinect" else 1.1)
        ray = towards / away + self._rng.normal(0, sigma, 3)
        ray /= np.linalg.norm(ray)
        if camera == "kinect":
            range_sigma_m = math.hypot(0.01, 0.0012 + 0.0019 * (away - 0.4) ** 2)
            range_m = away + self._rng.normal(0, range_sigma_m)
        else:
            direction = (float(ray[0]), float(ray[1]), float(ray[2]))
            range_m, range_sigma_m = range_from_height(
                direction, float(X_BC.translation[2]), "face", elevation_sigma=sigma
            )
        # Boxes of equal angles; of an image in which columns are azimuths.
        box = (320 - 600 * math.atan2(y, x), 240 - 600 * math.asin(float(ray[2])), 90 / away, 110 / away)
        return FaceSighting(
            Detection(0.9, box, _LANDMARKS),
            X_BC.translation,
            ray=ray,
            angle_sigma=sigma,
            range_m=range_m,
            range_sigma_m=range_sigma_m,
            measured=camera == "kinect",
        )

    def listen(
        self, stamp: float, X_WB: Pose2, people: tuple[PersonTruth, ...], speaking: Mapping[str, str]
    ) -> SoundSources:
        """Voices of those ``speaking``, with their sentences."""
        sources = []
        for person in people:
            if person.name not in speaking or _behind_wall(person, X_WB):
                continue
            sentence = speaking[person.name]
            if sentence not in self._voices:
                self._voices[sentence] = (len(self._voices) + 1, self._rng.normal(0, math.radians(1.5)), stamp)
            track, error, began = self._voices[sentence]
            if stamp - began < 0.3 or self._rng.random() > 0.9:
                continue
            azimuth = _polar(person, X_WB)[1] + error + self._rng.normal(0, math.radians(1.0))
            direction = (math.cos(azimuth), math.sin(azimuth), 0.0)
            sources.append(
                SoundSource(track, direction, 0.5, -35.0, active=True, speech=0.9, range_m=3.0, range_sigma_m=1.0)
            )
        return SoundSources(stamp, P_BA, tuple(sources))


def _face(sighting: FaceSighting, track: int, p_BF: NDArray[np.float64], covariance: NDArray[np.float64]) -> Face:
    x, y, z = p_BF.tolist()
    return Face(
        track,
        sighting.face.score,
        box=sighting.face.box,
        landmarks=_LANDMARKS,
        p_BF=(x, y, z),
        covariance=read_only(covariance.copy()),
        range_m=sighting.range_m,
        range_sigma_m=sighting.range_sigma_m,
    )


def _worn(rng: np.random.Generator, shirt: tuple[int, int, int]) -> NDArray[np.uint8]:
    light = rng.uniform(0.75, 1.1)
    colors = light * np.array(shirt) + rng.normal(0, 8, (80, 3))
    colors[:8] = rng.uniform(0, 255, 3)
    return np.clip(colors, 0, 255).astype(np.uint8)


def _hidden(person: PersonTruth, X_WB: Pose2, people: tuple[PersonTruth, ...]) -> bool:
    """Whether a wall or somebody else hides a person."""
    away, azimuth = _polar(person, X_WB)
    for other in people:
        if other.name != person.name:
            nearer, aside = _polar(other, X_WB)
            if nearer < away - 0.3 and abs(wrap_angle(aside - azimuth)) < math.atan2(BODY_M, nearer):
                return True
    return _behind_wall(person, X_WB)


def _polar(person: PersonTruth, X_WB: Pose2) -> tuple[float, float]:
    x, y = X_WB.inverse().transform(np.array((person.x, person.y))).tolist()
    return math.hypot(x, y), math.atan2(y, x)


def _behind_wall(person: PersonTruth, X_WB: Pose2) -> bool:
    """Whether the wall between lab and corridor (y = 9.2 m, doors at x = 12.3 and 19 m) hides a person."""
    if (person.y > 9.2) == (X_WB.y > 9.2):
        return False
    x = X_WB.x + (person.x - X_WB.x) * (9.2 - X_WB.y) / (person.y - X_WB.y)
    return all(abs(x - door) > 0.5 for door in (12.3, 19.0))

"""Four people in the simulated lab, perceived for some minutes, with the truth: what the benchmark of persons replays.

The whole program runs in virtual time in ``config/scenarios/people.yaml``, with faces, voices and map at the rates of
``people_strategies.yaml``; what it publishes is kept, with the world's truth and the colours below each face.
"""

from __future__ import annotations

import asyncio
import math
import pickle
import tempfile
import zlib
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3
from app.experiments.script import ScriptBlocked, drive_script, load_script
from app.experiments.simulated import simulated_program
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import Faces, Image, LaserScan, Localization, OccupancyGrid, Odometry, PersonTruth, SceneTruth
from app.modules.perception.people.torso_color import LEGS_ASIDE_M, torso_pixels

Place = tuple[float, float, float]

SCENARIO = "people.yaml"
_OPERATOR = Source("operator", "the benchmark")
#: One scan of so many is kept, and a map every so many seconds.
SCANS, MAP_S = 4, 5.0
#: Of the depth of a picture one of so many rows and columns is kept.
DEPTH_STEP = 4
#: A torso is looked at within this distance (m) of the person.
TORSO_M = 0.25
#: Modules that neither perceive people nor drive.
WITHOUT = (
    "QRCodeDetector", "CameraStream", "PanoramaStream", "PointCloudBuilder", "AudioStream", "PerceptPlacer",
    "SoundClassifier", "DarknessDetector", "WordRecognizer", "PerceptEvents", "EgoSphere", "LoudNoiseDetector",
    "PersonTracker",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Truth:
    """Who is where at ``stamp``, the robot at ``X_WB``.

    ``speaking``: names of those who sound now; ``talking``: of those within a sentence, with its name.
    """

    stamp: float
    X_WB: Pose2
    people: tuple[PersonTruth, ...]
    speaking: frozenset[str]
    talking: dict[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class Torsos:
    """Colours (N, 3) uint8 below faces of one image, by track."""

    stamp: float
    frame: str
    pixels: dict[int, NDArray[np.uint8]]


@dataclass(frozen=True, slots=True, eq=False)
class Worn:
    """Colours (N, 3) uint8 of the torsos that a camera has before it: a picture for those who draw none.

    ``people``: where each is (m, over ground in ``base_link``), and what is worn.
    """

    stamp: float
    frame: str
    X_BC: Pose3
    people: tuple[tuple[tuple[float, float], NDArray[np.uint8]], ...]

    @property
    def measured(self) -> bool:
        """Whether the camera measures depth."""
        return self.frame == "kinect"

    def torsos(self, places: Mapping[int, Place]) -> dict[int, NDArray[np.uint8]]:
        """What is worn at ``places`` (m in ``base_link``) of faces that are not seen."""
        found = {}
        for track, place in places.items():
            near = min(self.people, key=lambda person: math.dist(person[0], place[:2]), default=None)
            if near is not None and math.dist(near[0], place[:2]) <= TORSO_M:
                found[track] = near[1]
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """An image in which faces were looked for, small enough to be kept.

    ``color`` is its JPEG, ``depth`` every ``DEPTH_STEP``-th row and column of its depth, compressed.
    """

    stamp: float
    frame: str
    color: bytes
    depth: bytes | None
    camera: CameraModel | FisheyeModel
    X_BC: Pose3

    @staticmethod
    def of(image: Image) -> Picture:
        """The picture of ``image``."""
        _, color = cv2.imencode(".jpg", image.color[..., ::-1], (cv2.IMWRITE_JPEG_QUALITY, 90))
        depth = None if image.depth is None else zlib.compress(image.depth[::DEPTH_STEP, ::DEPTH_STEP].tobytes(), 1)
        return Picture(image.stamp, image.frame, color.tobytes(), depth, image.camera, image.X_BC)

    @property
    def measured(self) -> bool:
        """Whether the camera measures depth."""
        return self.depth is not None

    def torsos(self, places: Mapping[int, Place]) -> dict[int, NDArray[np.uint8]]:
        """What is worn below ``places`` (m in ``base_link``) of faces that are not seen."""
        image = self.image()
        found = {track: torso_pixels(image, place, LEGS_ASIDE_M) for track, place in places.items()}
        return {track: pixels for track, pixels in found.items() if pixels is not None}

    def image(self) -> Image:
        """The image again."""
        decoded = cv2.imdecode(np.frombuffer(self.color, np.uint8), cv2.IMREAD_COLOR)
        assert decoded is not None
        color = decoded[..., ::-1]
        depth = None
        if self.depth is not None:
            height, width = color.shape[:2]
            rows = -(-height // DEPTH_STEP)
            small = np.frombuffer(zlib.decompress(self.depth), np.uint16).reshape(rows, -1)
            depth = small.repeat(DEPTH_STEP, 0).repeat(DEPTH_STEP, 1)[:height, :width]
        return Image(self.stamp, self.frame, np.asarray(color, np.uint8), depth, self.camera, self.X_BC)


def scenario_of(seed: int, folder: Path) -> Path:
    """The scenario of ``seed``, written into ``folder``: that of the repository for 1.

    For others people wait 0.6 to 1.5 times as long, walk 0.85 to 1.15 times as fast, and the robot's pauses differ
    likewise: the same rooms and habits, but who meets, hides and talks over whom is another matter each time.
    """
    path = paths.config_dir() / "scenarios" / SCENARIO
    if seed == 1:
        return path
    rng = np.random.default_rng(seed)
    document = yaml.safe_load(path.read_text())
    document["seed"] = seed
    for line in [line for person in document["people"] for line in person["script"]] + document["drive"]:
        for key in {"wait", "pause"} & line.keys():
            line[key] = round(line[key] * float(rng.uniform(0.6, 1.5)), 1)
        if "walk" in line and "speed" in line:
            line["speed"] = round(line["speed"] * float(rng.uniform(0.85, 1.15)), 2)
    varied = folder / f"people-{seed}.yaml"
    varied.write_text(yaml.safe_dump(document, sort_keys=False))
    return varied


def record(seconds: float, path: Path, seed: int = 1) -> None:
    """Run the scene of ``seed`` so long (simulated s) and write to ``path`` what is perceived, in its order.

    Until it is whole it is beside it, so that a scene that was cut off is not taken for one.
    """
    part = path.with_name(f"{path.name}.part")
    with tempfile.TemporaryDirectory() as folder:
        program = simulated_program(scenario=scenario_of(seed, Path(folder)))
        own = {"strategies": [Path(__file__).with_name("people_strategies.yaml")]}
        program_of = program.configuration.program.model_copy(update=own)
        configuration = replace(program.configuration, program=program_of)
        with part.open("wb") as file:

            async def script(run: WorldRun) -> None:
                await _perceive(run, seconds, file, program.scenario)

            run_in_world(configuration, program.body, script, cameras=True, microphones=True, without=WITHOUT)
        part.replace(path)


def recorded(path: Path) -> Iterator[object]:
    """What :func:`record` wrote, in its order; of a file cut off, what is whole."""
    with path.open("rb") as file:
        while True:
            try:
                yield pickle.load(file)
            except (EOFError, pickle.UnpicklingError):
                return


async def _perceive(run: WorldRun, seconds: float, file: BinaryIO, scenario: Path) -> None:
    system, link = run.system, run.link
    channels = system.graph.channels
    images: deque[Image] = deque(maxlen=8)
    counts = {"scan": 0}
    last_map = -MAP_S

    def keep(message: object) -> None:
        pickle.dump(message, file, protocol=5)

    def keep_scan(scan: LaserScan) -> None:
        counts["scan"] += 1
        if counts["scan"] % SCANS == 0:
            keep(scan)

    def keep_map(grid: OccupancyGrid) -> None:
        nonlocal last_map
        if grid.stamp - last_map >= MAP_S:
            last_map = grid.stamp
            keep(grid)

    def keep_faces(faces: Faces) -> None:
        image = next((i for i in images if i.frame == faces.frame and i.stamp == faces.stamp), None)
        if image is not None:
            found = {face.track: torso_pixels(image, face.p_BF) for face in faces.faces}
            keep(Torsos(faces.stamp, faces.frame, {t: p for t, p in found.items() if p is not None}))
        keep(faces)
        if image is not None:
            keep(Picture.of(image))

    def keep_truth(truth: SceneTruth) -> None:
        sounds = [sound for sound in truth.sounds if sound.kind == "speech"]
        keep(
            Truth(
                truth.stamp,
                link.true_pose(),
                truth.people,
                frozenset(sound.person for sound in sounds if sound.active),
                {sound.person: sound.name for sound in sounds},
            )
        )

    for name in ("kinect", "panorama"):
        channels[name].observe(images.append)
    channels["faces"].observe(keep_faces)
    channels["sound_sources"].observe(keep)
    channels["scan"].observe(keep_scan)
    channels["map"].observe(keep_map)
    channels["localization"].observe(keep)
    channels["odometry"].observe(keep)
    link.attach("scene_truth", keep_truth)
    link.demand("scene_truth", math.inf)
    for cls in ("LocateFaces", "LocateVoices", "SLAM"):
        system.workspace.add(cls, intensity=5, utility=4, source=_OPERATOR)
    driving = asyncio.create_task(_drive(run, scenario), name="drive")
    until = system.clock.now() + seconds
    while system.clock.now() < until:
        await system.clock.sleep(5.0)
        print(f"{seconds - (until - system.clock.now()):.0f} s", end=" ", flush=True)
        file.flush()
    driving.cancel()
    await asyncio.wait({driving})


async def _drive(run: WorldRun, scenario: Path) -> None:
    """Drive the scenario's legs again and again; one that people block is given up."""
    legs = load_script(scenario)
    while True:
        for leg in legs:
            try:
                await drive_script(run.system, [leg])
            except ScriptBlocked as blocked:
                print(blocked)


Recorded = Faces | Torsos | Picture | Worn | LaserScan | Odometry | Localization | OccupancyGrid | Truth

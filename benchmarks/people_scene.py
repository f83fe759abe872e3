"""Four people in the simulated lab, perceived for some minutes, with the truth: what the benchmark of persons replays.

The whole program runs in virtual time in ``config/scenarios/people.yaml``, with faces, voices and map at the rates of
``people_strategies.yaml``; what it publishes is kept, with the world's truth and the colours below each face.
"""

from __future__ import annotations

import asyncio
import math
import pickle
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import Pose2
from app.experiments.script import ScriptBlocked, drive_script, load_script
from app.experiments.simulated import simulated_program
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import Faces, Image, LaserScan, Localization, OccupancyGrid, Odometry, PersonTruth, SceneTruth
from app.modules.perception.people.torso_color import torso_pixels

SCENARIO = "people.yaml"
_OPERATOR = Source("operator", "the benchmark")
#: One scan of so many is kept, and a map every so many seconds.
SCANS, MAP_S = 4, 5.0
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


def record(seconds: float, path: Path) -> None:
    """Run the scene so long (simulated s) and write what is perceived to ``path``, message after message."""
    program = simulated_program(scenario=paths.config_dir() / "scenarios" / SCENARIO)
    own = {"strategies": [Path(__file__).with_name("people_strategies.yaml")]}
    program_of = program.configuration.program.model_copy(update=own)
    configuration = replace(program.configuration, program=program_of)
    with path.open("wb") as file:

        async def script(run: WorldRun) -> None:
            await _perceive(run, seconds, file, program.scenario)

        run_in_world(configuration, program.body, script, cameras=True, microphones=True, without=WITHOUT)


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


Recorded = Faces | Torsos | LaserScan | Odometry | Localization | OccupancyGrid | Truth

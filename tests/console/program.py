"""A whole program on a body without physics: the real System, modules, attention and clock, fed by the test."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import numpy as np
from fastapi import FastAPI

from app.base import paths
from app.console.server import listen, serve, url_of
from app.link import ActuatorGroup, BaseLimits, JointLimits, LinkFailed, RobotDescription, StreamDescription
from app.logs.library import RecordingLibrary
from app.maps.library import MapLibrary
from app.messages import Audio, Image, JointCommand, JointState, LaserScan, LinkStatus, Odometry, Twist
from app.modules.behaviors.face.expression import JOINTS as FACE_JOINTS
from app.program.config import load_configuration
from app.program.system import System
from app.robots.config import load_robot_config
from app.runtime.clock import Clock
from app.tours.library import TourLibrary
from app.tours.run_library import RunLibrary
from app.tours.store import TourStore

MODEL = paths.config_dir() / "robots" / "irl1_tr.urdf"
IRL1 = load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")
HEAD = ActuatorGroup("head", (JointLimits("pan_joint", -2, 2, 1, 5), JointLimits("tilt_joint", -0.3, 0.4, 1, 5)))
FACE = ActuatorGroup("face", tuple(JointLimits(name, -0.5, 1.2, 10, 100) for name in FACE_JOINTS))
STREAMS = {
    name: StreamDescription(name, message_type, rate_hz)
    for name, message_type, rate_hz in (
        ("kinect", Image, 15.0),
        ("microphones", Audio, 93.75),
        ("hokuyo", LaserScan, 40.0),
        ("odometry", Odometry, 100.0),
        ("joints", JointState, 30.0),
        ("status", LinkStatus, 20.0),
    )
}

PROGRAM = """\
robot: robot.yaml
console: {command_validity_s: 2}  # a busy computer may not make a command late that is not meant to be
channels: channels.yaml
strategies: [strategies.yaml]
modules:
  Kinect:
    class: app.modules.sensors.kinect:Kinect
    outputs: {images: kinect}
  Hokuyo:
    class: app.modules.sensors.hokuyo:Hokuyo
    outputs: {scans: scan}
  WheelOdometry:
    class: app.modules.sensors.wheel_odometry:WheelOdometry
    outputs: {odometry: odometry, joints: joints}
  CameraStream:
    class: app.modules.perception.camera_stream:CameraStream
    inputs: {images: kinect}
    outputs: {pictures: camera_jpeg}
  PanoramaStream:
    class: app.modules.perception.panorama_stream:PanoramaStream
    inputs: {images: panorama}
    outputs: {pictures: panorama_jpeg}
  PointCloudBuilder:
    class: app.modules.perception.point_cloud_builder:PointCloudBuilder
    inputs: {images: kinect, odometry: odometry}
    outputs: {clouds: point_cloud}
  Teleop:
    class: tests.console.versatile_teleop:VersatileTeleop
    inputs: {operator: teleop_command}
    outputs: {twist: teleop_twist}
  Microphones:
    class: app.modules.sensors.microphones:Microphones
    outputs: {audio: microphones}
  AudioStream:
    class: app.modules.perception.audio_stream:AudioStream
    inputs: {audio: microphones}
    outputs: {sound: robot_audio}
  Loudspeaker:
    class: app.modules.actuation.loudspeaker:Loudspeaker
    inputs: {voice: operator_voice}
  PerceptPlacer:
    class: app.modules.perception.percept_placer:PerceptPlacer
    inputs: {faces: faces, codes: qr_codes, sounds: sound_sources, noises: loud_noises, panorama: panorama_jpeg,
             odometry: odometry}
    outputs: {percepts: placed_percepts}
  NavigationReporter:
    class: app.modules.behaviors.navigation_reporter:NavigationReporter
    inputs: {navigation: navigation, going_toward: going_toward, path: path, localization: localization}
    outputs: {report: navigation_report}
  TourGuide:
    class: app.modules.motivations.tour_guide.tour_guide:TourGuide
    inputs: {odometry: odometry, localization: localization, places: places}
    outputs: {progress: tour_progress}
  PlaceKeeper:
    class: app.modules.perception.place_keeper:PlaceKeeper
    inputs: {landmarks: landmarks, zones: zones}
    outputs: {places: places}
"""

#: Added to the program where recording is what is tested.
RECORDER = """\
  Recorder:
    class: tests.console.scripted_recorder:ScriptedRecorder
    inputs: {kinect: kinect}
    outputs: {status: recorder}
"""

RECORDER_CHANNEL = """\
recorder: {type: RecorderStatus, decimable: false, log: never}
"""

RECORDER_STRATEGY = """\
  - {name: record, class: Record, utility: 4, filters: {Recorder.kinect: 1}, costs: {cpu: 5}}
"""

CHANNELS = """\
kinect: {type: Image, rate_hz: 15}
scan: {type: LaserScan, rate_hz: 40}
odometry: {type: Odometry, rate_hz: 100, decimable: false}
joints: {type: JointState, rate_hz: 30, decimable: false}
teleop_command: {type: TeleopCommand, decimable: false, external: true}
teleop_twist: {type: Twist, decimable: false}
camera_jpeg: {type: EncodedImage}
point_cloud: {type: PointCloud}
landmarks: {type: Landmarks, latched: true, external: true, page: {}}
exploitation: {type: Exploitation, rate_hz: 10, external: true}
microphones: {type: Audio, rate_hz: 93.75, decimable: false}
robot_audio: {type: Audio, decimable: false, log: never}
operator_voice: {type: Audio, decimable: false, external: true}
salient_regions: {type: SalientRegions, external: true, page: {every_hz: 5}}
persons: {type: Persons, external: true, page: {every_hz: 10}}
emotions: {type: EmotionState, latched: true, external: true, decimable: false, page: {every_hz: 2}}
memory: {type: MemoryState, latched: true, external: true, decimable: false, page: {every_hz: 4}}
rules: {type: RulesReport, latched: true, external: true, decimable: false, page: {every_hz: 4}}
saliency: {type: SaliencyMap, log: never, external: true, page: {every_hz: 5}}
speech: {type: Speech, latched: true, decimable: false, external: true, page: {every_hz: 20}}
battery: {type: BatteryState, decimable: false, external: true, page: {every_hz: 2}}
heard_words: {type: HeardWords, decimable: false, external: true, page: {every_hz: 10}}
faces: {type: Faces, external: true}
qr_codes: {type: QRCodes, external: true}
sound_sources: {type: SoundSources, external: true}
loud_noises: {type: LoudNoise, decimable: false, external: true}
percept_events: {type: PerceptEvent, decimable: false, external: true}
panorama: {type: Image, rate_hz: 10, external: true}
panorama_jpeg: {type: EncodedImage, log: never}
localization: {type: Localization, frame: map, decimable: false, external: true, page: {every_hz: 10}}
map: {type: OccupancyGrid, latched: true, frame: map, decimable: false, external: true}
zones: {type: Zones, latched: true, frame: map, decimable: false, external: true, page: {every_hz: 10}}
places: {type: Places, latched: true, frame: map, decimable: false, page: {every_hz: 10}}
tour_progress: {type: TourProgress, latched: true, decimable: false, page: {as: tour, every_hz: 10}}
navigation: {type: NavigationStatus, latched: true, decimable: false, external: true}
path: {type: PlannedPath, latched: true, decimable: false, external: true}
local_costmap: {type: OccupancyGrid, frame: odom, log: never, external: true}
going_toward: {type: NavigationStatus, latched: true, decimable: false, external: true}
placed_percepts: {type: PlacedPercepts, latched: true, log: never, page: {as: perceived, every_hz: 10}}
navigation_report: {type: NavigationReport, latched: true, log: never, page: {as: navigation, every_hz: 10}}
events: {type: TimelineEvent, decimable: false, external: true, page: {keep: all}}
workspace: {type: Desires, latched: true, decimable: false, external: true, page: {as: desires}}
intention: {type: IntentionReport, latched: true, decimable: false, external: true, page: {}}
load: {type: LoadReport, decimable: false, external: true, page: {}}
lanes: {type: Lanes, decimable: false, external: true, page: {every_hz: 20}}
external_forces: {type: ExternalForces, rate_hz: 30, frame: base_link, external: true}
"""

STRATEGIES = """\
resources:
  cpu: {capacity: 100, unit: "%"}
strategies:
  - name: drive-by-hand
    class: Teleoperation
    utility: 1
    filters: {Teleop.twist: 1}
    costs: {cpu: 5}
  - {name: listen, class: Listen, utility: 4, filters: {AudioStream.audio: 1}, costs: {cpu: 1}}
  - {name: go, class: GoTo, utility: 4, filters: {Teleop.twist: 1}, costs: {cpu: 5}}
  - name: picture-fast
    class: Telepresence
    utility: 4
    filters: {CameraStream.images: 1, PointCloudBuilder.images: 3}
    costs: {cpu: 40}
  - name: picture-slow
    class: Telepresence
    utility: 1
    filters: {CameraStream.images: 4, PointCloudBuilder.images: 15}
    costs: {cpu: 10}
"""

#: A desire that the program serves, as REST takes it.
NEW = {"class": "Telepresence", "intensity": 8, "utility": 4, "security": False, "params": {}, "ttl": 30}


class Body:
    """A RobotLink whose streams the test feeds with :meth:`emit`."""

    def __init__(self) -> None:
        limits = BaseLimits(0.40, 1.00, 0.40, 4.00)
        self.description = RobotDescription(
            "a test body", MODEL, limits, STREAMS, simulated=True, loudspeaker=True,
            groups={**IRL1.groups, "head": HEAD, "face": FACE}, arms=dict(IRL1.arm_descriptions),
        )  # fmt: skip
        self.receivers: dict[str, list[Callable[[Any], None]]] = {name: [] for name in STREAMS}
        self.stops: list[str] = []
        self.e_stopped = False
        #: Whether the guard reports a stop as soon as it is latched, as it should.
        self.confirms = True
        self.commands: list[Twist] = []
        self.joint_commands: list[JointCommand] = []
        self.played: list[Audio] = []

    async def start(self) -> None: ...

    async def stop(self) -> None: ...

    async def wait_failed(self) -> LinkFailed:
        await asyncio.Event().wait()
        raise AssertionError

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        self.receivers[stream].append(receive)
        return lambda: self.receivers[stream].remove(receive)

    def demand(self, stream: str, rate_hz: float) -> None: ...

    def periods(self, stream: str) -> int:
        return 1

    def command(self, command: Twist | JointCommand) -> None:
        if isinstance(command, JointCommand):
            self.joint_commands.append(command)
        else:
            self.commands.append(command)

    def play(self, audio: Audio) -> None:
        self.played.append(audio)

    def e_stop(self, reason: str) -> None:
        self.stops.append(reason)
        self.e_stopped = True
        if self.confirms:
            asyncio.get_running_loop().call_soon(self.emit_status, time.time())

    def clear_e_stop(self) -> None:
        self.e_stopped = False
        if self.confirms:
            asyncio.get_running_loop().call_soon(self.emit_status, time.time())

    def emit(self, stream: str, message: Any) -> None:
        """What the body's stream gives now."""
        for receive in list(self.receivers[stream]):
            receive(message)

    def emit_status(self, stamp: float) -> None:
        """What the guard reports now."""
        guard = "e_stopped" if self.e_stopped else "idle"
        self.emit("status", LinkStatus(stamp, guard, "", self.e_stopped, None, Twist(stamp, 0.0, 0.0), 1.0))


def write_program(folder: Path, *, recorder: bool = False) -> Path:
    """The program's configuration, in ``folder``."""
    for name, text in {
        "program.yaml": PROGRAM + RECORDER * recorder,
        "channels.yaml": CHANNELS + RECORDER_CHANNEL * recorder,
        "strategies.yaml": STRATEGIES + RECORDER_STRATEGY * recorder,
        "robot.yaml": "{}\n",
    }.items():
        (folder / name).write_text(text)
    return folder / "program.yaml"


def build(
    folder: Path, *, recorder: bool = False, body: Body | None = None, clock: Clock | None = None
) -> tuple[System, Body]:
    """The program, not running yet; outside the event loop, since it reads its files."""
    body = body or Body()
    configuration = load_configuration(write_program(folder, recorder=recorder))
    recordings, maps = RecordingLibrary(folder / "recordings"), MapLibrary(folder / "maps")
    tours = TourStore(TourLibrary(folder / "tours", paths.config_dir() / "tours"))
    runs = RunLibrary(folder / "tour-runs")
    return System(configuration, link=body, clock=clock, recordings=recordings, maps=maps, tours=tours, runs=runs), body


@contextlib.asynccontextmanager
async def served(
    app: FastAPI, listener: socket.socket | None = None, scene: socket.socket | None = None
) -> AsyncIterator[str]:
    """``app`` served on a free port of 127.0.0.1, or by ``listener`` and ``scene``; gives its URL."""
    listener = listener or listen("127.0.0.1", 0)
    url = url_of(listener)
    up = asyncio.Event()
    task = asyncio.create_task(serve(app, "127.0.0.1", 0, listener=listener, scene=scene, started=lambda _: up.set()))
    started = asyncio.create_task(up.wait())
    await asyncio.wait({task, started}, return_when=asyncio.FIRST_COMPLETED)
    try:
        yield url
    finally:
        started.cancel()
        task.cancel()
        await asyncio.wait({task})


def write_page(folder: Path) -> Path:
    """A page of one line, as Vite would lay it out."""
    static = folder / "static"
    (static / "assets").mkdir(parents=True)
    (static / "index.html").write_text("<!doctype html><title>page</title>")
    (static / "assets" / "index-1a2b.js").write_text("0")
    return static


def image(stamp: float, *, width: int = 64, height: int = 48) -> Image:
    """A camera image with depth: a wall 2 m ahead."""
    from app.base.geometry import CameraModel, Pose3

    color = np.full((height, width, 3), 120, np.uint8)
    depth = np.full((height, width), 2000, np.uint16)
    camera = CameraModel.from_vertical_fov(width, height, 0.75)
    return Image(stamp, "kinect_optical_frame", color, depth, camera, Pose3.identity())


def sound(stamp: float, first_sample: int, *, samples: int = 512, level: int = 1000) -> Audio:
    """A frame of eight microphones: each has its own number added to ``level``; number 1 is the front one."""
    places = np.array([[0.1 if number == 1 else 0.0, 0.0, 0.5] for number in range(8)])
    values = np.full((samples, 8), level, np.int16) + np.arange(8, dtype=np.int16)
    return Audio(stamp, "microphones", values.astype(np.int16), 48_000, first_sample, places)

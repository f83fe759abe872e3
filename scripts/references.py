"""The reference log and the reference values: the results of every module on a recorded minute of the simulated lab.

    make references                    measure again on the present log, print the differences, write the values
    make references ARGS=--record      record the log in the simulator again first

A test compares the modules with the values at every run; they change only by this, on purpose.
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import math
import os
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import Pose2
from app.experiments.world_run import able
from app.logs.library import RecordingLibrary
from app.messages import Odometry, TeleopCommand
from app.program.config import Configuration, load_configuration
from app.program.system import System
from app.robots.config import RobotConfig
from app.robots.factory import create_lockstep, load_body
from app.runtime.clock import VirtualClock, run_virtual
from tests.references.figures import LOG, VALUES, compare, load_values, measure, write_values

OPERATOR = Source("operator", "ada")
PROGRAM = Source("rest", "scenario")
LENGTH_S = 60.0
PERIOD_S = 0.05
BEGIN = 1_795_000_000.0
#: Options that keep the file small enough for a repository: few small pictures, few rays, slow odometry. The scans keep
#: their rate: without a fresh one the collision monitor stops the robot.
WIDTH, HEIGHT, KINECT_HZ = 424, 318, 0.85
RAYS, HOKUYO_HZ, ODOMETRY_HZ = 181, 5, 50
#: Modules that perceive or map: replays run them; they are off while the log is recorded.
WITHOUT = ("PanoramicCamera", "FaceDetector", "SLAM2D")

#: In odom (m; the robot begins at its origin, looking along x): places to go to, and points to look at for so long (s).
#: Up the corridor to the Robotics lab's poster, then west by the Office's to the Workshop's.
ROUTE: tuple[tuple[str, float, float, float], ...] = (
    ("go", 3.35, 0.0, 0.0),
    ("look", 4.54, -0.1, 5.0),
    ("go", 3.4, 2.6, 0.0),
    ("look", 2.26, 2.8, 6.0),
    ("go", 3.35, 5.3, 0.0),
    ("look", 4.54, 5.5, 8.0),
    ("look", 2.26, 2.8, 8.0),
)

#: When who desires what: (from s, to s, who, class, intensity, utility, parameters).
DESIRES: tuple[tuple[float, float, Source, str, float, float, dict[str, Any]], ...] = (
    (2.0, 10.0, OPERATOR, "Telepresence", 4.0, 1.0, {}),
    (11.0, 18.0, PROGRAM, "FindQRCodes", 8.0, 8.0, {"upscale": True}),
    (18.0, 26.0, OPERATOR, "Telepresence", 8.0, 8.0, {"max_points": 5000, "jpeg_quality": 60}),
    (34.0, 43.0, OPERATOR, "Telepresence", 4.0, 4.0, {}),
    (54.0, 58.0, OPERATOR, "FindQRCodes", 8.0, 0.0, {}),
)


def main() -> int:
    """Do what is asked for; the exit code says whether anything differs from the values there were."""
    parser = argparse.ArgumentParser(prog="make references", description=__doc__.splitlines()[0])
    parser.add_argument("--record", action="store_true", help="record the log in the simulator again first")
    parser.add_argument("--check", action="store_true", help="only compare, write nothing")
    args = parser.parse_args()
    if args.record:
        record(LOG)
    if not LOG.is_file():
        print(f"there is no {LOG}: make references ARGS=--record", file=sys.stderr)
        return 2
    measured = measure(LOG)
    differences: list[str] = []
    if VALUES.is_file():
        values = load_values(VALUES)
        differences = compare(measured, values)
        for line in differences:
            print(line)
        print(f"{len(differences)} of the values differ beyond their tolerances" if differences else "nothing differs")
    if args.check:
        return 1 if differences else 0
    write_values(VALUES, measured)
    print(f"written: {VALUES}")
    return 0


# --- Recording -------------------------------------------------------------------------------------------------------


def record(path: Path) -> None:
    """Drive the simulated robot along the route and record it at ``path``."""
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder) / "config"
        shutil.copytree(paths.config_dir(), config, ignore=shutil.ignore_patterns("calibration"))
        make_small(config)
        os.environ["HBBA_HOST"] = "reference"  # no computer's calibration
        library = RecordingLibrary(Path(folder) / "recordings")
        run_virtual(live(make_system(load_configuration(config / "lab.yaml"), library)), patience_s=600)
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.move(library.path("lab"), path)
    print(f"recorded: {path}, {path.stat().st_size / 1e6:.1f} MB")


def make_system(configuration: Configuration, library: RecordingLibrary) -> System:
    """The program in a world that keeps its time, so that a busy computer records what an idle one would."""
    clock = VirtualClock(BEGIN)
    body = load_body(configuration.path(configuration.program.robot))
    if not isinstance(body, RobotConfig):
        raise TypeError(f"{body.name} is not simulated")
    link = create_lockstep(body, clock, cameras=True)
    reduced = able(configuration, link, WITHOUT)
    modules = {**reduced.program.modules, "Recorder": configuration.program.modules["Recorder"]}
    numbers = itertools.count(1)
    return System(
        replace(reduced, program=reduced.program.model_copy(update={"modules": modules})),
        link=link,
        body=body,
        clock=clock,
        recordings=library,
        new_id=lambda: f"d-{next(numbers):010d}",
        partial=True,
        reproducible=True,
    )


def make_small(config: Path) -> None:
    """Thin what takes room in the robot's sensors, and record all that is left."""
    robot_file = config / "robots" / "irl1_tr.yaml"
    robot = yaml.safe_load(robot_file.read_text())
    robot["scenario"] = None  # no person steps between the robot and its posters
    robot["streams"]["kinect"] |= {"width": WIDTH, "height": HEIGHT, "rate_hz": KINECT_HZ}
    robot["streams"]["hokuyo"] |= {"rays": RAYS, "rate_hz": HOKUYO_HZ}
    robot["streams"]["odometry"]["rate_hz"] = ODOMETRY_HZ
    robot_file.write_text(yaml.safe_dump(robot, sort_keys=False))
    table_file = config / "strategies" / "lab.yaml"
    table = yaml.safe_load(table_file.read_text())
    table["strategies"] = [s for s in table["strategies"] if s["class"] != "Record"]
    for strategy in table["strategies"]:  # a bare off is no word in YAML
        strategy["filters"] = {name: "off" if phi is False else phi for name, phi in strategy["filters"].items()}
    table["strategies"].append(
        {
            "name": "record-little",
            "class": "Record",
            "utility": 8,
            "filters": {
                "Recorder.kinect": 1,
                "Recorder.scan": 1,
                "Recorder.panorama": "off",
                "Recorder.microphones": "off",
            },
        }
    )
    table_file.write_text(yaml.safe_dump(table, sort_keys=False))


async def live(system: System) -> None:
    """One minute: the operator drives, operators and programs add desires, everything is recorded."""
    async with system:
        system.workspace.add("Record", intensity=8, utility=1, source=OPERATOR, params={"name": "lab"})
        odometry = system.graph.channel("odometry").subscribe("driver")
        await odometry.receive()
        begin = system.clock.now()
        desiring = asyncio.create_task(desire(system, begin))
        driving = asyncio.create_task(drive(system))
        await system.clock.sleep_until(begin + LENGTH_S)
        for task in (desiring, driving):
            task.cancel()
        await asyncio.gather(desiring, driving, return_exceptions=True)
        recorder = system.graph.channel("recorder")
        system.graph.channel("odometry").unsubscribe(odometry)
        for standing in system.workspace.desires():
            if standing.cls == "Record":
                system.workspace.remove(standing.id)
        subscription = recorder.subscribe("end", capacity=4)
        while (await subscription.receive()).state != "idle":
            pass


async def desire(system: System, begin: float) -> None:
    """Add and remove the scenario's desires at their times."""
    steps: list[tuple[float, int, bool]] = []
    for number, (since, until, *_) in enumerate(DESIRES):
        steps += [(since, number, True), (until, number, False)]
    standing: dict[int, str] = {}
    for at, number, comes in sorted(steps):
        await system.clock.sleep_until(begin + at)
        _, _, source, cls, intensity, utility, params = DESIRES[number]
        if comes:
            standing[number] = system.workspace.add(
                cls, intensity=intensity, utility=utility, source=source, params=params
            ).id
        else:
            system.workspace.remove(standing.pop(number))


async def drive(system: System) -> None:
    """Steer along the route as an operator would: sticks, twenty times a second, the dead-man held."""
    channel = system.graph.channel("teleop_command")
    sequence = 0

    def say(linear: float, angular: float, held: bool = True) -> None:
        nonlocal sequence
        sequence += 1
        channel.publish(TeleopCommand(system.clock.now(), "ada", sequence, held, linear, angular))

    for kind, x, y, stay_s in ROUTE:
        arrived: float | None = None
        while arrived is None or system.clock.now() - arrived < stay_s:
            latest = system.graph.channel("odometry").latest
            assert isinstance(latest, Odometry)
            linear, angular, there = steer(kind, latest.X_OB, x, y)
            if there and arrived is None:
                arrived = system.clock.now()
            say(linear, angular, held=not (there and kind == "look"))
            await system.clock.sleep(PERIOD_S)
    say(0.0, 0.0, held=False)


def steer(kind: str, X_OB: Pose2, x: float, y: float) -> tuple[float, float, bool]:
    """Stick positions towards the point, and whether it is reached (or looked at)."""
    bearing = math.atan2(y - X_OB.y, x - X_OB.x)
    error = math.remainder(bearing - X_OB.theta, 2 * math.pi)
    if kind == "look":
        there = abs(error) < 0.04
        return 0.0, 0.0 if there else max(-0.7, min(0.7, 2.0 * error)), there
    distance = math.hypot(x - X_OB.x, y - X_OB.y)
    if distance < 0.12:
        return 0.0, 0.0, True
    turn = max(-0.8, min(0.8, 2.0 * error))
    return (0.0 if abs(error) > 0.4 else max(0.2, min(0.95, distance))), turn, False


if __name__ == "__main__":
    sys.exit(main())

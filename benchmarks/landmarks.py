"""Where posters hang on the map after a loop of the lab, against where they hang.

The robot is driven through the Workshop and the Robotics lab and back along the corridor, past four posters, the first
of which it sees again at the end, with odometry whose errors are a multiple of the usual. In lockstep, with the Kinect
alone and SLAM2D; the map begins where the robot does. The peer is the mean of the same sightings in odom.
"""

from __future__ import annotations

import math
import os
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from app.robots.simulated.gl import gl_environment

os.environ.update(gl_environment())  # read when MuJoCo is imported

import numpy as np

from app.base import compiled
from app.base.geometry import Pose2
from app.base.paths import config_dir
from app.base.pose_buffer import PoseBuffer
from app.base.yaml_source import parse
from app.experiments.goals.goal_run import body_in, seeing
from app.experiments.script import Waypoint, drive_script
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import Landmarks, Odometry, QRCodes
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.simulated.world_config import WorldConfig
from app.runtime.filter_bank import Pin
from benchmarks.report import Row, benchmark_main, row

MODULES = (
    "Hokuyo", "WheelOdometry", "Kinect", "SLAM2D", "QRCodeDetector", "Teleop", "MobileBaseControl",
    "ScenarioCoordinator",
)  # fmt: skip
PINS = {"SLAM2D.scans": Pin(4), "QRCodeDetector.images": Pin(1)}
PICTURES_HZ = 2.0
#: Multiples of the usual errors of odometry.
FAULTS = (1.0, 8.0)
ROOMS = (
    Waypoint(go=(11.1, 7.6)), Waypoint(face=90), Waypoint(pause=2.5),
    Waypoint(go=(8.4, 8.3)), Waypoint(face=-90), Waypoint(pause=2.5),
    Waypoint(go=(5.5, 7.7)), Waypoint(face=90), Waypoint(pause=2.5),
)  # fmt: skip
LOOP = (
    *((4.55, 8.2), (4.6, 10.2), (6.9, 10.0), (7.1, 11.0), (6.45, 12.0), (6.4, 14.1), (9.2, 13.8), (11.8, 13.8)),
    *((15.2, 13.8), (15.6, 13.5), (19.4, 13.6), (19.9, 11.5), (19.05, 10.3), (19.0, 8.1), (17.3, 7.75), (11.3, 7.6)),
)
HOME = (
    Waypoint(face=90), Waypoint(pause=2.5), Waypoint(go=(11.2, 4.6)), Waypoint(go=(11.1, 3.6)), Waypoint(face=0),
    Waypoint(pause=2.5),
)  # fmt: skip


@dataclass
class Drive:
    """What came of one drive: ``landmarks`` at its end, positions (m) of sightings in odom, where the robot began."""

    start: Pose2 = field(default_factory=Pose2)
    landmarks: Landmarks = field(default_factory=lambda: Landmarks(0.0, ()))
    in_odom: dict[str, list[tuple[float, float]]] = field(default_factory=lambda: defaultdict(list))


def drive(fault: float, quick: bool) -> Drive:
    """Drive the loop (``quick``: only past the first three posters and back) with odometry ``fault`` times as bad."""
    compiled.make_ready()
    config = config_dir() / "lab.yaml"
    configuration = load_configuration(config)
    modules = {name: configuration.program.modules[name] for name in MODULES}
    configuration = replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))
    done = Drive()

    async def script(run: WorldRun) -> None:
        system = run.system
        await system.supervisor.started()
        poses = PoseBuffer(span_s=10.0, tolerance_s=0.1)

        def read(codes: QRCodes) -> None:
            X_OB = poses.at(codes.stamp)
            for code in codes.codes:
                if X_OB is not None and code.p_BQ is not None:
                    x, y = X_OB.transform(np.array(code.p_BQ[:2])).tolist()
                    done.in_odom[code.text].append((x, y))

        def roll(odometry: Odometry) -> None:
            poses.add(odometry.stamp, odometry.X_OB)

        system.graph.channels["odometry"].observe(roll)
        system.graph.channels["qr_codes"].observe(read)
        loop = () if quick else tuple(Waypoint(go=place) for place in LOOP)
        await drive_script(system, (*ROOMS, *loop, Waypoint(go=(11.3, 7.6)), *HOME))
        done.start = run.link.start_pose
        done.landmarks = system.graph.channels["landmarks"].latest or done.landmarks

    run_in_world(configuration, _body(fault), script, cameras=True, pins=PINS)
    return done


def _body(fault: float) -> RobotConfig:
    body = seeing(body_in(config_dir() / "lab.yaml", None))
    base, kinect = body.base, body.streams.kinect
    assert kinect is not None
    errors = {name: fault * getattr(base, name) for name in ("radius_error", "track_error", "slip")}
    streams = body.streams.model_copy(update={"kinect": kinect.model_copy(update={"rate_hz": PICTURES_HZ})})
    start = body.start.model_copy(update={"x": 11.2, "y": 4.6, "heading_deg": 90.0})
    return body.model_copy(
        update={"base": base.model_copy(update=errors), "streams": streams, "start": start, "ground_truth": True}
    )


def posters(world: WorldConfig) -> Mapping[str, tuple[float, float, float]]:
    """Text to x, y (m) and heading (rad) in the world."""
    return {each.text: (*each.at, math.radians(each.facing_deg)) for each in world.posters}


def measure(quick: bool) -> Sequence[Row]:
    """Each fault of odometry."""
    rows = []
    for fault in FAULTS[-1:] if quick else FAULTS:
        done = drive(fault, quick)
        truth = posters(parse(_body(fault).world, WorldConfig))
        place, turn, odom = [], [], []
        for mark in done.landmarks.landmarks:
            at = done.start @ Pose2(mark.p_FQ[0], mark.p_FQ[1], mark.heading or 0.0)
            x, y, heading = truth[mark.text]
            place.append(math.hypot(at.x - x, at.y - y))
            turn.append(math.degrees(abs(math.remainder(at.theta - heading, math.tau))))
            mean = done.start.transform(np.mean(done.in_odom[mark.text], axis=0))
            odom.append(math.hypot(mean[0] - x, mean[1] - y))
            print(
                f"{mark.text:<20} {mark.sightings:>4} sightings  off {place[-1]:.3f} m (sigma {mark.sigma_m:.3f}), "
                f"{turn[-1]:.1f} deg; in odom {odom[-1]:.2f} m"
            )
        subject = f"odometry {fault:g} times as bad, {len(place)} landmarks of {done.landmarks.frame}"
        rows.append(row("landmarks", subject, "off their places", "m", place, odom, "fused in odom"))
        rows.append(row("landmarks", subject, "off their headings", "deg", turn))
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))

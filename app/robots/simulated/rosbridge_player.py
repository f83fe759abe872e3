"""A simulated robot behind rosbridge's WebSocket, in a process of its own, without ROS: a kinematic body on a kept map.

``python -m app.robots.simulated.rosbridge_player --robot ROBOT.yaml --map MAP.yaml [options]``, where ROBOT is a
mapping of kind ``ros2``, whose model, sizes and topics the robot has. It gives odometry, joints, scans, battery, and
with ``--pictures WIDTH HEIGHT HZ`` raw pictures on the topic of ``camera``; it takes velocities, and set-points of
joints on the topics of ``joint_commands``: it goes to the newest, all the way, and stays. With ``--ros1``, types,
times and fields have the names of ROS 1. Without a velocity for ``--watchdog`` seconds the base stops by itself.

It prints ``ready`` once it moves, and in the next line its address. Lines on its standard input are faults:
``odometry off``, ``odometry on``, ``clock SECONDS`` (its clock is ahead by so much from then on), ``origin`` (odometry
begins again at zero), ``bridge off`` and ``bridge on`` (rosbridge ends, and runs again), and ``say TEXT``, which sends
TEXT as a frame.

With ``--log FILE`` each step is a line ``MONOTONIC LINEAR ANGULAR`` of its true velocity.
"""

from __future__ import annotations

import argparse
import asyncio
import base64
import math
import signal
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import IO, Any

import numpy as np

from app.base.child_processes import end_with_parent
from app.base.geometry import Pose2
from app.logs.stamps import SECOND, to_ns
from app.messages import JointState, LaserScan, Odometry, Twist
from app.robots.ros2.config import INFO, TRAJECTORY, TWIST_STAMPED, Ros2Config, load_ros2_config
from app.robots.simulated.battery import Battery
from app.robots.simulated.ros_body import BATTERY, BATTERY_S, LOAD_W, Controllers, add_options, played_body
from app.robots.simulated.rosbridge_server import RosbridgeServer
from app.runtime.clock import RealClock

_NO_COVARIANCE = [0.0] * 36


class RosbridgePlayer:
    """The body of ``config``, and the server before it."""

    def __init__(self, config: Ros2Config, options: argparse.Namespace) -> None:
        self._clock = RealClock()
        self._config = config
        self._link = played_body(config, options, self._clock)
        self._controllers = Controllers(self._link, self._clock)
        self._ros1 = bool(options.ros1)
        #: By how much (s) the robot's clock is ahead.
        self.ahead_s = float(options.ahead)
        self.gives_odometry = True
        #: ``X_OO'``: where odometry began again.
        self.origin = Pose2(0.0, 0.0, 0.0)
        self._last: Odometry | None = None
        self._log: IO[str] | None = None if options.log is None else options.log.open("w", encoding="utf-8")
        self._battery = Battery(BATTERY)
        self._drawn = self._clock.now()
        self._topics = {name: topic for name, (topic, _) in config.readings.items()}
        self._pictures: tuple[int, int, float] | None = options.pictures
        receivers: dict[str, Callable[[Any], None]] = {
            "odometry": self._give_odometry, "joints": self._give_joints, "hokuyo": self._give_scan,
        }  # fmt: skip
        given = {*receivers, "battery"} | ({"camera", f"camera.{INFO}"} if self._pictures else set())
        published = {topic: kind for name, (topic, kind) in config.readings.items() if name in given}
        taken: dict[str, tuple[str, Callable[[dict[str, Any]], None]]] = {
            config.full_name(config.base.topic): (config.base.type, self._commanded)
        }
        for group, topic in config.joint_commands.items():
            names = tuple(joint.name for joint in config.groups[group].joints)
            take = partial(self._sent, group, topic.type, names)
            taken[config.full_name(topic.topic or "")] = (topic.type, take)
        self._server = RosbridgeServer(published, taken, ros1=self._ros1, has_rosapi=not options.no_rosapi)
        self._port = int(options.port)
        for stream, receive in receivers.items():
            if stream in self._link.description.streams:
                self._link.attach(stream, receive)
                self._link.demand(stream, 100.0)

    async def run(self) -> None:
        """Move for ever."""
        await self._link.start()
        self._port = await self._server.open(self._port)
        print(f"ready\nws://127.0.0.1:{self._port}", flush=True)
        if self._pictures is None:
            await self._link.wait_failed()
        else:
            await self._give_pictures(*self._pictures)

    async def fault(self, line: str) -> None:
        """Do what a line of standard input says. Raises ValueError for an unknown one."""
        match line.split(maxsplit=1):
            case ["odometry", ("on\n" | "off\n") as state]:
                self.gives_odometry = state == "on\n"
            case ["clock", seconds]:
                self.ahead_s = float(seconds)
            case ["origin"] if self._last is not None:
                self.origin = self._last.X_OB
            case ["bridge", "off\n"]:
                await self._server.close()
            case ["bridge", "on\n"]:
                await self._server.open(self._port)
            case ["say", text]:
                self._server.say(text.rstrip("\n"))
            case _:
                raise ValueError(f"no such fault: {line!r}")

    # The robot's computer

    def _commanded(self, message: dict[str, Any]) -> None:
        twist = message["twist"] if self._config.base.type == TWIST_STAMPED else message
        velocity = (twist["linear"]["x"], twist["angular"]["z"], twist["linear"]["y"])
        self._link.command(Twist(self._clock.now(), *map(float, velocity)))

    def _sent(self, group: str, kind: str, names: tuple[str, ...], message: dict[str, Any]) -> None:
        positions = message["points"][-1]["positions"] if kind == TRAJECTORY else message["data"]
        if kind == TRAJECTORY:
            names = tuple(message["joint_names"])
        self._controllers.take(group, names, tuple(map(float, positions)))

    def _give(self, name: str, stamp: float, frame: str, fields: dict[str, Any]) -> None:
        """Publish ``fields`` under a header, on the topic of ``name``, where the mapping has it."""
        if name not in self._topics:
            return
        seconds, nanoseconds = divmod(to_ns(stamp + self.ahead_s), SECOND)
        header: dict[str, Any] = {"frame_id": frame}
        if self._ros1:
            header |= {"seq": 0, "stamp": {"secs": seconds, "nsecs": nanoseconds}}
        else:
            header["stamp"] = {"sec": seconds, "nanosec": nanoseconds}
        self._server.publish(self._topics[name], {"header": header} | fields)

    def _give_odometry(self, odometry: Odometry) -> None:
        self._last = odometry
        if self._log is not None:
            self._log.write(f"{time.monotonic()} {odometry.linear_mps} {odometry.angular_radps}\n")
            self._log.flush()
        self._draw(odometry.stamp)
        if not self.gives_odometry:
            return
        pose = self.origin.inverse() @ odometry.X_OB
        turn = {"x": 0.0, "y": 0.0, "z": math.sin(pose.theta / 2), "w": math.cos(pose.theta / 2)}
        twist = {
            "linear": {"x": odometry.linear_mps, "y": odometry.lateral_mps, "z": 0.0},
            "angular": {"x": 0.0, "y": 0.0, "z": odometry.angular_radps},
        }
        placed = {"position": {"x": pose.x, "y": pose.y, "z": 0.0}, "orientation": turn}
        fields = {
            "child_frame_id": "base_link",
            "pose": {"pose": placed, "covariance": _NO_COVARIANCE},
            "twist": {"twist": twist, "covariance": _NO_COVARIANCE},
        }
        self._give("odometry", odometry.stamp, "odom", fields)

    def _draw(self, now: float) -> None:
        """Discharge the battery, once a second, and say what is left."""
        if now - self._drawn < BATTERY_S:
            return
        self._battery.advance(now - self._drawn, LOAD_W, charging=False)
        self._drawn = now
        state = self._battery.state(now)
        # What it does not know is NaN, which rosbridge writes as null.
        unknown = dict.fromkeys(("temperature", "charge", "capacity", "design_capacity"))
        if self._ros1:
            del unknown["temperature"]  # came late
        known = {"voltage": state.voltage_v, "current": state.current_a, "percentage": state.charge}
        kind = {"power_supply_status": 2, "power_supply_health": 1, "power_supply_technology": 2, "present": True}
        cells = {"cell_voltage": [], "cell_temperature": [], "location": "", "serial_number": ""}
        self._give("battery", now, "", unknown | known | kind | cells)

    def _give_joints(self, joints: JointState) -> None:
        self._controllers.hold()
        fields = {"name": list(joints.names), "position": list(joints.positions), "velocity": [], "effort": []}
        self._give("joints", joints.stamp, "", fields)

    def _give_scan(self, scan: LaserScan) -> None:
        ranges = [distance if math.isfinite(distance) else None for distance in scan.ranges.tolist()]
        fields = {
            "angle_min": scan.angle_min,
            "angle_max": scan.angle_min + scan.angle_increment * (len(ranges) - 1),
            "angle_increment": scan.angle_increment,
            "time_increment": 0.0,
            "scan_time": 0.0,
            "range_min": scan.range_min,
            "range_max": scan.range_max,
            "ranges": ranges,
            "intensities": scan.intensities.tolist(),
        }
        self._give("hokuyo", scan.stamp, scan.frame, fields)

    async def _give_pictures(self, width: int, height: int, rate_hz: float) -> None:
        """Publish a picture that is red to the left and green to the right, and its calibration."""
        share = np.linspace(0, 255, width).astype(np.uint8)
        pixels = np.stack([share[::-1], share, np.zeros_like(share)], axis=-1)[None].repeat(height, axis=0)
        data = base64.b64encode(pixels.tobytes()).decode("ascii")
        picture = {"height": height, "width": width, "encoding": "rgb8", "is_bigendian": 0, "step": 3 * width}
        K = [float(width), 0.0, width / 2, 0.0, float(width), height / 2, 0.0, 0.0, 1.0]
        P = [*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0]
        matrices = {"d": [0.0] * 5, "k": K, "r": np.eye(3).ravel().tolist(), "p": P}
        region = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
        info = {"height": height, "width": width, "distortion_model": "plumb_bob", "binning_x": 0, "binning_y": 0}
        info |= {name.upper() if self._ros1 else name: values for name, values in matrices.items()} | {"roi": region}
        while True:
            now = self._clock.now()
            self._give(f"camera.{INFO}", now, "camera", info)
            self._give("camera", now, "camera", picture | {"data": data})
            await asyncio.sleep(1.0 / rate_hz)


async def play(options: argparse.Namespace) -> None:
    """Play the robot until standard input ends."""
    player = RosbridgePlayer(load_ros2_config(options.robot), options)
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    moving = asyncio.create_task(player.run(), name="player")
    async for line in reader:
        await player.fault(line.decode())
    moving.cancel()


def main() -> int:
    """Play the robot of the command line."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    end_with_parent()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser)
    parser.add_argument("--port", type=int, default=9090, help="of this computer; 0 for a free one")
    parser.add_argument("--ros1", action="store_true", help="with the names of ROS 1")
    parser.add_argument("--no-rosapi", action="store_true", help="without the services of rosapi")
    parser.add_argument("--pictures", type=float, nargs=3, default=None, metavar=("WIDTH", "HEIGHT", "HZ"))
    options = parser.parse_args()
    if options.pictures is not None:
        width, height, rate_hz = options.pictures
        options.pictures = int(width), int(height), rate_hz
    asyncio.run(play(options))
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""A simulated robot that speaks ROS 2, in a process of its own: a kinematic body on a kept map as a TurtleBot, or the
simulated lab.

``python -m app.robots.simulated.ros2_player --robot ROBOT.yaml --map MAP.yaml [options]``, where ROBOT is a mapping of
kind ``ros2``, whose model and sizes the body has; or ``--body BODY.yaml`` in place of the map, a simulated body with
its world. Topics are those of the mapping: scans and odometry (best effort, as a TurtleBot's), joints, battery,
inertial sensor, cameras where the body has them, and ``/clock`` with ``--sim-time``; it takes velocities, and
set-points of joints on the topics and by the actions of ``joint_commands``: as controllers of ros2_control do, it goes
to the newest of a topic, all the way, and stays. Without a velocity for ``--watchdog`` seconds (a body: as its file
says) the base stops by itself.

It prints ``ready`` once it moves. Lines on its standard input are faults: ``odometry off``, ``odometry on``,
``clock SECONDS`` (its clock is ahead by so much from then on), ``clock stop`` (of ``/clock``), ``origin`` (odometry
begins again at zero), ``goals reject``, ``goals abort``, ``goals keep`` (they do not end by themselves), ``goals
take``, ``goals off`` and ``goals on`` (of its actions).

With ``--log FILE`` each step is a line ``MONOTONIC LINEAR ANGULAR`` of its true velocity; with ``--goals FILE`` what
becomes of each goal is a line ``MONOTONIC WHAT``.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry as RosOdometry
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState as RosBattery
from sensor_msgs.msg import Imu as RosImu
from sensor_msgs.msg import JointState as RosJointState
from sensor_msgs.msg import LaserScan as RosScan

from app.base.child_processes import end_with_parent
from app.base.geometry import Pose2
from app.base.kinematic_model import load_model
from app.logs.ros.live.classes import MadeMessage, message_class
from app.logs.stamps import SECOND, to_ns
from app.messages import JointCommand, JointState, LaserScan, Odometry
from app.messages import Twist as Command
from app.robots.ros2.config import TRAJECTORY, TWIST_STAMPED, Ros2Config, load_ros2_config
from app.robots.simulated.battery import Battery
from app.robots.simulated.ros2_camera import CameraPublisher
from app.robots.simulated.ros2_joint_action import JointAction
from app.robots.simulated.ros_body import BATTERY, BATTERY_S, LOAD_W, Controllers, add_options, played_body
from app.runtime.clock import RealClock

_SIM_BEGAN_S = 1000.0
_GRAVITY = 9.81


class Ros2Player:
    """The body of ``config``, and its node."""

    def __init__(self, config: Ros2Config, options: argparse.Namespace) -> None:
        self._clock = RealClock()
        self._link = played_body(config, options, self._clock)
        self._sim_time = bool(options.sim_time)
        self._began = self._clock.now()
        #: By how much (s) the robot's clock is ahead.
        self.ahead_s = float(options.ahead)
        self.gives_odometry = True
        self.ticks = True
        #: ``X_OO'``: where odometry began again.
        self.origin = Pose2(0.0, 0.0, 0.0)
        self._last: Odometry | None = None
        self._log: IO[str] | None = None if options.log is None else options.log.open("w", encoding="utf-8")
        rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], domain_id=options.domain)
        node = self._node = rclpy.create_node("turtlebot", enable_rosout=False, start_parameter_services=False)
        named = {name: topic for name, (topic, _) in config.readings.items()}
        odometry = "/odom" if config.streams.odometry.is_transform else named["odometry"]
        self._odometry = node.create_publisher(RosOdometry, odometry, qos_profile_sensor_data)
        self._scans = node.create_publisher(RosScan, named.get("hokuyo", "/scan"), qos_profile_sensor_data)
        self._imus = node.create_publisher(RosImu, named["imu"], 10) if config.streams.imu is not None else None
        self._imu_link = "" if config.streams.imu is None else config.streams.imu.link
        #: Of a vector along the base's axes, that along the sensor's.
        self._R_IB = load_model(config.model).pose(self._imu_link).rotation.T if self._imu_link else np.eye(3)
        self._joints = node.create_publisher(RosJointState, named.get("joints", "/joint_states"), 10)
        battery = named.get("battery", "/battery_state")
        self._batteries = node.create_publisher(RosBattery, battery, qos_profile_sensor_data)
        self._battery = Battery(BATTERY)
        self._drawn = self._began
        self._ticker = node.create_publisher(Clock, "/clock", 10) if self._sim_time else None
        self._loop = asyncio.get_running_loop()
        stamped = config.base.type == TWIST_STAMPED
        kind = TwistStamped if stamped else Twist
        commands = config.full_name(config.base.topic)
        node.create_subscription(kind, commands, self._commanded, qos_profile_sensor_data)
        goals = None if options.goals is None else options.goals.open("w", encoding="utf-8")
        self._actions: list[JointAction] = []
        self._controllers = Controllers(self._link, self._clock)
        for group, topic in config.joint_commands.items():
            names = tuple(joint.name for joint in config.groups[group].joints)
            name = config.full_name(topic.topic or topic.action or "")
            if topic.action is not None:
                self._actions.append(JointAction(node, name, names, partial(self._command_joints, group), goals))
                continue
            take = partial(self._sent, group, names)
            node.create_subscription(message_class(topic.type), name, take, 10)
        receivers: dict[str, Callable[[Any], None]] = {
            "odometry": self._give_odometry,
            "joints": self._give_joints,
            "hokuyo": self._give_scan,
            **{name: CameraPublisher(node, config, name, self._stamp).give for name in config.cameras},
        }
        for stream, receive in receivers.items():
            if stream in self._link.description.streams:
                self._link.attach(stream, receive)
                self._link.demand(stream, 100.0)
        threading.Thread(target=self._spin, name="rclpy", daemon=True).start()

    async def run(self) -> None:
        """Move for ever."""
        await self._link.start()
        print("ready", flush=True)
        await self._link.wait_failed()

    def fault(self, line: str) -> None:
        """Do what a line of standard input says. Raises ValueError for an unknown one."""
        match line.split():
            case ["odometry", ("on" | "off") as state]:
                self.gives_odometry = state == "on"
            case ["clock", "stop"]:
                self.ticks = False
            case ["clock", seconds]:
                self.ahead_s = float(seconds)
            case ["origin"] if self._last is not None:
                self.origin = self._last.X_OB
            case ["goals", ("reject" | "abort" | "keep" | "take") as what]:
                for action in self._actions:
                    action.fault = "" if what == "take" else what
            case ["goals", ("on" | "off") as state]:
                for action in self._actions:
                    self._node.executor.create_task(partial(action.serve, on=state == "on"))
            case _:
                raise ValueError(f"no such fault: {line!r}")

    # The robot's computer

    def _commanded(self, message: Any) -> None:
        twist = getattr(message, "twist", message)
        velocity = (twist.linear.x, twist.angular.z, twist.linear.y)
        self._loop.call_soon_threadsafe(lambda: self._link.command(Command(self._clock.now(), *velocity)))

    def _sent(self, group: str, names: tuple[str, ...], made: MadeMessage) -> None:
        message = made.read()
        if made.type_name == TRAJECTORY:
            names, positions = tuple(message.joint_names), message.points[-1].positions
        else:
            positions = message.data
        self._loop.call_soon_threadsafe(self._controllers.take, group, names, tuple(map(float, positions)))

    def _command_joints(self, group: str, names: tuple[str, ...], positions: tuple[float, ...]) -> None:
        command = (group, names, positions)
        self._loop.call_soon_threadsafe(lambda: self._link.command(JointCommand(self._clock.now(), *command)))

    def _stamp(self, header: Any, stamp: float) -> None:
        own = _SIM_BEGAN_S + stamp - self._began if self._sim_time else stamp
        header.stamp.sec, header.stamp.nanosec = divmod(to_ns(own + self.ahead_s), SECOND)

    def _give_odometry(self, odometry: Odometry) -> None:
        self._give_imu(odometry)
        self._last = odometry
        if self._log is not None:
            self._log.write(f"{time.monotonic()} {odometry.linear_mps} {odometry.angular_radps}\n")
            self._log.flush()
        if self._ticker is not None and self.ticks:
            tick = Clock()
            tick.clock.sec, tick.clock.nanosec = divmod(to_ns(_SIM_BEGAN_S + odometry.stamp - self._began), SECOND)
            self._ticker.publish(tick)
        self._draw(odometry.stamp)
        if not self.gives_odometry:
            return
        message = RosOdometry()
        self._stamp(message.header, odometry.stamp)
        message.header.frame_id, message.child_frame_id = "odom", "base_link"
        pose = self.origin.inverse() @ odometry.X_OB
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        message.pose.pose.orientation.w = math.cos(pose.theta / 2)
        message.pose.pose.orientation.z = math.sin(pose.theta / 2)
        message.twist.twist.linear.x, message.twist.twist.linear.y = odometry.linear_mps, odometry.lateral_mps
        message.twist.twist.angular.z = odometry.angular_radps
        self._odometry.publish(message)

    def _give_imu(self, odometry: Odometry) -> None:
        if self._imus is None or self._last is None or odometry.stamp <= self._last.stamp:
            return
        ahead = (odometry.linear_mps - self._last.linear_mps) / (odometry.stamp - self._last.stamp)
        turning = self._R_IB @ (0.0, 0.0, odometry.angular_radps)
        force = self._R_IB @ (ahead, odometry.linear_mps * odometry.angular_radps, _GRAVITY)
        message = RosImu()
        self._stamp(message.header, odometry.stamp)
        message.header.frame_id = self._imu_link
        for written, vector in ((message.angular_velocity, turning), (message.linear_acceleration, force)):
            written.x, written.y, written.z = map(float, vector)
        message.orientation_covariance[0] = -1.0  # it has no attitude
        self._imus.publish(message)

    def _draw(self, now: float) -> None:
        """Discharge the battery, once a second, and say what is left."""
        if now - self._drawn < BATTERY_S:
            return
        self._battery.advance(now - self._drawn, LOAD_W, charging=False)
        self._drawn = now
        state, message = self._battery.state(now), RosBattery()
        self._stamp(message.header, now)
        message.voltage, message.current, message.percentage = state.voltage_v, state.current_a, state.charge
        message.power_supply_status = RosBattery.POWER_SUPPLY_STATUS_DISCHARGING
        self._batteries.publish(message)

    def _give_joints(self, joints: JointState) -> None:
        for action in self._actions:
            action.take(joints)
        self._controllers.hold()
        message = RosJointState()
        self._stamp(message.header, joints.stamp)
        message.name, message.position = list(joints.names), list(joints.positions)
        self._joints.publish(message)

    def _give_scan(self, scan: LaserScan) -> None:
        message = RosScan()
        self._stamp(message.header, scan.stamp)
        message.header.frame_id = scan.frame
        message.angle_min, message.angle_increment = scan.angle_min, scan.angle_increment
        message.angle_max = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
        message.range_min, message.range_max = scan.range_min, scan.range_max
        message.ranges, message.intensities = scan.ranges.tolist(), scan.intensities.tolist()
        self._scans.publish(message)

    def _spin(self) -> None:
        executor = SingleThreadedExecutor()
        executor.add_node(self._node)
        try:
            executor.spin()
        except ExternalShutdownException:
            return


async def play(options: argparse.Namespace) -> None:
    """Play the robot until standard input ends."""
    player = Ros2Player(load_ros2_config(options.robot), options)
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    moving = asyncio.create_task(player.run(), name="player")
    async for line in reader:
        player.fault(line.decode())
    moving.cancel()


def main() -> int:
    """Play the robot of the command line."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    end_with_parent()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser)
    parser.add_argument("--domain", type=int, default=None, help="ROS_DOMAIN_ID")
    parser.add_argument("--sim-time", action="store_true", help="publish /clock, and stamp by it")
    parser.add_argument("--goals", type=Path, default=None, help="file for what becomes of goals")
    asyncio.run(play(parser.parse_args()))
    return 0


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    os._exit(status)  # rclpy's exit handlers wait for its thread

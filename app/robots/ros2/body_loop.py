"""The control loop of the process of a robot over ROS 2: the guard decides and its velocity is sent, many times a
second, whatever comes or does not come from program and robot."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from app.base.kinematic_model import KinematicModel, load_model
from app.messages import Image, JointState
from app.robots import guard
from app.robots.body_process import Unavailable
from app.robots.guarded_base import GuardedBase
from app.robots.guarded_joints import GuardedJoints
from app.robots.link_protocol import Demand, Ready, Sample, Socket, Stop
from app.robots.ros2.body_node import BodyNode
from app.robots.ros2.config import STATUS_HZ, Ros2Config
from app.robots.ros2.health import fault, faults
from app.robots.ros2.protocol import Start

MakeNode: TypeAlias = Callable[[Ros2Config, KinematicModel, float, Callable[[], None]], BodyNode]
"""Makes a node, with the arguments of :class:`app.robots.ros2.body_node.BodyNode`."""


class BodyLoop:
    """The robot of ``start``, by the node that ``make_node`` makes, for the program at the other end of ``sock``."""

    def __init__(self, make_node: MakeNode, start: Start, sock: Socket) -> None:
        config = start.config
        self._config: Ros2Config = config
        self._socket = sock
        self._offset = start.clock_offset
        self._limits = config.limits.guard()
        self._period_s = 1.0 / config.base.rate_hz
        self._base = GuardedBase(self._limits, start.e_stop)
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_read, False)
        os.set_blocking(self._wake_write, False)
        model = load_model(config.model)
        self._unmoved = dict.fromkeys(model.joint_names, 0.0)
        self._node = make_node(config, model, start.clock_offset, self._wake)
        self._node.want(frozenset(start.demanded))
        self._joints = GuardedJoints(config.groups.values())
        self._joints_due = dict.fromkeys(config.groups, 0.0)
        self._reported = self._moved = 0.0
        self._ending = False

    def end(self) -> None:
        """Have :meth:`run` stop the base and return; may be called from a signal handler."""
        self._ending = True
        self._wake()

    def run(self) -> None:
        """Run until the end. Raises Unavailable, having stopped the base, and errors of the node's thread."""
        began = time.monotonic()
        self._node.start()
        try:
            if self._found(began):
                self._socket.send(Ready(setup_s=time.monotonic() - began))
                if self._config.base.watchdog_s is None:
                    self._say(f"{self._config.name} has no watchdog of its own: it drives on where this computer fails")
                self._drive()
        finally:
            # The last word, whatever ended it.
            self._node.publish(guard.ZERO, self._now())
            self._node.close()
            self._socket.flush()
            self._socket.close()

    def _found(self, began: float) -> bool:
        """Wait until all is there that driving requires; False where the program ended before. Raises Unavailable."""
        within_s = self._config.graph.found_within_s
        while not self._ended():
            now = self._now()
            reasons = faults(self._node.required, self._node.commands, now, self._limits.sensor_timeout_s)
            if not reasons:
                return True
            if (mistake := self._node.mistake) is not None:
                raise Unavailable(str(mistake))
            if time.monotonic() - began > within_s:
                others = ", ".join(self._node.topics()) or "none"
                raise Unavailable(
                    f"{self._config.name} was not found within {within_s:g} s: {'; '.join(reasons)}. "
                    f"Topics that are there: {others}."
                )
            self._wait(self._period_s)
        return False

    def _drive(self) -> None:
        due = before = time.monotonic()
        while not self._ended():
            now = time.monotonic()
            if now >= due:
                self._turn(now, min(now - before, 2 * self._period_s))
                before, due = now, max(due + self._period_s, now)
            self._hand_over()
            self._wait(max(due - time.monotonic(), 0.0))

    def _turn(self, monotonic: float, seconds: float) -> None:
        now = monotonic + self._offset
        reasons = faults(self._node.required, self._node.commands, now, self._limits.sensor_timeout_s)
        self._base.step(now, seconds, reasons)
        self._node.publish(self._base.velocity, now)
        self._turn_joints(monotonic, seconds)
        if monotonic - self._reported >= 1.0 / STATUS_HZ:
            self._reported = monotonic
            self._send("status", replace(self._base.status(now), groups=self._joints.status(now)))
        if self._config.streams.joints is None and monotonic - self._moved >= 1.0 / self._config.standing_rates_hz[1]:
            self._moved = monotonic
            self._send("joints", JointState(now, tuple(self._unmoved), tuple(self._unmoved.values())))

    def _turn_joints(self, monotonic: float, seconds: float) -> None:
        if not self._joints_due:
            return
        now = monotonic + self._offset
        silent = fault(self._node.joints, now, self._limits.sensor_timeout_s)
        topics, actions = self._node.joint_commands, self._node.joint_actions
        faults = {name: silent or reason for name, reason in (topics.faults | actions.faults).items()}
        self._joints.step(now, seconds, self._base.e_stop, faults, actions.refusals)
        for name, due in self._joints_due.items():
            if name in actions:
                if not self._joints.moves(name):
                    actions.halt(name)
                elif actions.ready(name) and (positions := self._joints.due(name)):
                    actions.publish(name, positions)
            elif monotonic >= due and (positions := self._joints.due(name)):
                topics.publish(name, positions)
                self._joints_due[name] = monotonic + 1.0 / self._config.joint_commands[name].hz

    def _ended(self) -> bool:
        """Read what the program sent; whether it is over. Raises Unavailable and errors of the node's thread."""
        for frame in self._socket.receive():
            match frame:
                case Demand(stream, rate_hz):
                    wanted = self._node.wanted - {stream}
                    self._node.want(wanted | {stream} if rate_hz > 0 else wanted)
                case Stop():
                    self._ending = True
                case _:
                    self._base.take(frame)
                    self._joints.take(frame)
        if self._node.failure is not None:
            raise self._node.failure
        if self._node.void:
            raise Unavailable(self._node.void)
        return self._ending or self._socket.closed

    def _hand_over(self) -> None:
        while self._node.arrived:
            stream, message = self._node.arrived.popleft()
            if isinstance(message, JointState):
                self._joints.measure(dict(zip(message.names, message.positions, strict=True)))
            if isinstance(message, Image):
                self._socket.flush()
                if self._socket.has_unsent:
                    continue  # the program still reads what came before: a queue of pictures would make all else late
            self._send(stream, message)
        while self._node.cautions:
            self._say(self._node.cautions.popleft())
        self._socket.flush()

    def _send(self, stream: str, message: object) -> None:
        self._socket.send(Sample(stream, message))

    def _say(self, sentence: str) -> None:
        print(sentence, file=sys.stderr, flush=True)

    def _wake(self) -> None:
        with contextlib.suppress(BlockingIOError):  # full: the loop is already being woken
            os.write(self._wake_write, b"\0")

    def _wait(self, timeout_s: float) -> None:
        link = self._socket.fileno()
        ready, _, _ = select.select([link, self._wake_read], [link] if self._socket.has_unsent else [], [], timeout_s)
        if self._wake_read in ready:
            os.read(self._wake_read, 4096)

    def _now(self) -> float:
        return time.monotonic() + self._offset

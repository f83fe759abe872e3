"""What the node asks of rosbridge, and by which of its two connections."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from app.base.kinematic_model import load_model
from app.robots.guard import BaseVelocity
from app.robots.ros2.health import faults
from app.robots.ros2.rosbridge import connection
from app.robots.ros2.rosbridge.node import RosbridgeNode
from tests.patience import PATIENCE_S
from tests.robots.ros2.robot import MAPPING
from tests.robots.ros2.rosbridge.robot import mapping

Message = dict[str, Any]
MODEL = load_model(MAPPING.parent / "turtlebot4.urdf")


class Recorder:
    """A server that notes what each of its connections asks, in the order in which they opened, and answers nothing."""

    def __init__(self) -> None:
        self.asked: list[list[Message]] = []
        self.changed = asyncio.Event()

    async def serve(self, websocket: ServerConnection) -> None:
        """Note all of one connection."""
        messages: list[Message] = []
        self.asked.append(messages)
        try:
            async for frame in websocket:
                messages.append(json.loads(frame))
                self.changed.set()
        except ConnectionClosed:
            return

    async def wait_for(self, found: Callable[[], bool]) -> None:
        """Wait until ``found()``."""
        async with asyncio.timeout(PATIENCE_S):
            while not found():
                self.changed.clear()
                await self.changed.wait()

    def of(self, op: str, key: str) -> list[set[str]]:
        """What the connections asked with ``op``: the values of ``key``."""
        return [{message[key] for message in messages if message["op"] == op} for messages in self.asked]


@pytest.mark.blocking(reason="reads a mapping before anything is on the loop")
async def test_nothing_that_is_large_or_slow_comes_before_commands_and_odometry() -> None:
    recorder = Recorder()
    loop = asyncio.get_running_loop()
    async with serve(recorder.serve, "127.0.0.1", 0) as server:
        url = f"ws://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}"

        def wake() -> None:
            loop.call_soon_threadsafe(recorder.changed.set)

        node = RosbridgeNode(mapping(url), MODEL, 0.0, wake)
        node.want(frozenset({"camera", "hokuyo"}))
        assert node.required[0].problem == f"rosbridge at {url} does not answer"
        node.start()
        camera = {"/oakd/rgb/preview/image_raw", "/oakd/rgb/preview/camera_info"}
        others = {"/odom", "/scan", "/joint_states", "/tf_static"}
        await recorder.wait_for(lambda: camera in recorder.of("subscribe", "topic"))
        await recorder.wait_for(lambda: others in recorder.of("subscribe", "topic"))
        await recorder.wait_for(lambda: {"/rosapi/topics"} in recorder.of("call_service", "service"))
        pictures = recorder.of("subscribe", "topic").index(camera)
        assert recorder.of("advertise", "topic") == ([set(), {"/cmd_vel"}] if pictures == 0 else [{"/cmd_vel"}, set()])
        assert recorder.of("call_service", "service")[1 - pictures] == set()
        # It is not known yet whether anything listens: the base must not drive. Without rosapi it never will be.
        (reason,) = faults((), node.commands, 0.0, 1.0)
        assert reason == "base (/cmd_vel): rosapi has not said yet who listens"
        await recorder.wait_for(lambda: faults((), node.commands, 0.0, 1.0) == ())
        assert list(node.cautions) == [
            f"rosapi does not answer at {url} within 2 s: who listens to /cmd_vel, and by which type, is not known"
        ]
        node.want(frozenset({"hokuyo"}))
        await recorder.wait_for(lambda: recorder.of("unsubscribe", "topic")[pictures] >= camera)
        # The last word arrives before the connection closes.
        node.publish(BaseVelocity(0.1), 5.0)
        node.publish(BaseVelocity(0.0), 5.0)
        await asyncio.to_thread(node.close)
        published = [message for message in recorder.asked[1 - pictures] if message["op"] == "publish"]
        assert published[-1]["msg"]["twist"]["linear"]["x"] == 0.0


@pytest.mark.blocking(reason="reads a mapping before anything is on the loop")
async def test_a_server_that_gives_and_does_not_take_forbids_driving(monkeypatch: pytest.MonkeyPatch) -> None:
    # What is heard stays fresh, and the connection is not given up: the answers alone are late.
    monkeypatch.setattr(connection, "LOST_S", PATIENCE_S)
    changed = asyncio.Event()

    async def give(websocket: ServerConnection) -> None:
        await websocket.recv()
        websocket.transport.pause_reading()
        while True:
            await websocket.send("{}")
            changed.set()
            await asyncio.sleep(0.05)

    async with serve(give, "127.0.0.1", 0, close_timeout=0.1) as server:
        url = f"ws://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}"
        config = mapping(url)
        patient = config.limits.model_copy(update={"sensor_timeout_s": PATIENCE_S})
        node = RosbridgeNode(config.model_copy(update={"limits": patient}), MODEL, 0.0, lambda: None)
        node.start()
        seen: list[str] = []
        async with asyncio.timeout(PATIENCE_S):
            while seen[-2:] != ["", f"rosbridge at {url} does not answer"]:
                changed.clear()
                await changed.wait()
                problem = node.required[0].problem
                seen += [problem] if not seen or seen[-1] != problem else []
        await asyncio.to_thread(node.close)

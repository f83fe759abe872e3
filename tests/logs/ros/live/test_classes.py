"""Classes made for rclpy against those that ROS 2's own generators made of the same definitions."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.logs.ros.live.classes import message_class, service_class
from tests.patience import PATIENCE_S
from tests.robots.ros2.robot import domain, needs_ros2

pytestmark = [
    pytest.mark.slow,
    needs_ros2,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # of the parser that rclpy imports
]

SCAN, PLAN = "sensor_msgs/msg/LaserScan", "nav_msgs/srv/GetPlan"
REQUEST = "geometry_msgs/PoseStamped start\ngeometry_msgs/PoseStamped goal\nfloat32 tolerance\n"


@pytest.fixture
def spin(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Any, Callable[[Callable[[], object]], None]]]:
    """A node on this computer alone, and what turns its executor until something is true."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], context=context, domain_id=domain())
    node = rclpy.create_node("types", context=context, enable_rosout=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)

    def until(true: Callable[[], object]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not true():
            assert time.monotonic() < deadline
            executor.spin_once(timeout_sec=0.05)

    yield node, until
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)


def installed(name: str) -> dict[str, Any]:
    """What ROS 2's generator wrote of an installed type."""
    return json.loads(Path(sys.prefix, "share", f"{name}.json").read_text("utf-8"))


def test_types_are_those_of_rosidl(spin: Any) -> None:
    from nav_msgs.srv import GetPlan
    from sensor_msgs.msg import LaserScan
    from type_description_interfaces.srv import GetTypeDescription

    node, until = spin
    made: Any = message_class(SCAN)
    assert made is message_class(SCAN)
    plan = service_class(PLAN, REQUEST, "nav_msgs/Path plan\n")
    for name in (SCAN, PLAN):
        hashes = {each["type_name"]: each["hash_string"] for each in installed(name)["type_hashes"]}
        assert typestore.store().hash_rihs01(name) == hashes[name]

    # A made one is heard by ROS 2's own, and hears it.
    heard: list[Any] = []
    rosidl: Any = LaserScan
    for writer, reader in ((made, rosidl), (rosidl, made)):
        node.create_subscription(reader, writer.__module__.replace(".", "_"), heard.append, 10)
        publisher = node.create_publisher(writer, writer.__module__.replace(".", "_"), 10)
        until(lambda publisher=publisher: publisher.get_subscription_count() == 1)
        if reader is not rosidl:
            native = rosidl(ranges=[1.0, 2.5], angle_min=-1.5)
            native.header.frame_id = "é"
            publisher.publish(native)
        else:
            scan = blank(SCAN, ranges=np.array([1.0, 2.5], np.float32), angle_min=-1.5)
            scan.header.frame_id = "é"
            cdr = bytes(typestore.store().serialize_cdr(scan, SCAN))
            publisher.publish(made(cdr))
            publisher.publish(cdr)
        until(lambda count=2 if writer is made else 3: len(heard) == count)
    for scan in (heard[0], heard[1], heard[2].read()):
        assert (scan.header.frame_id, list(scan.ranges), scan.angle_min) == ("é", [1.0, 2.5], -1.5)
    offered = {
        info.topic_type_hash.value
        for info in node.get_publishers_info_by_topic(f"/{made.__module__}".replace(".", "_"))
    }
    assert {bytes(value).hex() for value in offered} == {typestore.store().hash_rihs01(SCAN).removeprefix("RIHS01_")}

    # The same of services, and the node says what the made types are.
    def answer(request: Any, response: Any) -> Any:
        if isinstance(response, plan.Response):
            path = blank("nav_msgs/msg/Path")
            path.header.frame_id = request.read().start.header.frame_id
            return plan.Response.of(path)
        response.plan.header.frame_id = request.start.header.frame_id
        return response

    for server, client, name in ((plan, GetPlan, "made"), (GetPlan, plan, "native")):
        node.create_service(server, name, answer)
        caller = node.create_client(client, name)
        until(caller.service_is_ready)
        if client is plan:
            start = blank("geometry_msgs/msg/PoseStamped")
            start.header.frame_id = "from here"
            request = plan.Request.of(start, blank("geometry_msgs/msg/PoseStamped"), 0.5)
        else:
            request = GetPlan.Request()
            request.start.header.frame_id = "from here"
        future = caller.call_async(request)
        until(future.done)
        answered = future.result() if client is GetPlan else future.result().read()
        assert answered.plan.header.frame_id == "from here"

    typestore.add("hbba_msgs/msg/Kinds", "bool[2] flags\nstring<=4[] words\nuint8[<=3] few\nhbba_msgs/Kind[] kinds\n")
    typestore.add("hbba_msgs/msg/Kind", "float64 number\n")
    node.create_publisher(message_class("hbba_msgs/msg/Kinds"), "kinds", 10)
    asking = node.create_client(GetTypeDescription, "/types/get_type_description")
    until(asking.service_is_ready)
    digest = typestore.store().hash_rihs01("hbba_msgs/msg/Kinds")
    future = asking.call_async(GetTypeDescription.Request(type_name="hbba_msgs/msg/Kinds", type_hash=digest))
    until(future.done)
    described = future.result().type_description
    kinds = [(each.name, each.type) for each in described.type_description.fields]
    assert [(name, kind.type_id, kind.capacity, kind.string_capacity) for name, kind in kinds] == [
        ("flags", 63, 2, 0), ("words", 165, 0, 4), ("few", 99, 3, 0), ("kinds", 145, 0, 0),
    ]  # fmt: skip
    assert [each.type_name for each in described.referenced_type_descriptions] == ["hbba_msgs/msg/Kind"]

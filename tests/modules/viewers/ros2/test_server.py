"""The program in a real graph of ROS 2, as another node sees it."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from typing import Any

import numpy as np
import pytest

from app.attention.desires import DesireClasses
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.logs.manifest import Manifest
from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.logs.ros.live.classes import message_class, service_class
from app.messages import Accomplishment, Localization, NavigationReport, OccupancyGrid, read_only
from app.modules.behaviors.go_to import GO_TO
from app.modules.viewers.ros2 import desires, navigate
from app.modules.viewers.ros2.server import Ros2Server
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.clock import RealClock
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.supervisor import Supervisor
from tests.logs.mcap.disks import MANIFEST, landmarks, odometry
from tests.patience import PATIENCE_S
from tests.robots.ros2.robot import domain, needs_ros2

pytestmark = [
    pytest.mark.slow,
    needs_ros2,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # of the parser that rclpy imports
]

_ROWS: dict[str, dict[str, Any]] = {
    "odometry": {"type": "Odometry", "rate_hz": 100},
    "landmarks": {"type": "Landmarks", "latched": True},
    "map": {"type": "OccupancyGrid", "latched": True},
    "localization": {"type": "Localization"},
    "navigation_report": {"type": "NavigationReport", "latched": True},
    "recorder": {"type": "RecorderStatus", "log": "never"},
}
TABLE = ChannelTable({name: ChannelSpec.model_validate({"external": True, **row}) for name, row in _ROWS.items()})
DOMAIN = domain()
GRID = OccupancyGrid(12.0, "map", read_only(np.array([[0, 100, -1]], np.int8)), 0.05, (1.0, 2.0), 3)
PLACE = Localization(
    12.5, Pose2(1.0, 0.0, 0.5), Pose2(3.0, 1.0, 0.5), read_only(np.diag([0.01, 0.02, 0.03])), "tracking", 0.9, "lab"
)


class Robot:
    """A program of one module, the server; other channels come from outside."""

    def __init__(self) -> None:
        settings = {"domain": DOMAIN, "discovery": "localhost", "commands": True}
        spec = ModuleSpec.model_validate({"class": "app.modules.viewers.ros2.server:Ros2Server", "settings": settings})
        self.clock = RealClock()
        self.workspace = IntentionWorkspace(DesireClasses([GO_TO]), self.clock.now)
        self.graph = Graph(
            clock=self.clock,
            channels=TABLE,
            modules={"Ros2Server": spec},
            services={Manifest: MANIFEST, ChannelTable: TABLE, IntentionWorkspace: self.workspace},
        )
        for port in self.graph.modules["Ros2Server"].context.inputs.values():
            port.subscription.demand(False)
        self.supervisor = Supervisor(self.graph.modules, self.clock)

    @property
    def server(self) -> Ros2Server:
        module = self.graph.modules["Ros2Server"].module
        assert isinstance(module, Ros2Server)
        return module

    def feed(self, channel: str, message: Any) -> None:
        self.graph.channel(channel).publish(message)

    def wanted(self, channel: str) -> bool:
        return self.graph.channel(channel).wanted


@asynccontextmanager
async def running() -> AsyncIterator[Robot]:
    robot = Robot()
    async with robot.supervisor:
        await asyncio.wait_for(robot.supervisor.started(), PATIENCE_S)
        yield robot


async def until(true: Callable[[], object]) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not true():  # noqa: ASYNC110  # the event is in another thread, or another process
            await asyncio.sleep(0.01)


class Other:
    """Another node, turned by a thread of its own."""

    def __init__(self, context: Any) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], context=context, domain_id=DOMAIN)
        self.context = context
        self.node = rclpy.create_node("other", context=context, enable_rosout=False)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.thread = threading.Thread(target=self.executor.spin)
        self.thread.start()

    def listen(self, kind: Any, topic: str, *, latched: bool = False) -> list[Any]:
        from rclpy.qos import DurabilityPolicy, QoSProfile

        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        heard: list[Any] = []
        self.node.create_subscription(kind, topic, heard.append, QoSProfile(depth=10, durability=durability))
        self.executor.wake()
        return heard

    async def call(self, service: Any, name: str, *fields: Any) -> Any:
        future = await self.asked(service, name, *fields)
        await until(future.done)
        return future.result().read()

    async def asked(self, service: Any, name: str, *fields: Any) -> Any:
        client = self.node.create_client(service, name)
        await until(client.service_is_ready)
        return client.call_async(service.Request.of(*fields))

    def close(self) -> None:
        import rclpy

        self.executor.shutdown()
        self.thread.join()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.fixture
def other(monkeypatch: pytest.MonkeyPatch) -> Iterator[Other]:
    import rclpy

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    node = Other(rclpy.Context())
    yield node
    node.close()


def uuid(number: int) -> Any:
    return blank("unique_identifier_msgs/msg/UUID", uuid=np.full(16, number, np.uint8))


def goal(frame: str, x: float) -> Any:
    made = blank(f"{navigate.ACTION}_Goal")
    made.pose.header.frame_id, made.pose.pose.position.x, made.pose.pose.orientation.w = frame, x, 1.0
    return made


async def test_what_the_program_knows_is_on_topics(other: Other) -> None:
    from geometry_msgs.msg import PoseWithCovarianceStamped
    from nav_msgs.msg import OccupancyGrid as RosGrid
    from nav_msgs.msg import Odometry as RosOdometry

    async with running() as robot:
        robot.feed("map", GRID)
        robot.feed("landmarks", landmarks(5.0, "a code"))
        assert not any(map(robot.wanted, _ROWS))

        heard = other.listen(RosOdometry, "/hbba/odometry")
        await until(lambda: robot.wanted("odometry"))
        assert not robot.wanted("localization")
        sent = odometry(1_790_000_001.5)
        robot.feed("odometry", sent)
        await until(lambda: heard)
        assert (heard[0].header.frame_id, heard[0].child_frame_id) == ("odom", "base_link")
        assert heard[0].pose.pose.position.x == sent.X_OB.x
        assert heard[0].header.stamp.sec + 1e-9 * heard[0].header.stamp.nanosec == sent.stamp

        # What was said before there is a subscriber: the map, and a type that no package of ROS 2 has.
        maps = other.listen(RosGrid, "/hbba/map", latched=True)
        await until(lambda: maps)
        assert (list(maps[0].data), maps[0].info.resolution) == ([0, 100, -1], pytest.approx(0.05))
        assert (maps[0].info.origin.position.x, maps[0].header.frame_id) == (1.0, "map")

        places = other.listen(PoseWithCovarianceStamped, "/hbba/localization/pose")
        percepts = other.listen(message_class("hbba_msgs/msg/Localization"), "/hbba/localization")
        frames = other.listen(message_class("tf2_msgs/msg/TFMessage"), "/tf")
        names = {info.node_name for info in other.node.get_publishers_info_by_topic("/tf")}
        assert names == {"hbba"}
        await until(lambda: robot.wanted("localization") and len(robot.server.shown) == 5)
        robot.feed("localization", PLACE)
        await until(lambda: places and percepts and frames)
        assert places[0].pose.pose.position.x == 3.0
        assert [places[0].pose.covariance[index] for index in (0, 7, 35)] == [0.01, 0.02, 0.03]
        (transform,) = frames[0].read().transforms
        assert (transform.header.frame_id, transform.child_frame_id) == ("map", "odom")
        assert transform.transform.translation.x == 1.0
        assert (percepts[0].read().state, percepts[0].read().map) == ("tracking", "lab")

        # The process dies: it comes again, and who listens goes on hearing.
        process = robot.server.process_id
        assert process is not None
        os.kill(process, signal.SIGKILL)
        await until(lambda: robot.server.process_id not in (None, process) and robot.wanted("odometry"))
        robot.feed("odometry", sent)
        await until(lambda: len(heard) == 2)


async def test_others_desire_and_give_goals(other: Other) -> None:
    for name, text in navigate.definitions():
        typestore.add(name, text)
    add, remove = (service_class(each.type, each.request, each.response) for each in (desires.ADD, desires.REMOVE))
    send, cancel, result = (
        service_class(each.type, each.request, each.response) for each in navigate.services("navigate_to_pose")
    )
    feedback = other.listen(message_class(navigate.FEEDBACK), "/navigate_to_pose/_action/feedback")
    statuses = other.listen(message_class(navigate.STATUS), "/navigate_to_pose/_action/status", latched=True)
    async with running() as robot:
        answer = await other.call(add, "/hbba/add_desire", "GoTo", 3.0, 1.0, False, '{"x": 1, "y": 2}', 30.0)
        assert (answer.success, answer.message) == (True, "")
        assert robot.workspace.get(answer.id).params["y"] == 2.0
        assert (await other.call(remove, "/hbba/remove_desire", answer.id)).success
        again = await other.call(remove, "/hbba/remove_desire", answer.id)
        assert (again.success, answer.id in again.message) == (False, True)
        wrong = await other.call(add, "/hbba/add_desire", "GoTo", 3.0, 1.0, False, '{"x": 1}', 0.0)
        assert (wrong.success, "y" in wrong.message, robot.workspace.desires()) == (False, True, ())

        from rclpy.action import get_action_names_and_types

        # ROS 2 takes these services and topics for an action.
        actions = dict(get_action_names_and_types(other.node))
        assert actions["/navigate_to_pose"] == ["nav2_msgs/action/NavigateToPose"]
        name = "/navigate_to_pose/_action"
        assert not (await other.call(send, f"{name}/send_goal", uuid(1), goal("base_scan", 1.0))).accepted
        assert (await other.call(send, f"{name}/send_goal", uuid(2), goal("map", 1.5))).accepted
        (desire,) = robot.workspace.desires()
        assert (desire.cls, desire.params["x"], desire.params["heading"]) == ("GoTo", 1.5, 0.0)
        await until(lambda: robot.wanted("navigation_report") and robot.wanted("localization"))
        robot.feed("localization", PLACE)
        robot.feed("navigation_report", NavigationReport(
            1.0, "PlanAndFollowPath", "following", "", Pose2(1.5, 0.0, 0.0), None, 2.5, 1, desire.id,
            read_only(np.zeros((0, 2))), None,
        ))  # fmt: skip
        await until(lambda: feedback and feedback[-1].read().feedback.number_of_recoveries == 1)
        how = feedback[-1].read().feedback
        assert (how.distance_remaining, how.current_pose.pose.position.x) == (2.5, 3.0)
        waiting = await other.asked(result, f"{name}/get_result", uuid(2))
        robot.workspace.accomplish(Accomplishment(robot.clock.now(), desire.id, "PlanAndFollowPath", "done", ""))
        await until(waiting.done)
        assert waiting.result().read().status == navigate.SUCCEEDED

        assert (await other.call(send, f"{name}/send_goal", uuid(3), goal("", 2.0))).accepted
        info = blank("action_msgs/msg/GoalInfo", goal_id=uuid(3))
        cancelled = await other.call(cancel, f"{name}/cancel_goal", info)
        assert (cancelled.return_code, len(cancelled.goals_canceling)) == (0, 1)
        assert (await other.call(result, f"{name}/get_result", uuid(3))).status == navigate.CANCELED
        assert robot.workspace.desires() == ()
        await until(lambda: statuses and [each.status for each in statuses[-1].read().status_list] == [4, 5])

        assert (await other.call(send, f"{name}/send_goal", uuid(4), goal("map", 2.0))).accepted
        assert len(robot.workspace.desires()) == 1
    # The program ends: the robot does not drive on for a client that hears no more of it.
    assert robot.workspace.desires() == ()

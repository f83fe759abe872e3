from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.messages import Accomplished, Accomplishment
from app.modules.behaviors.go_to import GO_TO
from app.modules.viewers.ros2 import navigate
from app.modules.viewers.ros2.navigate import ABORTED, ACTION, CANCELED, EXECUTING, SUCCEEDED, NavigateToPose

for each, text in navigate.definitions():
    typestore.add(each, text)
for service in navigate.services("go"):
    typestore.add(f"{service.type}_Request", service.request)
    typestore.add(f"{service.type}_Response", service.response)


class Served:
    """The action, and what it says."""

    def __init__(self) -> None:
        self.now = 100.0
        self.workspace = IntentionWorkspace(DesireClasses([GO_TO]), lambda: self.now)
        self.answers: list[tuple[int, Any]] = []
        self.action = NavigateToPose(
            self.workspace,
            lambda: self.now,
            lambda call, response: self.answers.append((call, response)),
            lambda: None,
            logging.getLogger("test"),
        )
        self.workspace.observe(lambda _: self.action.look())

    def send(self, number: int, frame: str = "map", **turn: float) -> bool:
        goal = blank(f"{ACTION}_Goal")
        goal.pose.header.frame_id, goal.pose.pose.position.x = frame, float(number)
        for name, value in (turn or {"w": 1.0}).items():
            setattr(goal.pose.pose.orientation, name, value)
        request = blank(f"{ACTION}_SendGoal_Request", goal_id=uuid(number), goal=goal)
        return bool(self.action.send_goal(request).accepted)

    def cancel(self, number: int = 0, stamp: float = 0.0) -> tuple[int, int]:
        info = blank("action_msgs/msg/GoalInfo", goal_id=uuid(number), stamp=typestore.time(int(stamp * 1e9)))
        response = self.action.cancel(blank("action_msgs/srv/CancelGoal_Request", goal_info=info))
        return int(response.return_code), len(response.goals_canceling)

    def result(self, number: int, call: int = 0) -> Any:
        return self.action.get_result(call, blank(f"{ACTION}_GetResult_Request", goal_id=uuid(number)))

    def accomplish(self, outcome: Accomplished) -> None:
        (desire,) = self.workspace.desires()
        self.workspace.accomplish(Accomplishment(self.now, desire.id, "PlanAndFollowPath", outcome, "there is a wall"))

    @property
    def statuses(self) -> list[int]:
        return [int(each.status) for each in self.action.status().status_list]


def uuid(number: int) -> Any:
    return blank("unique_identifier_msgs/msg/UUID", uuid=np.full(16, number, np.uint8))


@pytest.mark.parametrize(("outcome", "status"), [("done", SUCCEEDED), ("failed", ABORTED)])
def test_a_goal_ends_as_its_desire(outcome: Accomplished, status: int) -> None:
    served = Served()
    assert served.send(1)
    assert (served.result(1, 7), served.result(1, 8), served.statuses) == (None, None, [EXECUTING])
    served.accomplish(outcome)
    assert [(call, int(response.status)) for call, response in served.answers] == [(7, status), (8, status)]
    assert int(served.result(1).status) == status
    assert served.result(1).result.error_code == (0 if status == SUCCEEDED else navigate.UNKNOWN)
    assert (served.statuses, served.action.pursued, served.action.feedback(None, None)) == ([status], False, None)


def test_a_new_goal_ends_the_one_before() -> None:
    served = Served()
    assert served.send(1)
    assert served.send(2)
    assert served.statuses == [ABORTED, EXECUTING]
    (desire,) = served.workspace.desires()
    assert desire.params["x"] == 2.0
    assert not served.send(2)  # an id is one goal's
    served.workspace.remove(desire.id)  # at the console
    assert served.statuses == [ABORTED, ABORTED]


def test_goals_are_cancelled_by_id_by_time_and_all() -> None:
    served = Served()
    served.send(1)
    assert served.cancel(9) == (2, 0)
    assert served.cancel(1) == (0, 1)
    assert served.cancel(1) == (3, 0)
    served.send(2)
    assert served.cancel(stamp=99.0) == (0, 0)
    assert served.cancel(stamp=100.0) == (0, 1)
    served.send(3)
    assert served.cancel() == (0, 1)
    assert (served.statuses, served.workspace.desires()) == ([CANCELED] * 3, ())


def test_where_goals_may_be() -> None:
    served = Served()
    assert not served.send(1, "base_scan")
    assert not served.send(2, "odom")  # where that is on the map is not known
    assert not served.send(3, w=math.nan)
    served.action.X_MO = Pose2(10.0, 0.0, math.pi / 2)
    assert served.send(4, "odom")
    params = served.workspace.desires()[0].params
    assert (params["x"], params["y"], params["heading"]) == pytest.approx((10.0, 4.0, math.pi / 2))
    assert served.send(5, "/map", w=math.cos(-0.4), z=math.sin(-0.4))
    assert served.workspace.desires()[0].params["heading"] == pytest.approx(-0.8)
    assert served.send(6, "", w=0.0)
    assert served.workspace.desires()[0].params["heading"] is None


def test_a_program_that_goes_nowhere_refuses() -> None:
    served = Served()
    served.workspace = IntentionWorkspace(DesireClasses([]), lambda: 1.0)
    served.action = NavigateToPose(
        served.workspace, lambda: 1.0, lambda *_: None, lambda: None, logging.getLogger("test")
    )
    assert (served.send(1), served.statuses) == (False, [])


def test_old_goals_are_forgotten_and_desires_of_others_stay() -> None:
    served = Served()
    other = served.workspace.add("GoTo", intensity=1, utility=1, params={"x": 0, "y": 0}, source=Source("rest", "x"))
    for number in range(1, 60):
        assert served.send(number)
    assert len(served.statuses) <= 34
    assert served.statuses[-1] == EXECUTING
    served.action.end()
    assert served.workspace.desires() == (other,)
    assert int(served.result(1).status) == 0


def test_definitions_are_those_of_the_ros_that_is_sourced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "share" / "nav2_msgs" / "action" / "NavigateToPose.action"
    file.parent.mkdir(parents=True)
    file.write_text("int32 a\n---\nstd_msgs/Empty result\n ---  \nint8 b\n", "utf-8")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}")
    parts = dict(navigate.definitions())
    assert parts[f"{ACTION}_Result"].strip() == "std_msgs/Empty result"
    assert parts[f"{ACTION}_Feedback"].strip() == "int8 b"

"""Nav2's action NavigateToPose, served: a goal is a desire of class GoTo, and ends with it.

An action is three services and two topics (ROS 2's design of actions); the definitions are those of the ROS 2 that is
sourced, or of Jazzy. One goal is pursued at a time: a new one ends the one before, as with Nav2.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.attention.desires import InvalidDesire, UnknownDesireClass
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.base.geometry import Pose2
from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.logs.ros.live.graph import installed_definition
from app.logs.stamps import to_ns
from app.messages import NavigationReport
from app.modules.viewers.ros2.desires import SOURCE
from app.modules.viewers.ros2.protocol import Service, Topic

GO_TO = "GoTo"
ACTION = "nav2_msgs/action/NavigateToPose"
STATUS, FEEDBACK = "action_msgs/msg/GoalStatusArray", f"{ACTION}_FeedbackMessage"
EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = 2, 3, 4, 5, 6
#: ``error_code`` of a goal that was not reached: Nav2's for what it does not know either.
UNKNOWN = 9000
#: Of a desire that a goal becomes.
INTENSITY, UTILITY = 4.0, 1.0
_KEPT = 32
_OF_JAZZY = """\
geometry_msgs/PoseStamped pose
string behavior_tree
---
uint16 error_code
---
geometry_msgs/PoseStamped current_pose
builtin_interfaces/Duration navigation_time
builtin_interfaces/Duration estimated_time_remaining
int16 number_of_recoveries
float32 distance_remaining
"""
_UUID = "unique_identifier_msgs/UUID goal_id\n"


def definitions() -> tuple[tuple[str, str], ...]:
    """The parts of the action, and what of it is not a service."""
    text = installed_definition(f"{ACTION}.action") or _OF_JAZZY
    parts = "\n".join("---" if line.strip() == "---" else line for line in text.splitlines()).split("\n---\n")
    named = zip(("Goal", "Result", "Feedback"), parts, strict=True)
    return (*((f"{ACTION}_{part}", lines) for part, lines in named), (FEEDBACK, f"{_UUID}{ACTION}_Feedback feedback\n"))


def services(action: str) -> tuple[Service, Service, Service]:
    """Send a goal, cancel, get the result, of the action of this name."""
    return (
        Service(
            f"{action}/_action/send_goal", f"{ACTION}_SendGoal",
            f"{_UUID}{ACTION}_Goal goal\n", "bool accepted\nbuiltin_interfaces/Time stamp\n",
        ),
        Service(
            f"{action}/_action/cancel_goal", "action_msgs/srv/CancelGoal",
            "action_msgs/GoalInfo goal_info\n", "int8 return_code\naction_msgs/GoalInfo[] goals_canceling\n",
        ),
        Service(
            f"{action}/_action/get_result", f"{ACTION}_GetResult",
            _UUID, f"int8 status\n{ACTION}_Result result\n",
        ),
    )  # fmt: skip


def topics(action: str) -> tuple[Topic, Topic]:
    """Feedback and status of the action of this name."""
    return (
        Topic(f"{action}/_action/feedback", FEEDBACK),
        Topic(f"{action}/_action/status", STATUS, latched=True),
    )


@dataclass(slots=True)
class _Goal:
    """A goal that was accepted at ``began`` (robot's clock, s). ``waiting``: the calls for its result."""

    id: bytes
    desire: str
    began: float
    status: int = EXECUTING
    reason: str = ""
    waiting: list[int] = field(default_factory=list)

    @property
    def is_over(self) -> bool:
        return self.status in (SUCCEEDED, CANCELED, ABORTED)


class NavigateToPose:
    """The goals of the action. ``answer`` gives the result of a call that waited; ``changed`` is called when the status
    of some goal is another."""

    def __init__(
        self,
        workspace: IntentionWorkspace,
        now: Callable[[], float],
        answer: Callable[[int, Any], None],
        changed: Callable[[], None],
        log: logging.Logger,
    ) -> None:
        self._workspace = workspace
        self._now = now
        self._answer = answer
        self._changed = changed
        self._log = log
        self._goals: dict[bytes, _Goal] = {}
        #: ``map`` to ``odom``, None while it is not known.
        self.X_MO: Pose2 | None = None

    @property
    def pursued(self) -> bool:
        """Whether there is a goal that is not over."""
        return self._current() is not None

    def send_goal(self, request: Any) -> Any:
        """The response to a new goal."""
        now, uuid = self._now(), request.goal_id.uuid.tobytes()
        response = f"{ACTION}_SendGoal_Response"
        refused = blank(response, stamp=typestore.time(to_ns(now)))
        pose = self._on_map(request.goal.pose)
        if pose is None or uuid in self._goals:
            return refused
        params = {"x": pose.x, "y": pose.y} | ({} if math.isnan(pose.theta) else {"heading": pose.theta})
        before = self._current()
        try:
            with self._workspace.transaction():
                desire = self._workspace.add(GO_TO, intensity=INTENSITY, utility=UTILITY, params=params, source=SOURCE)
                if before is not None:
                    before.reason = "another goal came"
                    self._withdraw(before)
        except (UnknownDesireClass, InvalidDesire) as refusal:
            self._log.warning("a goal over ROS 2 was refused: %s", refusal)
            return refused
        self._goals[uuid] = _Goal(uuid, desire.id, now)
        over = [each.id for each in self._goals.values() if each.is_over]
        for each in over[: max(len(self._goals) - _KEPT, 0)]:
            del self._goals[each]
        self._changed()
        return blank(response, accepted=True, stamp=typestore.time(to_ns(now)))

    def cancel(self, request: Any) -> Any:
        """The response to a call that cancels goals: that of an id, those up to a time, or all."""
        uuid, stamp = request.goal_info.goal_id.uuid.tobytes(), typestore.seconds(request.goal_info.stamp)
        response = "action_msgs/srv/CancelGoal_Response"
        chosen = [
            goal
            for goal in self._goals.values()
            if goal.id == uuid or (stamp > 0 and goal.began <= stamp) or (not any(uuid) and stamp == 0)
        ]
        ending = [goal for goal in chosen if not goal.is_over]
        if not ending and any(uuid):
            return blank(response, return_code=np.int8(3 if chosen else 2))  # it is over, or was never there
        infos = [self._info(goal) for goal in ending]
        for goal in ending:
            goal.status, goal.reason = CANCELING, "cancelled"
            self._withdraw(goal)
        self.look()
        return blank(response, goals_canceling=infos)

    def get_result(self, call: int, request: Any) -> Any | None:
        """The result of a goal, None while it is pursued: then ``answer`` gives it."""
        goal = self._goals.get(request.goal_id.uuid.tobytes())
        if goal is None:
            return blank(f"{ACTION}_GetResult_Response")  # status 0: unknown
        if not goal.is_over:
            goal.waiting.append(call)
            return None
        return self._result(goal)

    def look(self) -> None:
        """See which goals' desires have left."""
        changed = False
        for goal in self._goals.values():
            if goal.is_over:
                continue
            try:
                report = self._workspace.report(goal.desire)
            except UnknownDesire:
                goal.status, goal.reason = ABORTED, "the time jumped"
            else:
                if report.ended is None:
                    continue
                cancelled = goal.status == CANCELING
                goal.status = SUCCEEDED if report.outcome == "done" else CANCELED if cancelled else ABORTED
                goal.reason = goal.reason or report.reason or report.outcome or ""
            changed = True
            for call in goal.waiting:
                self._answer(call, self._result(goal))
            goal.waiting.clear()
        if changed:
            self._changed()

    def end(self) -> None:
        """Withdraw the goal that is pursued."""
        goal = self._current()
        if goal is not None:
            goal.reason = "the program left the graph"
            self._withdraw(goal)
        self.look()

    def status(self) -> Any:
        """The status of all goals."""
        each = "action_msgs/msg/GoalStatus"
        made = [blank(each, goal_info=self._info(goal), status=np.int8(goal.status)) for goal in self._goals.values()]
        return blank(STATUS, status_list=made)

    def feedback(self, report: NavigationReport | None, X_MB: Pose2 | None) -> Any | None:
        """How the goal that is pursued gets on; None without one."""
        goal = self._current()
        if goal is None:
            return None
        now = self._now()
        made = blank(FEEDBACK)
        made.goal_id.uuid = np.frombuffer(goal.id, np.uint8)
        feedback = made.feedback
        feedback.navigation_time = _duration(now - goal.began)
        if X_MB is not None:
            feedback.current_pose = pose_stamped(X_MB, now)
        if report is not None and report.desire == goal.desire:
            feedback.number_of_recoveries = report.recoveries
            if report.remaining_m is not None:
                feedback.distance_remaining = report.remaining_m
        return made

    def _current(self) -> _Goal | None:
        return next((goal for goal in reversed(self._goals.values()) if not goal.is_over), None)

    def _withdraw(self, goal: _Goal) -> None:
        try:
            self._workspace.remove(goal.desire)
        except UnknownDesire:
            return  # it has ended meanwhile; `look` says how

    def _on_map(self, posed: Any) -> Pose2 | None:
        """The pose of a PoseStamped on the map, theta NaN for any; None, having said why, where it is none."""
        position, turn, frame = posed.pose.position, posed.pose.orientation, posed.header.frame_id.lstrip("/")
        numbers = (position.x, position.y, turn.x, turn.y, turn.z, turn.w)
        if not all(map(math.isfinite, numbers)):
            self._log.warning("a goal over ROS 2 was refused: its pose has numbers that are none")
            return None
        theta = math.nan
        if any(numbers[2:]):
            theta = math.atan2(2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y**2 + turn.z**2))
        pose = Pose2(position.x, position.y, theta)
        if frame in ("map", ""):
            return pose
        if frame == "odom" and self.X_MO is not None:
            return self.X_MO @ pose
        self._log.warning("a goal over ROS 2 was refused: its frame is %r; goals are in map, or odom on a map", frame)
        return None

    def _info(self, goal: _Goal) -> Any:
        info = blank("action_msgs/msg/GoalInfo", stamp=typestore.time(to_ns(goal.began)))
        info.goal_id.uuid = np.frombuffer(goal.id, np.uint8)
        return info

    def _result(self, goal: _Goal) -> Any:
        made = blank(f"{ACTION}_GetResult_Response", status=np.int8(goal.status))
        # Of Nav2's releases, one has nothing in it, one the code, one the reason, too.
        if goal.status == ABORTED and hasattr(made.result, "error_code"):
            made.result.error_code = UNKNOWN
        if hasattr(made.result, "error_msg") and goal.status != SUCCEEDED:
            made.result.error_msg = goal.reason
        return made


def pose_stamped(pose: Pose2, at: float) -> Any:
    """A PoseStamped on the map."""
    made = blank("geometry_msgs/msg/PoseStamped")
    made.header.stamp, made.header.frame_id = typestore.time(to_ns(at)), "map"
    made.pose.position.x, made.pose.position.y = pose.x, pose.y
    made.pose.orientation.z, made.pose.orientation.w = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)
    return made


def _duration(seconds: float) -> Any:
    whole = math.floor(seconds)
    return blank("builtin_interfaces/msg/Duration", sec=whole, nanosec=int((seconds - whole) * 1e9))

"""The action FollowJointTrajectory of a simulated robot that speaks ROS 2, served by rclpy's own server.

It takes one goal at a time, as Hello Robot's driver does: a newer one ends the one before, and while there is one no
other is taken within a fifth of a second. Of a trajectory, only the last point is gone to.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import IO, Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node

from app.logs.ros.live.blank import blank
from app.logs.ros.live.joint_trajectory_action import FOLLOW, follow_joint_trajectory
from app.messages import JointState

_BETWEEN_S = 0.2
_THERE = 0.01
_LONGEST_S = 10.0
_SUCCESSFUL, _INVALID_JOINTS, _NOT_THERE = 0, -2, -5

Command = Callable[[tuple[str, ...], tuple[float, ...]], None]


@dataclass(slots=True)
class _Goal:
    """A goal that is gone to: joints ``names`` at ``positions``, since ``began`` (monotonic, s)."""

    handle: Any
    names: tuple[str, ...]
    positions: tuple[float, ...]
    began: float


class JointAction:
    """The action ``name`` of a group with joints ``names`` in ``node``; ``command`` moves them. What happens to goals
    is noted in ``log``: ``MONOTONIC accepted|rejected|replaced|cancelled|succeeded|aborted``. Its server runs in
    rclpy's thread, :meth:`take` in any."""

    def __init__(self, node: Node, name: str, names: tuple[str, ...], command: Command, log: IO[str] | None) -> None:
        self._node, self._name, self._names = node, name, names
        self._command, self._log = command, log
        self._goal: _Goal | None = None
        self._asked = -_BETWEEN_S
        #: What becomes of goals: ``reject``, ``abort``, ``keep`` (they do not end by themselves), "" for what they ask.
        self.fault = ""
        self._server: Any = None
        self.serve(on=True)

    def serve(self, *, on: bool) -> None:
        """Serve, or leave the graph."""
        if self._server is not None:
            self._server.destroy()
        self._goal = self._server = None
        if on:
            self._server = ActionServer(
                self._node,
                follow_joint_trajectory(),
                self._name,
                execute_callback=lambda handle: blank(f"{FOLLOW}_Result"),
                goal_callback=self._ask,
                handle_accepted_callback=self._accepted,
                cancel_callback=self._cancel,
            )

    def take(self, joints: JointState) -> None:
        """Go on, by where the joints are."""
        goal = self._goal
        if goal is None:
            return
        if self.fault == "keep":
            self._command(goal.names, goal.positions)
            return
        at = dict(zip(joints.names, joints.positions, strict=True))
        if all(abs(at[name] - position) < _THERE for name, position in zip(goal.names, goal.positions, strict=True)):
            self._over(goal, "succeeded")
        elif time.monotonic() - goal.began > _LONGEST_S:
            self._over(goal, "aborted", _NOT_THERE)
        else:
            self._command(goal.names, goal.positions)

    def _ask(self, goal: Any) -> GoalResponse:
        now, before, self._asked = time.monotonic(), self._asked, time.monotonic()
        if self.fault == "reject" or (self._goal is not None and now - before < _BETWEEN_S):
            self._note("rejected")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _accepted(self, handle: Any) -> None:
        if self._goal is not None:
            self._over(self._goal, "replaced")
        trajectory = handle.request.trajectory
        names = tuple(trajectory.joint_names)
        goal = _Goal(handle, names, tuple(map(float, trajectory.points[-1].positions)), time.monotonic())
        self._note("accepted")
        if self.fault == "abort" or not set(names) <= set(self._names):
            self._over(goal, "aborted", _INVALID_JOINTS)
        else:
            self._goal = goal

    def _cancel(self, handle: Any) -> CancelResponse:
        if self._goal is None or self._goal.handle.goal_id != handle.goal_id:
            return CancelResponse.REJECT
        self._over(self._goal, "cancelled")
        return CancelResponse.ACCEPT

    def _over(self, goal: _Goal, how: str, error: int = _SUCCESSFUL) -> None:
        """End ``goal``, in rclpy's thread; its joints stay where they are."""
        if self._goal is goal:
            self._goal = None
        self._note(how)

        def end(handle: Any) -> Any:
            {"succeeded": handle.succeed, "cancelled": handle.canceled}.get(how, handle.abort)()
            return blank(f"{FOLLOW}_Result", error_code=error, error_string=how if error else "")

        self._node.executor.create_task(goal.handle.execute, end)

    def _note(self, what: str) -> None:
        if self._log is not None:
            self._log.write(f"{time.monotonic()} {what}\n")
            self._log.flush()

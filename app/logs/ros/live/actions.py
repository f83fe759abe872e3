"""Classes of actions for rclpy's own ``ActionClient`` and ``ActionServer``, of types that no installed package holds.

An action is three services and two topics (ROS 2's design of actions). Those of its own are made as
:mod:`app.logs.ros.live.classes` makes services; cancelling and the status of goals are ``action_msgs``, which every
ROS 2 has. Goals, results and feedback are rosbags' objects, as :func:`app.logs.ros.live.blank.blank` gives them.
"""

from __future__ import annotations

from ctypes import addressof, c_void_p
from functools import cache
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.type_support import check_for_type_support
from unique_identifier_msgs.msg import UUID

from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.logs.ros.live.classes import MadeMessage, maker, message_class, service_class
from app.logs.ros.live.kinds import description, type_hash
from app.logs.ros.live.structs import ActionSupport, Getter, capsule, pointer_in

_ID = "unique_identifier_msgs/UUID goal_id\n"
_PARTS = ("Goal", "Result", "Feedback")


class ActionPart(MadeMessage):
    """A message around goals whose fields rclpy reads and writes; its CDR is made of them."""

    __slots__ = ("fields",)

    def __init__(self, cdr: bytes = b"") -> None:
        self.fields: Any = typestore.deserialise(self.type_name, cdr) if cdr else blank(self.type_name)

    @property
    def cdr(self) -> bytes:  # type: ignore[override]  # what the base keeps, this one makes
        """Its CDR, with encapsulation."""
        return bytes(typestore.store().serialize_cdr(self.fields, self.type_name, little_endian=True))

    @property
    def goal_id(self) -> Any:
        """The goal's id, of rclpy's class."""
        return UUID(uuid=self.fields.goal_id.uuid)

    @goal_id.setter
    def goal_id(self, other: Any) -> None:
        self.fields.goal_id.uuid = np.array(other.uuid, np.uint8)

    @property
    def stamp(self) -> Any:
        """When the goal was accepted."""
        return self.fields.stamp

    @stamp.setter
    def stamp(self, other: Any) -> None:
        self.fields.stamp = typestore.make("builtin_interfaces/msg/Time", other.sec, other.nanosec)


def _plain(name: str) -> property:
    """A field as it is."""
    return property(
        lambda part: getattr(part.fields, name),
        lambda part, other: setattr(part.fields, name, other),
        doc=f"``{name}``",
    )


for _name in ("goal", "accepted", "status", "result", "feedback"):
    setattr(ActionPart, _name, _plain(_name))


def action_class(name: str, text: str) -> type[Any]:
    """The class for rclpy of the action ``name`` (``control_msgs/action/FollowJointTrajectory``), whose ``.action``
    file has ``text``; the same each time.

    The types that it uses must be in the store. Raises ValueError for a text without three parts, and
    app.logs.ros.live.classes.Unsupported.
    """
    return _action(name, text)


@cache
def _action(name: str, text: str) -> type[Any]:
    lines = "\n".join("---" if line.strip() == "---" else line for line in ("", *text.splitlines(), ""))
    parts = lines.split("\n---\n")
    if len(parts) != len(_PARTS):
        raise ValueError(f"{name}: an action has a goal, a result and a feedback, with --- between them")
    for part, definition in zip(_PARTS, parts, strict=True):
        typestore.add(f"{name}_{part}", definition.strip("\n") + "\n")
    typestore.add(f"{name}_FeedbackMessage", f"{_ID}{name}_Feedback feedback\n")
    send = service_class(
        f"{name}_SendGoal", f"{_ID}{name}_Goal goal\n", "bool accepted\nbuiltin_interfaces/Time stamp\n", ActionPart
    )
    get = service_class(f"{name}_GetResult", _ID, f"int8 status\n{name}_Result result\n", ActionPart)
    feedback = message_class(f"{name}_FeedbackMessage", ActionPart)
    typestore.add(
        name,
        "".join(f"{name}_{part} {part.lower()}\n" for part in _PARTS)
        + f"{name}_SendGoal send_goal_service\n{name}_GetResult get_result_service\n"
        + f"{name}_FeedbackMessage feedback_message\n",
    )
    hash_of, described = type_hash(name), description(name)
    pointers = [_support(each) for each in (send, get, CancelGoal, feedback, GoalStatusArray)]
    support = ActionSupport(
        *map(c_void_p, pointers),
        Getter(lambda _: addressof(hash_of)),
        Getter(lambda _: addressof(described)),
        maker().sources,
    )
    maker().keep(hash_of, described, support)
    impl = type(
        "Impl",
        (),
        {
            "SendGoalService": send,
            "GetResultService": get,
            "CancelGoalService": CancelGoal,
            "FeedbackMessage": feedback,
            "GoalStatusMessage": GoalStatusArray,
        },
    )
    types = {part: typestore.store().types[f"{name}_{part}"] for part in _PARTS}
    metaclass = type("MadeActionType", (type,), {"_TYPE_SUPPORT": capsule(addressof(support))})
    made: type[Any] = metaclass(name.rpartition("/")[2], (), types | {"Impl": impl})
    return made


def _support(kind: Any) -> int:
    check_for_type_support(kind)
    return pointer_in(kind.__class__._TYPE_SUPPORT)

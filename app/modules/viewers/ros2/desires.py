"""Services by which others in the graph add desires and remove them: functions of the Intention Workspace."""

from __future__ import annotations

import json
import math
from typing import Any

from app.attention.desires import InvalidDesire, Source, UnknownDesireClass
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.logs.ros.live.blank import blank
from app.modules.viewers.ros2.protocol import Service

SOURCE = Source("rest", "ROS 2")
#: Of all programs together, as over REST.
MOST_DESIRES = 1000
ADD = Service(
    "add_desire",
    "hbba_msgs/srv/AddDesire",
    # `class` is a word of C++; params is a JSON object, "" for none; ttl in s, 0 for ever.
    "string desire_class\nfloat64 intensity\nfloat64 utility\nbool security\nstring params\nfloat64 ttl\n",
    "bool success\nstring message\nstring id\n",
)
REMOVE = Service("remove_desire", "hbba_msgs/srv/RemoveDesire", "string id\n", "bool success\nstring message\n")


def add_desire(workspace: IntentionWorkspace, request: Any) -> Any:
    """The response to ``request`` (rosbags' objects), after which the desire is in ``workspace``, or the message says
    why it is not."""
    try:
        if sum(desire.source.kind == SOURCE.kind for desire in workspace.desires()) >= MOST_DESIRES:
            raise InvalidDesire("desire_class", f"there are {MOST_DESIRES} desires of programs, which is the most")
        desire = workspace.add(
            request.desire_class,
            intensity=request.intensity,
            utility=request.utility,
            security=bool(request.security),
            params=_parameters(request.params),
            source=SOURCE,
            ttl=None if request.ttl == 0.0 else request.ttl,
        )
    except (UnknownDesireClass, InvalidDesire) as refusal:
        return blank(f"{ADD.type}_Response", message=str(refusal))
    return blank(f"{ADD.type}_Response", success=True, id=desire.id)


def remove_desire(workspace: IntentionWorkspace, request: Any) -> Any:
    """The response to ``request``, after which the desire is not there."""
    try:
        workspace.remove(request.id)
    except UnknownDesire as refusal:
        return blank(f"{REMOVE.type}_Response", message=str(refusal))
    return blank(f"{REMOVE.type}_Response", success=True)


def _parameters(text: str) -> dict[str, Any] | None:
    """Raises InvalidDesire."""
    if not text.strip():
        return None
    try:
        read = json.loads(text, parse_constant=lambda _: math.nan)
    except (json.JSONDecodeError, RecursionError) as error:
        raise InvalidDesire("params", f"is no JSON: {error}") from None
    if not isinstance(read, dict):
        raise InvalidDesire("params", 'is a JSON object, as {"x": 1.5, "y": 0}')
    return read

from __future__ import annotations

from typing import Any

import pytest

from app.attention.desires import DesireClasses
from app.attention.workspace import IntentionWorkspace
from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.modules.behaviors.go_to import GO_TO
from app.modules.viewers.ros2.desires import ADD, MOST_DESIRES, REMOVE, SOURCE, add_desire, remove_desire

for service in (ADD, REMOVE):
    typestore.add(f"{service.type}_Request", service.request)
    typestore.add(f"{service.type}_Response", service.response)


def request(**fields: Any) -> Any:
    given = {"desire_class": "GoTo", "intensity": 3.0, "utility": 1.0, "params": '{"x": 1, "y": 2}'} | fields
    return blank(f"{ADD.type}_Request", **given)


def workspace() -> IntentionWorkspace:
    return IntentionWorkspace(DesireClasses([GO_TO]), lambda: 100.0)


def test_a_desire_comes_and_goes() -> None:
    desires = workspace()
    added = add_desire(desires, request(ttl=5.0, security=True))
    (desire,) = desires.desires()
    assert (added.success, added.id, added.message) == (True, desire.id, "")
    assert (desire.source, desire.expires, desire.security, desire.params["x"]) == (SOURCE, 105.0, True, 1.0)
    assert remove_desire(desires, blank(f"{REMOVE.type}_Request", id=desire.id)).success
    gone = remove_desire(desires, blank(f"{REMOVE.type}_Request", id=desire.id))
    assert (gone.success, desire.id in gone.message, desires.desires()) == (False, True, ())


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"desire_class": "GoToo"}, "GoTo"),
        ({"intensity": 0.0}, "intensity"),
        ({"intensity": float("nan")}, "intensity"),
        ({"utility": 9.0}, "utility"),
        ({"ttl": -1.0}, "ttl"),
        ({"params": '{"x": 1}'}, "y"),
        ({"params": "{"}, "params: is no JSON"),
        ({"params": "[1]"}, "params: is a JSON object"),
        ({"params": '{"x": NaN, "y": 1}'}, "x"),
        ({"params": "[" * 100_000}, "params: is no JSON"),
    ],
)
def test_what_is_wrong_is_said_and_nothing_is_added(fields: dict[str, Any], said: str) -> None:
    desires = workspace()
    refused = add_desire(desires, request(**fields))
    assert (refused.success, refused.id, desires.desires()) == (False, "", ())
    assert said in refused.message


def test_there_is_a_most() -> None:
    desires = workspace()
    with desires.transaction():
        for _ in range(MOST_DESIRES):
            assert add_desire(desires, request()).success
    assert str(MOST_DESIRES) in add_desire(desires, request()).message

"""Who drives, asks and speaks, as each page reads it, and why its own driving waits or is slower."""

from __future__ import annotations

import json
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest

from app.console.drive.command_age import CommandAge, Judgement
from app.console.drive.drive_lease import ANSWER_WITHIN_S, Lease
from app.console.live.messages import Status
from app.console.live.viewer import Viewer
from app.console.live.viewer_status import ViewerStatus

NOW = 50.0
STATUS: dict[str, Any] = dict.fromkeys(Status.__dataclass_fields__)


def viewer(session: str, judged: Judgement | None = None) -> Viewer:
    age = CommandAge(0.4)
    age.last = judged or Judgement()
    return Viewer(session, session.upper(), age)


@pytest.mark.parametrize("drivable", [True, False])
def test_every_viewer_reads_what_is_its_own_and_equal_frames_are_encoded_once(drivable: bool) -> None:
    operators = MappingProxyType({name: name.upper() for name in "abcde"})
    lease = Lease(operators, driver="a", moving=True, asker="b", asked_at=NOW - 2.0)
    driving: Any = SimpleNamespace(lease=lease, drivable=drivable)
    speech: Any = SimpleNamespace(speaker=("b", "B"))
    late = viewer("c", Judgement("Commands arrive up to 0.90 s late", 0.9, lasting=True))
    slow = viewer("d", Judgement(share=0.504, slowed="what you see is 0.80 s old"))
    others = [viewer("e"), viewer("f")]
    status = ViewerStatus(driving, speech, lambda: NOW)
    frames = dict(status.frames(Status(**STATUS), [viewer("a"), viewer("b"), late, slow, *others]))
    read = {each.session: json.loads(text) for each, text in frames.items()}

    assert [read[name]["driver"]["mine"] for name in "abcdef"] == [True, *[False] * 5]
    assert [read[name]["asker"]["mine"] for name in "abcdef"] == [False, True, *[False] * 4]
    assert [read[name]["speaker"]["mine"] for name in "abcdef"] == [False, True, *[False] * 4]
    assert read["a"]["asker"]["remaining_s"] == ANSWER_WITHIN_S - 2.0
    assert frames[others[0]] is frames[others[1]]
    # Where nobody can drive, nothing waits and nothing is slower.
    assert read["c"]["waits"] == ("Commands arrive up to 0.90 s late: driving waits." if drivable else "")
    assert read["d"]["slowed"] == ("What you see is 0.80 s old: 50 % of the speed." if drivable else "")
    assert [read[name]["share"] for name in "cde"] == [1.0, 0.5 if drivable else 1.0, 1.0]

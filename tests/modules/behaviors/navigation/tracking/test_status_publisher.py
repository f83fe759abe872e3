"""Published statuses of a path, and their log lines."""

from __future__ import annotations

import logging

import pytest

from app.messages import NavigationStatus
from app.modules.behaviors.navigation.tracking.status_publisher import StatusPublisher


def test_a_state_is_logged_on_entering_and_each_reason_once(caplog: pytest.LogCaptureFixture) -> None:
    published: list[NavigationStatus] = []
    publisher = StatusPublisher(published.append, logging.getLogger("hbba.Going"))
    said = [
        ("idle", ""),
        *[("waiting", why) for why in ("no scan", "no pose", "no scan", "no pose")],
        ("following", ""),
    ]
    with caplog.at_level(logging.INFO, "hbba"):
        for number, (state, reason) in enumerate([*said, ("waiting", "no scan")]):
            publisher.update(NavigationStatus(float(number), "Going", state, reason))
    assert [r.getMessage() for r in caplog.records] == [
        "waiting: no scan", "waiting: no pose", "following", "waiting: no scan",
    ]  # fmt: skip
    assert len(published) == 7

"""What is typed and pressed for the robot to say and do comes to it as desires."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Page, expect

from tests.browser.running import Robot

SENTENCE = "The typed sentence has come."


def test_a_typed_sentence_a_gesture_and_an_expression_are_desired(robot: Robot, page: Page) -> None:
    desired: list[dict[str, Any]] = []

    def added(control: str) -> dict[str, Any]:
        """What the robot desires by a press of ``control``: it has not ended before it is asked about."""
        with page.expect_response("**/api/v1/desires") as answer:
            page.get_by_test_id(control).click()
        assert answer.value.status == 201
        status, _, desire = robot.request("GET", f"/desires/{answer.value.json()['id']}")
        assert status == 200
        desired.append(desire)
        return desire

    page.get_by_test_id("say").click()
    page.get_by_test_id("say-text").fill(SENTENCE)
    said, waved, smiled = added("say-send"), added("act-wave"), added("act-happy")
    assert (said["class"], said["params"]["text"]) == ("Say", SENTENCE)
    assert waved["class"] == "Wave"
    assert (smiled["class"], smiled["params"]["expression"]) == ("Express", "happy")
    expect(page.get_by_test_id("say-text")).to_have_value("")
    for desire in desired:
        assert robot.request("DELETE", f"/desires/{desire['id']}")[0] in (204, 404)

"""Pages of a robot that asks for a login. The page on REST: requests tried in it are real ones, and nothing comes from
elsewhere. The face: a screen elsewhere logs in by its address."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Locator, Page, Request, expect

from app.console.access.token import VARIABLE
from tests.browser.running import Robot, running_robot
from tests.browser.shared_robot.test_face import until
from tests.patience import PATIENCE_MS

TOKEN = "a token of eight or more"


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """A robot that asks for the token."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, TOKEN)
        with running_robot(tmp_path_factory.mktemp("robot"), calm=True, light=True) as running:
            yield running


def tried(page: Page, operation: str, body: dict[str, Any] | None = None) -> tuple[int, Any]:
    """Status and decoded body that ``operation`` is answered with when it is tried out on the page."""
    block: Locator = page.locator(f"[id$={operation}]")
    block.locator(".opblock-summary-control").first.click()
    block.get_by_role("button", name="Try it out").click()
    if body is not None:
        block.locator("textarea.body-param__text").fill(json.dumps(body))
    block.get_by_role("button", name="Execute").click()
    answer = block.locator(".live-responses-table .response").first
    status = int(answer.locator(".response-col_status").inner_text().split()[0])
    return status, json.loads(answer.locator(".highlight-code pre").first.inner_text())


def test_requests_are_tried_out_on_the_page(browser: Browser, robot: Robot) -> None:
    errors: list[str] = []
    asked: set[str] = set()

    def hear(message: ConsoleMessage) -> None:
        # Without a login, the description is refused. All other errors are the page's, or its content policy's.
        if message.type == "error" and "401" not in message.text:
            errors.append(message.text)

    def note(request: Request) -> None:
        asked.add(request.url.split("/rest.html")[0].split("/assets/")[0])

    url = robot.url.partition("#")[0].rstrip("/")
    context = browser.new_context()
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.on("console", hear)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", note)
    page.goto(f"{url}/rest.html")
    expect(page.locator(".problem")).to_contain_text("log in on the console's page")

    page.goto(f"{url}/?scene=off")
    page.get_by_test_id("login-token").fill(TOKEN)
    page.get_by_test_id("login-submit").click()
    page.locator("[data-testid=connection][data-phase=live]").wait_for()

    page.goto(f"{url}/api/v1/docs")
    assert tried(page, "get_health")[0] == 200
    status, desire = tried(page, "create_desire", {"class": "LocateVoices", "intensity": 3, "utility": 2})
    assert (status, desire["class"], desire["intensity"]) == (201, "LocateVoices", 3)
    status, desires = tried(page, "list_desires")
    assert status == 200
    assert desire["id"] in {each["id"] for each in desires["desires"]}
    context.close()
    assert errors == []
    assert all(each.startswith((url, "data:", "blob:")) for each in asked), asked


def test_a_screen_elsewhere_logs_in_by_its_address(browser: Browser, robot: Robot) -> None:
    url = robot.url.partition("#")[0].rstrip("/")
    context = browser.new_context()
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.goto(f"{url}/face")
    page.locator("body[data-link=login]").wait_for()
    expect(page.get_by_text("Log in at the console")).to_be_visible()
    page.goto("about:blank")
    page.goto(f"{url}/face#token={TOKEN.replace(' ', '%20')}")
    page.locator("body[data-link=live]").wait_for()
    until(page, "eyelids_joint", 0.8, above=True)
    context.close()

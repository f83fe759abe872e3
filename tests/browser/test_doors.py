"""How people come in, in each browser: an operator by a password, a visitor by the key of a tour's run."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import pytest
import pytest_asyncio
from argon2 import PasswordHasher
from playwright.async_api import Browser, Page, expect

from app.console.access.passwords import hash_of
from app.console.access.roles import Role
from app.console.app import create_app
from app.console.fleet.asking import Fleet
from app.console.fleet.fleet_file import RobotConsole
from app.program.system import System
from tests.browser.browsers import BOTH, Browsers, named
from tests.console.places import FakeMapServer, grid
from tests.console.program import build, served
from tests.patience import PATIENCE_MS, PATIENCE_S
from tests.tours.tours import ARM, tour_data

CHEAP = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
PASSWORD = "correct horse"
TOKEN = "a token of eight or more"


# One event loop for the file, as for its browsers. Playwright's code, debugged, would take twice as long.
pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.slow]


@pytest_asyncio.fixture(loop_scope="module", params=BOTH)
async def browser(request: pytest.FixtureRequest, browsers: Browsers) -> Browser:
    """Each browser."""
    return await browsers.get(request.param)


@pytest_asyncio.fixture(loop_scope="module")
async def system(tmp_path: Path) -> AsyncIterator[System]:
    """A program whose body the test plays."""
    system, _ = build(tmp_path)
    async with system:
        yield system


@asynccontextmanager
async def opened(browser: Browser, address: str) -> AsyncIterator[Page]:
    """A page at ``address``; in the end no error may have come up in it."""
    context = await browser.new_context(viewport={"width": 1000, "height": 640})
    context.set_default_timeout(PATIENCE_MS)
    await context.add_init_script(named("Ann"))
    page = await context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    await page.goto(address)
    yield page
    await context.close()
    assert errors == []


async def test_a_wrong_password_is_refused_and_the_right_one_opens_the_page(browser: Browser, system: System) -> None:
    passwords = ((Role.OPERATOR, hash_of(PASSWORD, CHEAP)),)
    app = await asyncio.to_thread(create_app, system, passwords=passwords, early_view=False)
    async with served(app) as url, opened(browser, f"{url}/?scene=off") as page:
        await page.get_by_test_id("login-token").fill("wrong horse")
        await page.get_by_test_id("login-submit").click()
        await expect(page.get_by_test_id("login-problem")).not_to_be_empty()
        await page.get_by_test_id("login-token").fill(PASSWORD)
        await page.get_by_test_id("login-submit").click()
        await page.locator("[data-testid=connection][data-phase=live]").wait_for()
        await page.reload()  # which keeps who is in
        await page.locator("[data-testid=connection][data-phase=live]").wait_for()


async def test_a_visitor_s_phone_shows_the_tour_that_its_key_is_of(browser: Browser, system: System) -> None:
    server = FakeMapServer(system.maps)
    system.map.attach(server)
    await system.map.resume("", same=False)
    system.graph.channel("map").publish(grid(system.clock.now()))
    await system.map.server.save("lab")
    app = await asyncio.to_thread(create_app, system, token=TOKEN, early_view=False)
    async with (
        served(app) as url,
        httpx.AsyncClient(
            base_url=f"{url}/api/v1", headers={"Authorization": f"Bearer {TOKEN}"}, timeout=PATIENCE_S
        ) as operator,
    ):
        place = {"id": "robotics-lab", "name": "Lab", "pose": {"x": 0, "y": -1, "heading": 0}}
        assert (await operator.post("/places", json=place)).status_code == 201
        tour = tour_data(id="new-tour", stops=[ARM | {"do": []}])
        assert (await operator.post("/tours", json=tour)).status_code == 201
        assert (await operator.post("/tours/new-tour/run", json={"begin": "visitors"})).status_code == 200
        link = (await operator.get("/tour-run/visitors")).json()["url"]
        key = link.partition("#key=")[2]
        async with opened(browser, f"{url}/visitor#key={key}") as phone:
            await phone.locator("[data-testid=visitor][data-phase=live]").wait_for()
            await expect(phone.get_by_role("heading", level=1)).to_have_text(tour["title"]["en"])
            assert key not in phone.url
        async with opened(browser, f"{url}/visitor#key=a-guess") as stranger:
            await stranger.locator("[data-testid=visitor][data-phase=over]").wait_for()
            await expect(stranger.get_by_role("heading", level=1)).to_have_count(0)


async def test_the_list_of_robots_opens_the_page_of_another(browser: Browser, system: System, tmp_path: Path) -> None:
    """Two consoles, of which the second asks for a login that the first has; a third robot is not there."""
    (tmp_path / "other").mkdir()
    other, _ = await asyncio.to_thread(build, tmp_path / "other")
    there = await asyncio.to_thread(create_app, other, token=TOKEN, early_view=False)
    async with other, served(there) as other_url:
        fleet = Fleet((RobotConsole(other_url, TOKEN), RobotConsole("http://127.0.0.1:9")))
        app = await asyncio.to_thread(create_app, system, early_view=False, fleet=fleet)
        async with served(app) as url, opened(browser, f"{url}/?scene=off") as page:
            await page.get_by_test_id("fleet").click()
            robots = page.get_by_test_id("fleet-robot")
            await expect(robots).to_have_count(3)
            await expect(robots.nth(0)).to_contain_text("this page")
            await expect(robots.nth(1)).to_have_attribute("data-state", "problem")  # of the same name
            await expect(robots.nth(2)).to_have_attribute("data-state", "unreachable")
            async with page.expect_popup() as popup:
                await robots.nth(1).get_by_role("link").click()
            await (await popup.value).get_by_test_id("login-token").wait_for()
            await page.keyboard.press("Escape")
            await expect(page.get_by_test_id("fleet-box")).to_have_count(0)

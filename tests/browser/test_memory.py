"""The tab *Memory*: what happens, what is recognized and expected; delete and export. On a body without physics."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from app.console.app import create_app
from app.maps.library import MapLibrary
from app.memory.kept import Kept
from app.memory.memory import Limits, Memory
from app.memory.store import MemoryStore
from app.messages import Desire, EmotionLevel, EmotionState, PerceptEvent, ShownEmotion, Source
from app.program.config import load_configuration
from app.program.system import System
from tests.browser.checks import axe_script, violations
from tests.console.program import Body, served, write_program
from tests.patience import PATIENCE_S

MODULE = """\
  EpisodicMemory:
    class: app.modules.motivations.episodic_memory.episodic_memory:EpisodicMemory
    inputs: {events: percept_events}
    outputs: {memory: memory}
    settings: {enabled: true, raises: [Listen]}
"""
CHANNEL = "memory: {type: MemoryState, latched: true"
EXTERNAL = f"{CHANNEL}, external: true"


@dataclass
class Remembering:
    """The program, in a thread with a loop of its own."""

    url: str
    system: System
    loop: asyncio.AbstractEventLoop

    def someone_comes(self) -> None:
        """A face appears."""
        event = PerceptEvent(time.time(), "face.appears", "face", "1", "kinect", time.time(), 0.9, None, None)
        self.loop.call_soon_threadsafe(self.system.graph.channel("percept_events").publish, event)

    def shows_joy(self, desire: str) -> None:
        """Joy shows, by ``desire``."""
        joy = EmotionLevel("joy", 0.6, ())
        shown = ShownEmotion("joy", 0.5, desire)
        state = EmotionState(time.time(), (joy,), modulates=False, shows=True, shown=shown)
        self.loop.call_soon_threadsafe(self.system.graph.channel("emotions").publish, state)


def remember(folder: Path) -> None:
    """Someone came to the lab and asked how heavy the arm is, three times; someone else came once to the door."""
    memory = Memory(Kept(), Limits(10, 100, 1e12))
    listen = Desire("d-1", "Listen", 5, 1, False, {}, Source("rest", ""), 0.0)
    someone = {"person": {"someone": 1.0}}
    for ago_s in (200_000, 100_000, 7_200):
        memory.perceive(someone)
        memory.use({"Listen": listen})
        memory.perceive({**someone, "object": {"word how heavy": 1.0}})
        memory.perceive({**someone, "object": {"word how heavy": 1.0}, "desire": {"Say#3f2a91": 1.0}})
        memory.accomplish()
        memory.close(time.time() - ago_s)
    memory.perceive({"object": {"code door": 1.0}, "place": {"lab/door": 1.0}})
    memory.close(time.time() - 600)
    store = MemoryStore(folder)
    store.keep(memory.take_update())
    store.close()


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Remembering]:
    """A program that remembers, served on a free port."""
    file = write_program(tmp_path)
    file.write_text(file.read_text() + MODULE)
    channels = tmp_path / "channels.yaml"
    channels.write_text(channels.read_text().replace(EXTERNAL, CHANNEL))
    remember(tmp_path / "memory")
    store, maps = MemoryStore(tmp_path / "memory"), MapLibrary(tmp_path / "maps")
    system = System(load_configuration(file), link=Body(), maps=maps, memory=store)
    app = create_app(system, early_view=False)
    up, made, end = threading.Event(), [], asyncio.Event()

    async def serve() -> None:
        async with system, served(app) as url:
            made.append(Remembering(url, system, asyncio.get_running_loop()))
            up.set()
            await end.wait()

    thread = threading.Thread(target=asyncio.run, args=(serve(),))
    thread.start()
    try:
        assert up.wait(PATIENCE_S)
        yield made[0]
    finally:
        made[0].loop.call_soon_threadsafe(end.set)
        thread.join()


def test_what_is_recognized_and_expected_is_shown_and_episodes_are_deleted_and_exported(
    robot: Remembering, open_page: Callable[..., Page]
) -> None:
    page = open_page()
    page.get_by_test_id("tab-memory").click()
    card = page.get_by_test_id("memory")
    episodes = page.get_by_test_id("memory-episode")
    expect(episodes).to_have_count(2)
    expect(episodes.nth(0)).to_contain_text("code door, at door")
    expect(episodes.nth(1)).to_contain_text("someone, “how heavy”, Say")
    expect(episodes.nth(1)).to_contain_text("3 times, last 2 h ago, 3 events; helped by Listen")
    expect(page.get_by_test_id("memory-recognized")).to_have_text("Nothing happens.")

    robot.someone_comes()
    expect(page.get_by_test_id("memory-recognized")).to_contain_text("This is like episode 1 (")
    expect(page.get_by_test_id("memory-event")).to_have_text(["someone"])
    expect(page.get_by_test_id("memory-expected")).to_have_text(["expected “how heavy”", "expected Say"])
    expect(page.get_by_test_id("memory-raised")).to_have_text("So it desires Listen (2).")

    page.get_by_test_id("tab-attention").click()
    row = page.locator("[data-testid=desire-row][data-class=Listen]")
    expect(row.locator(".desire-by")).to_have_text("by Episodic memory, episode 1, for its task")
    robot.shows_joy(row.get_attribute("data-id") or "")
    expect(row.locator(".desire-by")).to_contain_text("for its task · shows joy")
    joy = page.locator("[data-testid=emotions] [data-emotion=joy]")
    expect(joy).to_have_attribute("aria-description", "No desire feeds it now.\nFace and voice show it.")
    page.get_by_test_id("tab-memory").click()

    with page.expect_download() as download:
        page.get_by_test_id("memory-export").click()
    exported = json.loads(Path(download.value.path()).read_text())
    assert [each["id"] for each in exported["episodes"]] == [2, 1]

    episodes.nth(1).get_by_test_id("memory-delete").click()
    expect(episodes).to_have_count(1)
    expect(page.get_by_test_id("memory-raised")).to_have_count(0)
    page.get_by_test_id("memory-delete-all").click()
    card.get_by_test_id("map-confirm").click()
    expect(card).to_contain_text("Nothing is remembered yet.")


def test_axe_finds_nothing_in_the_tab(robot: Remembering, open_page: Callable[..., Page]) -> None:
    axe = axe_script()
    page = open_page()
    page.get_by_test_id("tab-memory").click()
    robot.someone_comes()
    page.get_by_test_id("memory-raised").wait_for()
    page.get_by_test_id("memory-delete-all").click()
    for theme in ("light", "dark"):
        page.emulate_media(color_scheme=theme)
        page.locator(f"html[data-theme={theme}]").wait_for(state="attached")
        assert violations(page, axe) == [], theme

"""The Recorder on the live stream: for newcomers, at every change, and about once a second in between."""

from __future__ import annotations

import asyncio
from pathlib import Path

import httpx
import pytest

from app.console.recordings import RecorderWatch
from app.program.system import System
from tests.console.live_client import page
from tests.console.program import Body, build
from tests.console.scripted_recorder import ScriptedRecorder, heard
from tests.patience import PATIENCE_S


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program with a Recorder."""
    return build(tmp_path, recorder=True)


async def no_device(_: ScriptedRecorder) -> None:
    raise OSError("no such device")


async def test_a_new_page_gets_the_state_and_every_change(url: str, system: System, recorder: ScriptedRecorder) -> None:
    async with page(url) as ann, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        first = await ann.until("recorder")
        assert (first["state"], first["name"], first["desired"], first["available"]) == ("idle", "", False, True)
        await client.post("/recordings", json={"name": "tour"})
        await ann.until("recorder", lambda m: m["desired"])
        state = await ann.until("recorder", lambda m: m["state"] == "recording")
        assert (state["name"], state["duration_s"], state["bytes"], state["reason"]) == ("tour", 1.5, 1000, "")
        assert state["began"] <= state["stamp"]
        async with page(url, "Bob") as bob:
            assert (await bob.until("recorder"))["state"] == "recording"
        recorder.say("stopped", reason="the disk is full")
        state = await ann.until("recorder", lambda m: m["state"] == "stopped")
        assert (state["reason"], state["desired"], state["began"]) == ("the disk is full", True, None)
        await client.post("/recordings/stop")
        assert not (await ann.until("recorder", lambda m: m["state"] == "idle"))["desired"]


async def test_what_attention_refuses_has_its_reason(url: str) -> None:
    async with page(url) as ann, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        await client.patch("/resources/cpu", json={"capacity": 4})
        await client.post("/recordings", json={"intensity": 1})
        state = await ann.until("recorder", lambda m: m["reason"] != "")
        assert state["state"] == "idle"
        assert state["reason"].startswith("unfulfilled: ")
        await client.patch("/resources/cpu", json={"capacity": 100})
        await ann.until("recorder", lambda m: m["state"] == "recording" and m["reason"] == "")


async def test_a_failed_recorder_is_reported_and_its_return(url: str, recorder: ScriptedRecorder) -> None:
    async with page(url) as ann:
        await ann.until("recorder", lambda m: m["available"])
        # It fails at each start until that is seen: a slow page hears of the newest state alone.
        with pytest.MonkeyPatch.context() as broken:
            broken.setattr(ScriptedRecorder, "start", no_device)
            recorder.fail(OSError("no such device"))
            await ann.until("recorder", lambda m: not m["available"] and "no such device" in m["reason"])
        await ann.until("recorder", lambda m: m["available"] and m["reason"] == "")


async def test_numbers_alone_are_sent_once_a_second(
    system: System, recorder: ScriptedRecorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    await heard(system, "idle")
    report = RecorderWatch(system)
    now = system.clock.now()
    monkeypatch.setattr(system.clock, "now", lambda: now)
    assert report.news()
    recorder.say("idle", messages=1)
    assert not report.news()
    recorder.say("idle", messages=1, dropped=1)
    assert report.news()
    assert not report.news()
    now += 1
    assert report.news()


async def test_without_a_recorder_nothing_is_sent(tmp_path: Path) -> None:
    system, _ = await asyncio.to_thread(build, tmp_path)
    report = RecorderWatch(system)
    assert report.channel is None
    assert report.report() is None
    assert not report.news()
    assert not report.available

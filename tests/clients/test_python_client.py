"""The Python client against the real console."""

from __future__ import annotations

import asyncio
import json
import os
import re
import sys
from pathlib import Path

import cv2
import httpx
import numpy as np
import pytest
from hbba_client import AsyncRobot, Problem, Robot, Unreachable
from hbba_client.live import message_of
from hbba_client.records import LIVE, DesireChange, Desires, Hello, NewDesire, Status
from hbba_client.request import Request, live_url, problem_of

from app.program.system import System
from tests.patience import PATIENCE_S

EXAMPLES = re.findall(
    r"```python\n(.*?)```", (Path(__file__).parents[2] / "docs" / "clients.md").read_text("utf-8"), re.S
)


def console(url: str) -> str:
    """The address of the console that is served at ``url``."""
    return str(httpx.URL(url).copy_with(path="/"))


async def test_a_desire_lasts_as_long_as_its_block(url: str, system: System) -> None:
    async with AsyncRobot(console(url), operator="Ann") as robot:
        async with robot.desire("Listen", intensity=6, ttl=20) as held:
            (desire,) = (each for each in (await robot.list_desires()).desires if each.id == held.id)
            assert (desire.class_, desire.intensity) == ("Listen", 6)
            assert desire.expires is not None
        with pytest.raises(Problem) as refused:
            await robot.change_desire(held.id, DesireChange(intensity=1))
        assert (refused.value.status, refused.value.kind) == (404, "no-such-desire")


async def test_a_desire_outlives_its_time_while_it_is_held(
    url: str, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hbba_client.async_robot.RENEWALS", 1000)
    async with AsyncRobot(console(url)) as robot, robot.desire("Listen", ttl=60) as held:
        first = held.desire.expires
        assert first is not None
        async with asyncio.timeout(PATIENCE_S), robot.live() as messages:
            async for message in messages:
                if isinstance(message, Desires):
                    (desire,) = (each for each in message.desires if each.id == held.id)
                    if desire.expires is not None and desire.expires > first:
                        break


async def test_a_desire_that_somebody_removed_ends_quietly(url: str, system: System) -> None:
    async with AsyncRobot(console(url)) as robot, robot.desire("Listen") as held:
        await robot.remove_desire(held.id)
        report = await held.wait(timeout_s=60)
        assert report.outcome is not None


async def test_it_is_called_as_it_is_awaited(url: str, system: System) -> None:
    def called() -> list[str]:
        with Robot(console(url)) as robot, robot.desire("Listen", ttl=20) as held, robot.live() as messages:
            ids = [each.id for each in robot.list_desires().desires]
            assert held.id in ids
            assert isinstance(next(messages), Hello)
            next(message for message in messages if isinstance(message, Status))
            assert held.wait(timeout_s=0).outcome is None
        with Robot(console(url)) as robot:
            return [each.id for each in robot.list_desires().desires if each.id == held.id]

    assert await asyncio.to_thread(called) == []


async def test_every_answer_that_needs_no_argument_is_as_described(url: str, system: System) -> None:
    """Each record is decoded strictly from what the program really sends, or the refusal says why there is none."""
    async with AsyncRobot(console(url)) as robot:
        refused = {}
        for name in dir(robot):
            if name.startswith(("get_", "list_")):
                try:
                    await getattr(robot, name)()
                except TypeError:
                    continue  # of one thing
                except Problem as problem:
                    refused[name] = problem.status
        assert set(refused.values()) <= {401, 404, 409, 503}, refused
        assert not {"get_robot", "get_intention", "list_modules", "list_desire_classes", "list_tours"} & set(refused)


async def test_a_file_goes_there_and_back_as_it_is(url: str, system: System) -> None:
    async with AsyncRobot(console(url)) as robot:
        picture = cv2.imencode(".png", np.zeros((4, 6, 3), np.uint8))[1].tobytes()
        there = await robot.add_tour_media(picture, name="black.png", media="image/png")
        assert await robot.get_tour_media(there.file) == picture
        (tour, *_) = (await robot.list_tours()).tours
        archive = await robot.export_tour_archive(tour.id)
        await robot.get_tour(tour.id)
        again = await robot.import_tour(archive, media="application/zip", if_match=robot.etags[f"/tours/{tour.id}"])
        assert again.tour["id"] == tour.id


async def test_a_refusal_says_what_is_allowed(url: str, system: System) -> None:
    async with AsyncRobot(console(url)) as robot:
        with pytest.raises(Problem) as refused:
            await robot.create_desire(NewDesire(class_="Listen", intensity=9, utility=1))
        assert refused.value.status == 422
        assert [member for member, _ in refused.value.errors] == ["intensity"]
        assert "8" in str(refused.value.errors)


async def test_a_console_that_does_not_run_is_unreachable(url: str, unused_tcp_port: int) -> None:
    async with AsyncRobot(f"http://127.0.0.1:{unused_tcp_port}") as robot:
        with pytest.raises(Unreachable, match="does not answer"):
            await robot.get_health()
        with pytest.raises(Unreachable, match="does not answer"):
            async with robot.live():
                pass


@pytest.mark.parametrize("content", [b"", b"<html>Bad gateway</html>", b"[1]", b"\xff", b'{"errors": 3}'])
def test_a_refusal_of_something_between_is_named_by_its_status(content: bytes) -> None:
    problem = problem_of(502, content)
    assert (problem.status, problem.kind, problem.detail) == (502, "unknown", "the answer has status 502")


def test_addresses() -> None:
    assert live_url("https://robot:8443", "Ann B") == "wss://robot:8443/api/v1/live?operator=Ann%20B"
    assert Request.quoted("a/b c") == "a%2Fb%20c"
    with pytest.raises(ValueError, match="begins with http:// or https://"):
        Robot("robot:8080")


def test_what_a_newer_program_sends_beside_is_left_out() -> None:
    assert message_of(b"\x01picture") is None
    assert message_of(json.dumps({"type": "weather", "rain": True})) is None
    assert message_of(json.dumps({"type": "jump", "stamp": 1.5, "more": 2})) is not None
    assert "status" in LIVE


@pytest.mark.parametrize("ttl", [0.0, -1.0, float("nan")])
async def test_a_time_to_live_that_cannot_be_is_refused(ttl: float) -> None:
    async with AsyncRobot("http://127.0.0.1:9") as robot:
        with pytest.raises(ValueError, match="more than 0"):
            async with robot.desire("Listen", ttl=ttl):
                pass


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
async def test_the_examples_of_the_documentation_run(url: str, system: System, number: int) -> None:
    code = EXAMPLES[number]
    assert len(code.splitlines()) <= 20
    path = os.pathsep.join([str(Path(__file__).parents[2] / "clients" / "python")])
    environment = {**os.environ, "HBBA_ADDRESS": console(url), "PYTHONPATH": path, "PYTHONASYNCIODEBUG": ""}
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", code, env=environment, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
    )
    output, errors = await process.communicate()
    assert (process.returncode, errors.decode()) == (0, "")
    assert output.strip()

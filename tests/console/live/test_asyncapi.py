"""The AsyncAPI document of the live stream is true: what crosses the stream, both ways, is of its schemas."""

from __future__ import annotations

import json
import re
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import jsonschema
import msgspec
import pytest
from fastapi import FastAPI

from app.console.app import create_app
from app.console.live import protocol
from app.console.live.asyncapi import description
from app.program.system import System
from app.robots.actuator_config import circle
from app.runtime.module import Caution
from tests.console.answers import strict
from tests.console.live.whole_stream import heard, say_everything
from tests.console.live_client import page as connected
from tests.console.live_client import voice
from tests.console.program import Body, build, image, sound
from tests.logs.replay.logs import BEGIN, lab_log
from tests.logs.replay.playing import prepare
from tests.patience import PATIENCE_S

TEXT = (Path(__file__).parents[3] / "docs" / "live-stream.md").read_text("utf-8")
DOCUMENT = description("127.0.0.1:8080")
#: The messages that come on a recording alone.
RECORDED = {"playback", "jump"}


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program with everything that the stream reports, on a body with an outline."""
    system, body = build(tmp_path, recorder=True)
    body.description = replace(body.description, footprint=circle(0.28))
    system.cautions = (Caution("A title", "a sentence", "lab.yaml:1"),)
    return system, body


@pytest.fixture
def prepared() -> Any:
    """Three seconds of the lab, recorded."""
    return prepare(lab_log(3.0))


COMPONENTS = strict(DOCUMENT["components"])


def check(kind: str, frame: dict[str, Any]) -> None:
    """Raises ValidationError unless ``frame`` is as the message ``kind`` is described, member by member."""
    payload = COMPONENTS["messages"][kind]["payload"]
    jsonschema.Draft7Validator({**payload, "components": COMPONENTS}).validate(frame)


def messages(operation: str) -> set[str]:
    """The kinds of messages that go one way."""
    return {reference["$ref"].rpartition("/")[2] for reference in DOCUMENT["operations"][operation]["messages"]}


def in_words(heading: str) -> set[str]:
    """The types in the table of docs/live-stream.md below ``heading``."""
    section = TEXT.split(f"## {heading}\n")[1].split("\n## ")[0]
    named = re.findall(r"^\| (`\w+`(?:, `\w+`)*) \|", section, flags=re.MULTILINE)
    return {kind.strip("`") for kinds in named for kind in kinds.split(", ")}


def test_it_has_every_message_that_is_there_in_words() -> None:
    from_robot = in_words("From the robot to the page") | in_words("On a recording")
    assert in_words("On a recording") == RECORDED
    assert messages("send_to_page") == from_robot | {"picture", "sound"}
    assert messages("send_to_robot") == in_words("From the page to the robot") | {"voice"}
    assert messages("send_to_face") == in_words("The face")
    assert messages("send_to_visitor") == in_words("Visitors")


def test_references_lead_somewhere() -> None:
    def walk(value: Any) -> None:
        for each in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
            walk(each)
        if isinstance(value, dict) and isinstance(reference := value.get("$ref"), str):
            target: Any = DOCUMENT
            for part in reference.removeprefix("#/").split("/"):
                target = target[part]

    walk(DOCUMENT)


async def test_what_the_robot_sends_is_as_described(url: str, system: System, body: Body) -> None:
    say_everything(system, body)
    wanted = messages("send_to_page") - RECORDED - {"picture", "sound"}
    seen = await heard(url, system, wanted, lambda frame: check(frame["type"], frame))
    assert seen["perceived"]["faces"]
    assert seen["desires"]["desires"]
    assert seen["intention"]["strategies"]
    assert seen["load"]["modules"]
    robot = seen["hello"]["robot"]
    assert robot["footprint"] == [[round(x, 4), round(y, 4)] for x, y in circle(0.28)]
    assert robot["cautions"] == [{"title": "A title", "text": "a sentence", "where": "lab.yaml:1"}]


async def test_what_a_recording_sends_is_as_described(replay_url: str) -> None:
    async with (
        connected(replay_url) as ann,
        httpx.AsyncClient(base_url=f"{replay_url}/api/v1", timeout=PATIENCE_S) as rest,
    ):
        check("hello", await ann.until("hello"))
        assert (await rest.patch("/playback", json={"position": BEGIN + 1.0})).status_code == 200
        seen: set[str] = set()
        while not {*RECORDED, "lanes_history", "perceived", "status", "lanes"} <= seen:
            frame = await ann.receive()
            if isinstance(frame, dict):
                check(frame["type"], frame)
                seen.add(frame["type"])


@pytest.mark.parametrize("kind", sorted(messages("send_to_page") - {"picture", "sound"}))
def test_a_message_without_its_members_is_not_as_described(kind: str) -> None:
    """So that the checks above can fail."""
    with pytest.raises(jsonschema.ValidationError, match="is a required property"):
        check(kind, {"type": kind})


ASKED: dict[str, list[dict[str, Any]]] = {
    "drive": [
        {"seq": 1, "held": True, "linear": 0.5, "angular": -1},
        {"seq": 2, "held": False, "linear": 0, "angular": 0, "override": True},
        {"seq": 3, "held": False, "linear": 0, "angular": 0, "head_held": True, "pan": -1, "tilt": 0.5},
    ],
    "look": [{"stamp": 1.5, "u": 0.5, "v": 1}],
    "e_stop": [{}],
    "clear_e_stop": [{}],
    "take_control": [{}],
    "release_control": [{}],
    "ask_control": [{}],
    "answer_control": [{"give": True}, {"give": False}],
    "ping": [{"t": 1.5}, {"t": 1, "rtt_ms": None}, {"t": 1, "rtt_ms": 3.5}],
    "ack": [{"kind": 1, "seq": 7}, {"kind": 4, "seq": 0}],
    "view": [{}, {"camera": True, "map": None}],
    "listen": [{"on": True}],
}
REFUSED: dict[str, list[dict[str, Any]]] = {
    "drive": [
        {},
        {"seq": 1.5, "held": True, "linear": 0, "angular": 0},
        {"seq": 1, "held": 1, "linear": 0, "angular": 0},
    ],
    "ping": [{"t": "now"}, {"rtt_ms": "3"}],
    "ack": [{"kind": 5, "seq": 1}, {"kind": 1}],
    "view": [{"camera": 1}],
    "listen": [{}, {"on": None}],
    "answer_control": [{}, {"give": 1}],
}


@pytest.mark.parametrize("kind", sorted(messages("send_to_robot") - {"voice"}))
def test_what_a_page_says_is_as_described_if_it_is_understood(kind: str) -> None:
    for content in ASKED[kind]:
        message = {"type": kind, **content}
        check(kind, message)
        assert protocol.decode(json.dumps(message)).__struct_config__.tag == kind
    for content in REFUSED.get(kind, []):
        message = {"type": kind, **content}
        with pytest.raises(jsonschema.ValidationError):
            check(kind, message)
        with pytest.raises(msgspec.DecodeError):
            protocol.decode(json.dumps(message))


async def test_headers_of_binary_frames_are_as_described(url: str, body: Body, system: System) -> None:
    def header(kind: str, frame: bytes) -> dict[str, Any]:
        layout = DOCUMENT["components"]["messages"][kind]["x-header"]
        return dict(zip(layout["fields"], struct.unpack_from(layout["struct"], frame), strict=True))

    async with connected(url) as ann:
        await ann.send("listen", on=True)
        picture = sounding = None
        stamps = iter(range(1, 10_000))
        while picture is None or sounding is None:
            number = next(stamps)
            stamp = system.clock.now()
            body.emit("kinect", image(stamp))
            body.emit("microphones", sound(stamp, 512 * number))
            frame = await ann.receive()
            if isinstance(frame, bytes):
                picture, sounding = (frame, sounding) if frame[0] < 16 else (picture, frame)
    fields = header("picture", picture)
    assert (fields["kind"], fields["width"], fields["height"]) == (1, 64, 48)
    fields = header("sound", sounding)
    assert (fields["kind"], fields["channels"], fields["rate"]) == (16, 1, 48_000)
    assert len(sounding) == 24 + 2 * fields["samples"]
    fields = header("voice", voice(3, samples=160))
    assert (fields["kind"], fields["seq"], fields["samples"], fields["rate"]) == (17, 3, 160, 16_000)


async def test_it_is_served_with_the_address_it_was_asked_at(
    client: httpx.AsyncClient, system: System, page: Path
) -> None:
    document = (await client.get("/live.json")).json()
    assert document["asyncapi"] == "3.0.0"
    assert document["servers"] == {"console": {"host": "127.0.0.1:8080", "protocol": "ws"}}
    assert document["channels"]["live"]["address"] == "/api/v1/live"
    expected = description("127.0.0.1:8080", cookie="hbba_session_8080")
    assert document["components"] == json.loads(json.dumps(expected["components"]))
    locked: FastAPI = create_app(
        system, static_dir=page, early_view=False, token="a long token", host_names=("robot.local",)
    )
    transport = httpx.ASGITransport(locked)
    async with httpx.AsyncClient(transport=transport, base_url="https://robot.local/api/v1") as stranger:
        assert (await stranger.get("/live.json")).status_code == 401
        asked = await stranger.get("/live.json", headers={"Authorization": "Bearer a long token"})
    (server,) = asked.json()["servers"].values()
    assert (server["host"], server["protocol"], len(server["security"])) == ("robot.local", "wss", 2)

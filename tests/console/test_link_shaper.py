"""Every stream of the console through one bad link: in virtual time, and really served."""

from __future__ import annotations

import asyncio

import httpx
import pytest
from starlette.types import Message, Receive, Scope, Send

from app.base.network_link import LinkSettings, parse_link
from app.console.link_shaper import UNSENT_BYTES, Link, Shaped
from app.runtime.clock import run_virtual
from tests.console.live_client import page as connected
from tests.patience import PATIENCE_S

WEBSOCKET: Scope = {"type": "websocket"}


class Client:
    """The other end: what it sends, and when each message came, in s of the loop."""

    def __init__(self) -> None:
        self.sends: asyncio.Queue[Message] = asyncio.Queue()
        self.came: list[tuple[float, Message]] = []
        self.left = False
        self._news = asyncio.Event()

    async def take(self, message: Message) -> None:
        if self.left:
            raise OSError("the page has left")
        self.came.append((asyncio.get_running_loop().time(), message))
        self._news.set()

    async def until(self, count: int) -> None:
        """Wait until so many messages have come."""
        while len(self.came) < count:
            self._news.clear()
            await self._news.wait()


def text(content: str) -> Message:
    return {"type": "websocket.send", "text": content}


def test_both_ways_are_late_by_half_the_delay() -> None:
    async def echo(_: Scope, receive: Receive, send: Send) -> None:
        await send(text((await receive())["text"]))

    async def run() -> None:
        client, loop = Client(), asyncio.get_running_loop()
        client.sends.put_nowait({"type": "websocket.receive", "text": "hello"})
        began = loop.time()
        await Shaped(echo, Link(LinkSettings(0.3)))(WEBSOCKET, client.sends.get, client.take)
        [(came, message)] = client.came
        assert message == text("hello")
        assert came - began == pytest.approx(0.3, abs=1e-3)

    run_virtual(run())


def test_messages_keep_their_order_and_all_come() -> None:
    async def count(_: Scope, receive: Receive, send: Send) -> None:
        for number in range(200):
            await send(text(str(number)))
            await asyncio.sleep(0.01)

    async def run() -> None:
        client = Client()
        await Shaped(count, Link(parse_link("delay=300ms,jitter=300ms,loss=10%"), seed=1))(
            WEBSOCKET, client.sends.get, client.take
        )
        assert [message["text"] for _, message in client.came] == [str(number) for number in range(200)]

    run_virtual(run())


def test_a_sender_waits_at_the_rate() -> None:
    sent: list[float] = []

    async def flood(_: Scope, receive: Receive, send: Send) -> None:
        for _number in range(20):
            await send({"type": "websocket.send", "bytes": bytes(50_000)})
            sent.append(asyncio.get_running_loop().time())

    async def run() -> None:
        client, loop = Client(), asyncio.get_running_loop()
        began = loop.time()
        await Shaped(flood, Link(parse_link("rate=4Mbit")))(WEBSOCKET, client.sends.get, client.take)
        took = client.came[-1][0] - began
        # A million bytes and their packets' headers, at half a million bytes a second.
        assert took == pytest.approx(2.0, rel=0.05)
        # What was sent last waited in the socket alone.
        assert client.came[-1][0] - sent[-1] <= 8 * UNSENT_BYTES / 4e6 + 1e-3

    run_virtual(run())


def test_another_stream_has_its_turn_beside_a_large_message() -> None:
    link = Link(parse_link("rate=4Mbit"))

    async def large(_: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "websocket.send", "bytes": bytes(1_000_000)})

    async def small(_: Scope, receive: Receive, send: Send) -> None:
        await asyncio.sleep(0.5)
        await send(text("status"))

    async def run() -> None:
        first, second, loop = Client(), Client(), asyncio.get_running_loop()
        began = loop.time()
        await asyncio.gather(
            Shaped(large, link)(WEBSOCKET, first.sends.get, first.take),
            Shaped(small, link)(WEBSOCKET, second.sends.get, second.take),
        )
        assert first.came[0][0] - began == pytest.approx(2.0, rel=0.1)
        assert second.came[0][0] - began < 0.75

    run_virtual(run())


def test_a_link_that_shapes_nothing_passes_messages_as_they_are() -> None:
    async def app(_: Scope, receive: Receive, send: Send) -> None:
        await send(text("now"))
        assert len(client.came) == 1

    client = Client()

    async def run() -> None:
        await Shaped(app, Link())(WEBSOCKET, client.sends.get, client.take)

    run_virtual(run())


def test_the_link_changes_while_a_connection_stands() -> None:
    link = Link()
    delays: list[float] = []

    async def app(_: Scope, receive: Receive, send: Send) -> None:
        for settings in (LinkSettings(0.2), LinkSettings(1.0), LinkSettings()):
            link.change(settings)
            before, began = len(client.came), asyncio.get_running_loop().time()
            await send(text("x"))
            await client.until(before + 1)
            delays.append(client.came[-1][0] - began)

    client = Client()
    run_virtual(Shaped(app, link)(WEBSOCKET, client.sends.get, client.take))
    assert delays == pytest.approx([0.1, 0.5, 0.0], abs=2e-3)


def test_the_end_of_a_page_comes_to_both() -> None:
    ended: list[str] = []

    async def app(_: Scope, receive: Receive, send: Send) -> None:
        ended.append((await receive())["type"])
        await send(text("still there?"))
        await asyncio.sleep(0.2)
        with pytest.raises(OSError, match="has left"):
            await send(text("still there?"))

    async def run() -> None:
        client = Client()
        client.left = True
        client.sends.put_nowait({"type": "websocket.disconnect", "code": 1006})
        await Shaped(app, Link(LinkSettings(0.2)))(WEBSOCKET, client.sends.get, client.take)

    run_virtual(run())
    assert ended == ["websocket.disconnect"]


async def test_a_page_knows_how_its_link_is_shaped(url: str) -> None:
    async with connected(url) as page, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        assert (await page.until("link"))["shaped"] is False
        answer = await client.put("/link", json={"delay_ms": 40, "jitter_ms": 10, "rate_mbit": 4})
        assert answer.status_code == 200
        assert answer.json()["text"] == "40 ± 10 ms round trip, 4 Mbit/s"
        assert (await page.until("link"))["delay_ms"] == 40
        await page.send("ping")
        await page.until("pong")
        assert (await client.get("/link")).json()["shaped"] is True
        assert (await client.put("/link", json={})).json()["shaped"] is False
        assert (await page.until("link"))["text"] == ""


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"delay_ms": 10, "jitter_ms": 20}, "jitter goes from 0 to the delay"),
        ({"loss_percent": 80}, "loss_percent"),
        ({"lag": 3}, "lag"),
    ],
)
async def test_a_link_that_cannot_be_is_refused(client: httpx.AsyncClient, change: dict[str, float], said: str) -> None:
    answer = await client.put("/link", json=change)
    assert answer.status_code == 422
    assert said in answer.text

"""What is remembered, over REST: exported, deleted; and every refusal."""

from __future__ import annotations

import httpx

from app.memory.service import MemoryRefused, UnknownEpisode
from app.messages import EpisodeDeed, EpisodeEvent, EpisodeReport, MemoryEvent, MemoryItem, MemoryReport
from app.program.system import System
from tests.console.answers import answered, is_problem

REPORT = MemoryReport(
    100.0,
    (
        EpisodeReport(
            3,
            times=2,
            first=10.0,
            last=90.0,
            learning_rate=0.6,
            vigilance=0.85,
            events=(EpisodeEvent(7, 1.0),),
            deeds=(EpisodeDeed("ListenForWords", {"words": "who"}, 1.0),),
        ),
    ),
    (MemoryEvent(7, (MemoryItem("person", "someone", 1.0),)),),
)


class Remembering:
    """A MemoryServer with one episode, 3, on a disk that may refuse."""

    def __init__(self) -> None:
        self.forgotten: list[int | str] = []
        self.refuses = False

    async def report(self) -> MemoryReport:
        return REPORT

    async def forget(self, episode: int) -> None:
        if episode != 3:
            raise UnknownEpisode(f"no episode has the number {episode}: it may have been forgotten")
        self._forget(episode)

    async def forget_all(self) -> None:
        self._forget("all")

    def _forget(self, what: int | str) -> None:
        if self.refuses:
            raise MemoryRefused("it is forgotten, and still in the file: the disk is full")
        self.forgotten.append(what)


async def test_it_is_exported_and_deleted(client: httpx.AsyncClient, system: System) -> None:
    server = Remembering()
    system.memory.attach(server)
    assert answered(await client.get("/memory"), MemoryReport) == REPORT
    assert (await client.delete("/memory/episodes/3")).status_code == 204
    assert (await client.delete("/memory")).status_code == 204
    assert server.forgotten == [3, "all"]


async def test_every_refusal(client: httpx.AsyncClient, system: System) -> None:
    for method, path in (("GET", "/memory"), ("DELETE", "/memory"), ("DELETE", "/memory/episodes/3")):
        off = is_problem(await client.request(method, path), 409, "memory-off")
        assert off["detail"] == "This program remembers nothing: no EpisodicMemory is enabled."
    server = Remembering()
    system.memory.attach(server)
    gone = is_problem(await client.delete("/memory/episodes/9"), 404, "no-such-episode")
    assert gone["detail"] == "No episode has the number 9: it may have been forgotten."
    for wrong in ("x", "0", "1.5"):
        is_problem(await client.delete(f"/memory/episodes/{wrong}"), 422, "invalid-request")
    server.refuses = True
    for path in ("/memory", "/memory/episodes/3"):
        full = is_problem(await client.delete(path), 409, "disk-refuses")
        assert full["detail"] == "It is forgotten, and still in the file: the disk is full."

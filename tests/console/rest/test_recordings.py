"""Recordings over REST: made by desires, listed, downloaded whole and in part, deleted; no name leads elsewhere."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from fastapi import FastAPI

from app.attention.desires import Desire, Source
from app.console.records.recordings import RecordingList
from app.program.system import System
from tests.console.answers import answered, is_problem
from tests.console.program import Body, build
from tests.console.scripted_recorder import LENGTH_S, ScriptedRecorder, heard, write_log
from tests.patience import PATIENCE_S

BEGIN = 1_795_000_000.25


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program with a Recorder."""
    return build(tmp_path, recorder=True)


@pytest.fixture
def tour(built: tuple[System, Body]) -> bytes:
    """A recording called ``tour`` lies in the folder."""
    path = built[0].recordings.path("tour")
    write_log(path, BEGIN)
    return path.read_bytes()


async def listed(client: httpx.AsyncClient) -> dict[str, Any]:
    """The list, in its declared shape."""
    response = await client.get("/recordings")
    assert response.status_code == 200
    answered(response, RecordingList)
    found: dict[str, Any] = response.json()
    return found


async def test_recordings_are_listed_with_size_and_length(
    client: httpx.AsyncClient, system: System, tour: bytes
) -> None:
    write_log(system.recordings.path("killed"), BEGIN + 60, closed=False)
    found = await listed(client)
    assert found["folder"] == str(system.recordings.folder)
    assert found["free_bytes"] > 0
    assert found["recordings"] == [
        {
            "name": "killed",
            "bytes": system.recordings.path("killed").stat().st_size,
            "duration_s": None,
            "began": BEGIN + 60,
            "state": "unfinished",
            "robot": "a test body",
        },
        {
            "name": "tour",
            "bytes": len(tour),
            "duration_s": LENGTH_S,
            "began": BEGIN,
            "state": "complete",
            "robot": "a test body",
        },
    ]


async def test_before_the_first_recording_the_list_is_empty(client: httpx.AsyncClient) -> None:
    found = await listed(client)
    assert found["recordings"] == []
    assert found["replay"] is None
    assert found["recorder"]["state"] == "idle"
    assert found["recorder"]["available"]


async def test_a_recording_from_start_to_deletion(client: httpx.AsyncClient, system: System) -> None:
    created = await client.post("/recordings", json={"name": "tour"}, headers={"X-HBBA-Operator": "Ann"})
    assert created.status_code == 201
    desire = answered(created, Desire)
    assert created.headers["location"] == f"/api/v1/desires/{desire.id}"
    assert (desire.cls, desire.intensity, desire.utility) == ("Record", 8, 1)
    assert desire.params == {"name": "tour", "keep_minutes": 0}
    assert (desire.source.kind, desire.source.name) == ("operator", "Ann")
    await heard(system, "recording")

    found = await listed(client)
    assert found["recorder"]["state"] == "recording"
    assert found["recorder"]["name"] == "tour"
    assert found["recorder"]["desired"]
    assert found["recordings"][0]["state"] == "recording"
    assert found["recordings"][0]["duration_s"] == found["recorder"]["duration_s"] == 1.5
    for refused in (
        await client.get("/recordings/tour"),
        await client.delete("/recordings/tour"),
        await client.post("/recordings/tour/replay"),
    ):
        assert "stop first" in is_problem(refused, 409, "recording-in-progress")["detail"]
    is_problem(await client.post("/recordings", json={"name": "tour"}), 409, "recording-exists")

    stopped = await client.post("/recordings/stop")
    assert stopped.json() == {"withdrawn": [desire.id], "remaining": []}
    await heard(system, "idle")
    found = await listed(client)
    assert found["recorder"]["state"] == "idle"
    assert found["recorder"]["began"] is None
    assert found["recordings"][0]["state"] == "complete"
    assert found["recordings"][0]["duration_s"] == LENGTH_S
    assert (await client.get("/recordings/tour")).status_code == 200
    assert (await client.delete("/recordings/tour")).status_code == 204
    assert (await listed(client))["recordings"] == []
    is_problem(await client.delete("/recordings/tour"), 404, "no-such-recording")


async def test_recording_needs_nothing_said(client: httpx.AsyncClient) -> None:
    created = await client.post("/recordings")
    assert created.status_code == 201
    assert created.json()["params"] == {"name": "", "keep_minutes": 0}
    assert created.json()["source"] == {
        "kind": "rest", "name": "rest", "rule": "", "event": "", "applied": None, "motive": None,
    }  # fmt: skip


async def test_the_same_key_records_once(client: httpx.AsyncClient) -> None:
    key = {"Idempotency-Key": "k1"}
    first = await client.post("/recordings", json={"name": "tour"}, headers=key)
    again = await client.post("/recordings", json={"name": "tour"}, headers=key)
    assert again.json() == first.json()
    assert again.headers["idempotency-replayed"] == "true"
    assert len((await client.get("/desires")).json()["desires"]) == 1
    other = await client.post("/recordings", json={"name": "other"}, headers=key)
    is_problem(other, 422, "idempotency-key-reused")


async def test_stopping_leaves_what_the_robot_itself_desires(client: httpx.AsyncClient, system: System) -> None:
    own = system.workspace.add("Record", intensity=2, utility=1, source=Source("motivation", "Diary"))
    asked = [
        (await client.post(path, json=body)).json()["id"]
        for path, body in (("/recordings", {}), ("/desires", {"class": "Record", "intensity": 8, "utility": 1}))
    ]
    stopped = (await client.post("/recordings/stop")).json()
    assert stopped["withdrawn"] == asked
    assert [desire["id"] for desire in stopped["remaining"]] == [own.id]
    assert (await client.post("/recordings/stop")).json()["withdrawn"] == []


async def test_what_attention_cannot_afford_is_said_in_words(client: httpx.AsyncClient, system: System) -> None:
    await client.patch("/resources/cpu", json={"capacity": 4})
    await client.post("/recordings", json={"name": "tour"})
    await system.translator.settled()
    recorder = (await listed(client))["recorder"]
    assert recorder["state"] == "idle"
    assert recorder["desired"]
    assert recorder["reason"].startswith("unfulfilled: ")
    assert "more cpu" in recorder["reason"]
    await client.patch("/resources/cpu", json={"capacity": 100})
    await heard(system, "recording")
    recorder = (await listed(client))["recorder"]
    assert (recorder["state"], recorder["reason"]) == ("recording", "")


async def test_one_recording_does_not_end_another(
    client: httpx.AsyncClient, system: System, recorder: ScriptedRecorder
) -> None:
    await client.post("/recordings", json={"name": "tour"})
    # Whether it has started or not.
    for _ in range(2):
        for body in ({}, {"name": "over"}, {"keep_minutes": 1}):
            refused = is_problem(await client.post("/recordings", json=body), 409, "recording-in-progress")
            assert "(tour) is in progress" in refused["detail"]
            assert "stop it first" in refused["detail"]
        await heard(system, "recording")
    recorder.say("stopped", reason="the disk is full")
    assert (await client.post("/recordings", json={"name": "again"})).status_code == 201


async def test_a_recording_takes_the_place_of_a_ring_and_of_what_the_robot_itself_records(
    client: httpx.AsyncClient, system: System
) -> None:
    system.workspace.add("Record", intensity=2, utility=1, source=Source("motivation", "Diary"))
    await heard(system, "recording")
    assert (await client.post("/recordings", json={"keep_minutes": 5})).status_code == 201
    await heard(system, "ring")
    assert (await client.post("/recordings", json={"keep_minutes": 2})).status_code == 201
    assert (await client.post("/recordings", json={"name": "tour"})).status_code == 201
    await heard(system, "recording")


async def test_why_it_stopped_by_itself_is_said(client: httpx.AsyncClient, recorder: ScriptedRecorder) -> None:
    recorder.say("stopped", reason="the disk is full", dropped=3)
    report = (await listed(client))["recorder"]
    assert (report["state"], report["reason"], report["dropped"]) == ("stopped", "the disk is full", 3)


async def test_a_ring_is_saved(client: httpx.AsyncClient, system: System, recorder: ScriptedRecorder) -> None:
    refused = is_problem(await client.post("/recordings/save"), 409, "no-ring")
    assert "keep_minutes" in refused["detail"]
    await client.post("/recordings", json={"keep_minutes": 5})
    await heard(system, "ring")
    report = (await listed(client))["recorder"]
    assert (report["state"], report["keep_minutes"]) == ("ring", 5)
    saved = await client.post("/recordings/save", json={"minutes": 1, "name": "bump"})
    assert saved.status_code == 201
    assert saved.json() == {"name": "bump"}
    assert saved.headers["location"] == "/api/v1/recordings/bump"
    found = await listed(client)
    assert [(r["name"], r["duration_s"], r["state"]) for r in found["recordings"]] == [("bump", 60, "complete")]
    is_problem(await client.post("/recordings/save", json={"name": "bump"}), 409, "recording-exists")
    assert (await client.post("/recordings/save")).json() == {"name": "saved"}
    recorder.disk_full = True
    assert "disk is full" in is_problem(await client.post("/recordings/save"), 507, "recording-not-saved")["detail"]


async def test_a_recorder_that_does_not_run_is_missed(
    client: httpx.AsyncClient, system: System, recorder: ScriptedRecorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def broken(_: ScriptedRecorder) -> None:
        raise OSError("no such device")

    monkeypatch.setattr(ScriptedRecorder, "start", broken)  # every restart fails too
    failed = asyncio.Event()
    system.supervisor.observe(lambda state: failed.set() if state.status == "failed" else None)
    recorder.fail(OSError("no such device"))
    await asyncio.wait_for(failed.wait(), PATIENCE_S)
    refused = is_problem(await client.post("/recordings"), 409, "recorder-missing")
    assert "no such device" in refused["detail"]
    report = (await listed(client))["recorder"]
    assert not report["available"]
    assert "no such device" in report["reason"]
    is_problem(await client.post("/recordings/save"), 409, "recorder-missing")


@pytest.mark.parametrize(
    ("path", "body", "field"),
    [
        ("/recordings", {"name": "../etc"}, "name"),
        ("/recordings", {"name": "tour\n"}, "name"),
        ("/recordings", {"name": "ｔour"}, "name"),
        ("/recordings", {"name": "x" * 101}, "name"),
        ("/recordings", {"keep_minutes": -1}, "keep_minutes"),
        ("/recordings", {"keep_minutes": 121}, "keep_minutes"),
        ("/recordings", {"intensity": 9}, "intensity"),
        ("/recordings", {"minutes": 1}, "minutes"),
        ("/recordings/save", {"minutes": 0}, "minutes"),
        ("/recordings/save", {"name": "a/b"}, "name"),
    ],
)
async def test_what_is_not_allowed_is_named(client: httpx.AsyncClient, path: str, body: Any, field: str) -> None:
    (error,) = is_problem(await client.post(path, json=body), 422, "invalid-request")["errors"]
    assert error["field"] == field
    assert field != "name" or error["message"].startswith("a recording's name has 1 to 100 letters")
    assert (await client.get("/desires")).json()["desires"] == []


async def test_a_disk_that_refuses_is_reported(client: httpx.AsyncClient, system: System) -> None:
    await asyncio.to_thread(system.recordings.folder.write_text, "no folder")
    refused = is_problem(await client.get("/recordings"), 409, "disk-refuses")
    assert str(system.recordings.folder) in refused["detail"]
    assert "Not a directory" in refused["detail"]


# --- Downloading ---------------------------------------------------------------------------------------------------


async def test_a_recording_is_downloaded_as_it_is(client: httpx.AsyncClient, tour: bytes) -> None:
    response = await client.get("/recordings/tour")
    assert response.status_code == 200
    assert response.content == tour
    assert response.headers["content-length"] == str(len(tour))
    assert response.headers["content-type"] == "application/vnd.mcap"
    assert response.headers["content-disposition"] == 'attachment; filename="tour.mcap"'
    assert response.headers["accept-ranges"] == "bytes"
    assert response.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize(
    ("asked", "begin", "end"), [("bytes=8-99", 8, 100), ("bytes=100-", 100, None), ("bytes=-8", -8, None)]
)
async def test_a_part_of_it_is_downloaded(
    client: httpx.AsyncClient, tour: bytes, asked: str, begin: int, end: int | None
) -> None:
    response = await client.get("/recordings/tour", headers={"Range": asked})
    assert response.status_code == 206
    assert response.content == tour[begin:end]
    assert response.headers["content-range"].endswith(f"/{len(tour)}")


async def test_a_download_goes_on_where_it_broke_off(client: httpx.AsyncClient, tour: bytes) -> None:
    first = await client.get("/recordings/tour", headers={"Range": "bytes=0-499"})
    rest = await client.get("/recordings/tour", headers={"Range": "bytes=500-", "If-Range": first.headers["etag"]})
    assert first.content + rest.content == tour
    changed = await client.get("/recordings/tour", headers={"Range": "bytes=500-", "If-Range": '"another"'})
    assert (changed.status_code, changed.content) == (200, tour)


@pytest.mark.parametrize(
    "asked",
    ["bytes=1000000-", "bytes=9-8", "bytes=-", "pages=1-2", "bytes=a-b", "bytes=0-1,99999999-", f"bytes={'9' * 5000}-"],
)
async def test_a_part_that_is_not_there_is_refused_in_words(client: httpx.AsyncClient, tour: bytes, asked: str) -> None:
    response = await client.get("/recordings/tour", headers={"Range": asked})
    is_problem(response, 416, "range-not-satisfiable")
    assert response.headers["content-range"] == f"bytes */{len(tour)}"


async def test_a_large_recording_is_sent_piece_by_piece(url: str, system: System) -> None:
    path = system.recordings.path("large")
    size = 256 * 1024 * 1024

    def sparse() -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            file.truncate(size)

    await asyncio.to_thread(sparse)
    got = 0
    before = peak_kib()
    async with (
        httpx.AsyncClient(timeout=PATIENCE_S) as client,
        client.stream("GET", f"{url}/api/v1/recordings/large") as response,
    ):
        assert response.headers["content-length"] == str(size)
        async for piece in response.aiter_raw():
            got += len(piece)
            if got > size // 4:
                break  # a client that leaves in the middle breaks nothing
    assert peak_kib() - before < 64 * 1024
    async with httpx.AsyncClient(timeout=PATIENCE_S) as client:
        assert (await client.get(f"{url}/api/v1/health")).json()["status"] in ("ok", "degraded")


def peak_kib() -> int:
    """The most memory this process has had (KiB)."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


# --- Names ---------------------------------------------------------------------------------------------------------


METHODS = (("GET", ""), ("DELETE", ""), ("POST", "/replay"))
NAMES = [
    "%2e%2e%2fsecret",
    "..%2fsecret",
    "..%5csecret",
    "%2e%2e",
    "..",
    "%252e%252e%252fsecret",
    "%c0%ae%c0%ae%c0%afsecret",
    "%ef%bc%8e%ef%bc%8e%ef%bc%8fsecret",
    "secret%00",
    "secret%0a",
    "%2fetc%2fpasswd",
    "//etc/passwd",
    "file:%2f%2f%2fetc%2fpasswd",
    ".secret",
    "%20secret",
    "se%0dcret",
    "t%C3%B6ur",
]


async def test_no_name_leads_out_of_the_folder(url: str, system: System) -> None:
    secret = system.recordings.folder.parent / "secret.mcap"

    def hide() -> None:
        system.recordings.folder.mkdir(parents=True, exist_ok=True)
        secret.write_bytes(b"secret")
        (system.recordings.folder / ".secret.mcap").write_bytes(b"secret")

    await asyncio.to_thread(hide)
    host, _, port = url.removeprefix("http://").partition(":")
    requests = [(f"{method} ", f"{name}{rest}") for name in NAMES for method, rest in METHODS]
    for method, rest in requests:
        # By hand: a client of good manners would tidy the path up.
        reader, writer = await asyncio.open_connection(host, int(port))
        head = (
            f"{method}/api/v1/recordings/{rest} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\nConnection: close"
        )
        writer.write(f"{head}\r\n\r\n".encode())
        answer = await asyncio.wait_for(reader.read(), PATIENCE_S)
        writer.close()
        await writer.wait_closed()
        assert int(answer.split()[1]) in (400, 404, 405, 422), answer
        assert b"secret.mcap" not in answer
        assert b"root:" not in answer
    assert await asyncio.to_thread(secret.read_bytes) == b"secret"


async def test_a_bad_name_is_refused_in_words(client: httpx.AsyncClient) -> None:
    refused = is_problem(await client.get("/recordings/.hidden"), 422, "invalid-name")
    assert "begins with a letter or a digit" in refused["detail"]
    is_problem(await client.delete("/recordings/.hidden/replay"), 422, "invalid-name")
    is_problem(await client.get("/recordings/gone"), 404, "no-such-recording")
    is_problem(await client.post("/recordings/gone/replay"), 404, "no-such-recording")
    is_problem(await client.delete("/recordings/gone/replay"), 404, "no-such-replay")


# --- Replaying -----------------------------------------------------------------------------------------------------


async def test_a_replay_is_reached_as_this_console_is(client: httpx.AsyncClient, app: FastAPI, tour: bytes) -> None:
    replays = app.state.replays
    replays.command = ("sh", "-c", "echo 'HBBA is up: http://127.0.0.1:4711/#token=secret  (...)'; exec sleep 60")
    started = await client.post("/recordings/tour/replay", headers={"Host": "localhost:8080"})
    assert started.status_code == 201
    assert started.json() == {"name": "tour", "url": "http://localhost:4711/#token=secret"}
    assert (await listed(client))["replay"] == {"name": "tour", "url": "http://127.0.0.1:4711/#token=secret"}
    refused = is_problem(await client.delete("/recordings/tour"), 409, "recording-replayed")
    assert "DELETE /api/v1/recordings/tour/replay" in refused["detail"]
    assert (await client.delete("/recordings/tour/replay")).status_code == 204
    assert (await listed(client))["replay"] is None
    is_problem(await client.delete("/recordings/tour/replay"), 404, "no-such-replay")
    assert (await client.delete("/recordings/tour")).status_code == 204


async def test_a_replay_ends_with_its_console(app: FastAPI, tour: bytes) -> None:
    app.state.replays.command = ("sh", "-c", 'echo "HBBA is up: http://127.0.0.1:4711/#$$ "; exec sleep 60')
    async with app.router.lifespan_context(app):
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:8080/api/v1") as client:
            url = (await client.post("/recordings/tour/replay")).json()["url"]
    assert not psutil.pid_exists(int(url.partition("#")[2]))


async def test_a_replay_that_fails_says_why(client: httpx.AsyncClient, app: FastAPI, tour: bytes) -> None:
    app.state.replays.command = ("sh", "-c", "echo loading >&2; echo 'hbba replay: it holds no sensors' >&2; exit 2")
    refused = is_problem(await client.post("/recordings/tour/replay"), 502, "replay-failed")
    assert refused["detail"] == "tour cannot be replayed: it holds no sensors"


async def test_the_health_reports_a_recording_that_ended_by_itself(
    client: httpx.AsyncClient, recorder: ScriptedRecorder, system: System
) -> None:
    await client.post("/recordings", json={"name": "tour"})
    await heard(system, "recording")
    assert (await client.get("/health")).json()["problems"] == []
    recorder.say("stopped", reason="the disk is full: 0.1 GB are free")
    await heard(system, "stopped")
    health = (await client.get("/health")).json()
    assert health["status"] == "degraded"
    assert health["problems"] == ["recording stopped: the disk is full: 0.1 GB are free"]
    await client.post("/recordings/stop")
    await heard(system, "idle")
    assert (await client.get("/health")).json() | {"stamp": 0} == {"status": "ok", "stamp": 0, "problems": []}

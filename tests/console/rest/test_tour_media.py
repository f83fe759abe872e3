"""Pictures and videos of tours over REST: handed in, shown, taken along with a tour, deleted; and every refusal."""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import httpx
import pytest

from app.console.access import protocols
from app.console.access.credentials import Passwords
from app.console.access.passwords import hash_of
from app.console.access.request_limits import LARGEST_BODY_BYTES
from app.console.access.roles import Role
from app.console.app import create_app
from app.console.records.tours import TourMedia, TourMediaList
from app.program.system import System
from app.tours import media_content
from tests.console.answers import answered, is_problem
from tests.console.program import served
from tests.console.raw import connected, request
from tests.patience import PATIENCE_S
from tests.tours.media_files import box, mp4, picture, showing
from tests.tours.tours import ARM, tour_data

#: Larger than any other body may be.
LARGE = mp4(content=bytes(3 * LARGEST_BODY_BYTES))
UPLOAD = "/tour-media?name=arm.png"


def kept(system: System) -> list[str]:
    folder = system.tours.library.folder / "media"
    return sorted(os.listdir(folder)) if folder.is_dir() else []


async def until(holds: Callable[[], bool]) -> None:
    """Nothing says that a file is on its way, or gone: look for it."""
    async with asyncio.timeout(PATIENCE_S):
        while not await asyncio.to_thread(holds):  # noqa: ASYNC110
            await asyncio.sleep(0)


async def test_a_picture_from_its_upload_to_its_deletion(client: httpx.AsyncClient, system: System) -> None:
    made = await client.post("/tour-media", params={"name": "The arm.PNG"}, content=picture())
    assert (made.status_code, made.headers["Location"]) == (201, "/api/v1/tour-media/media/The-arm.png")
    assert answered(made, TourMedia).file == "media/The-arm.png"
    again = await client.post("/tour-media", params={"name": "The arm.PNG"}, content=picture())
    assert (again.status_code, again.json()["file"]) == (200, "media/The-arm.png"), "it is there"

    shown = await client.get("/tour-media/media/The-arm.png")
    assert (shown.content, shown.headers["content-type"]) == (picture(), "image/png")
    assert "sandbox" in shown.headers["content-security-policy"]
    part = await client.get("/tour-media/media/The-arm.png", headers={"Range": "bytes=1-3"})
    assert (part.status_code, part.content) == (206, b"PNG")

    stops = [ARM | {"do": showing("media/The-arm.png", "media/none.png")}]
    tour = await client.post("/tours", json=tour_data(id="new", stops=stops))
    warned = {each["field"]: each["message"] for each in tour.json()["problems"] if each["field"].endswith("file")}
    assert list(warned) == ["stops.0.do.1.show.file"], "what is missing is said, what is there is not"
    assert "media/none.png" in warned["stops.0.do.1.show.file"]
    (listed,) = answered(await client.get("/tour-media"), TourMediaList).media
    assert (listed.file, listed.tours, listed.size, listed.video) == (
        *("media/The-arm.png", ("new",), len(picture())),
        False,
    )

    in_use = await client.delete("/tour-media/media/The-arm.png")
    is_problem(in_use, 409, "media-in-use")
    assert in_use.json()["tours"] == ["new"]
    await client.patch("/tours/new", json={"stops": [ARM]})
    assert (await client.delete("/tour-media/media/The-arm.png")).status_code == 204
    is_problem(await client.delete("/tour-media/media/The-arm.png"), 404, "no-such-media")
    is_problem(await client.get("/tour-media/media/The-arm.png"), 404, "no-such-media")
    assert await asyncio.to_thread(kept, system) == []


async def test_a_video_may_be_larger_than_other_bodies(url: str, system: System) -> None:
    """Over a real socket, in chunks as well."""

    async def pieces() -> AsyncIterator[bytes]:
        for at in range(0, len(LARGE), 10_000):
            yield LARGE[at : at + 10_000]

    async with httpx.AsyncClient(base_url=f"{url}/api/v1", timeout=None) as client:
        for content in (LARGE, pieces()):
            made = await client.post("/tour-media", params={"name": "walk.mp4"}, content=content)
            assert made.json()["file"] == "media/walk.mp4"
        is_problem(await client.post("/desires", content=LARGE), 413, "body-too-large")
        assert (await client.get("/tour-media/media/walk.mp4")).content == LARGE


async def test_what_is_no_picture_is_refused_and_not_kept(
    url: str, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(media_content, "LARGEST_PICTURE_BYTES", 100_000)
    monkeypatch.setattr(media_content, "LARGEST_VIDEO_BYTES", 10_000)
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", timeout=None) as client:
        for content, status, kind in (
            (b"<script>alert(1)</script>" * 9, 422, "invalid-media"),
            (b"", 422, "invalid-media"),
            (picture()[:60], 422, "invalid-media"),
            (box(b"ftyp", b"qt  ") + bytes(100), 422, "invalid-media"),
            (picture() + bytes(100_000), 413, "media-too-large"),
            (LARGE, 413, "media-too-large"),
        ):
            refused = await client.post(UPLOAD, content=content)
            is_problem(refused, status, kind)
            assert refused.json()["detail"].startswith("arm.png "), "the file is named"
        is_problem(await client.post("/tour-media", content=picture()), 422, "invalid-request")
    assert await asyncio.to_thread(kept, system) == []


async def test_an_upload_that_breaks_off_leaves_nothing(url: str, system: System) -> None:
    async with connected(url) as raw:
        await raw.send(request(f"POST /api/v1{UPLOAD}", "Content-Length: 100000", body=picture()))
        await until(lambda: len(kept(system)) == 1)
    await until(lambda: kept(system) == [])


async def test_an_upload_that_trickles_ends_and_a_steady_one_does_not(
    url: str, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(protocols, "BODY_WITHIN_S", 0.2)
    async with connected(url) as raw:
        await raw.send(request(f"POST /api/v1{UPLOAD}", "Content-Length: 100000", body=picture()))
        status, said = await raw.answer()
        assert (status, b"too-slow" in said) == (408, True)
    monkeypatch.setattr(protocols, "SLOWEST_FILE_BYTES_PER_S", 1)
    content = picture()
    async with connected(url) as raw:
        await raw.send(request(f"POST /api/v1{UPLOAD}", f"Content-Length: {len(content)}", "Connection: close"))
        await raw.send(content[:50])
        await asyncio.sleep(0.5)  # longer than another body has: the time itself is what is tested
        await raw.send(content[50:])
        assert (await raw.answer())[0] == 201


async def test_spectators_see_and_operators_change(system: System, page: Path) -> None:
    passwords: Passwords = tuple((role, hash_of(f"the {role}s' own")) for role in (Role.SPECTATOR, Role.OPERATOR))
    app = create_app(system, static_dir=page, token="the token itself", passwords=passwords, early_view=False)
    async with served(app) as url, httpx.AsyncClient(base_url=f"{url}/api/v1", timeout=None) as client:
        is_problem(await client.post(UPLOAD, content=picture()), 401, "login-needed")
        may = {role: {"Authorization": f"Bearer the {role}s' own"} for role, _ in passwords}
        is_problem(await client.post(UPLOAD, content=picture(), headers=may[Role.SPECTATOR]), 403, "role-needed")
        assert (await client.post(UPLOAD, content=picture(), headers=may[Role.OPERATOR])).status_code == 201
        assert (await client.get("/tour-media/media/arm.png", headers=may[Role.SPECTATOR])).status_code == 200
        is_problem(await client.delete("/tour-media/media/arm.png", headers=may[Role.SPECTATOR]), 403, "role-needed")
        assert (await client.delete("/tour-media/media/arm.png", headers=may[Role.OPERATOR])).status_code == 204


async def test_a_tour_travels_with_its_pictures(client: httpx.AsyncClient, system: System) -> None:
    file = (await client.post(UPLOAD, content=picture())).json()["file"]
    made = await client.post("/tours", json=tour_data(id="new", stops=[ARM | {"do": showing(file)}]))
    packed = await client.get("/tours/new/archive")
    assert packed.headers["content-disposition"] == 'attachment; filename="new.zip"'
    assert packed.headers["content-type"] == "application/zip"
    is_problem(await client.post("/tours/import", content=packed.content), 409, "tour-exists")

    await client.delete("/tours/new")
    await client.delete(f"/tour-media/{file}")
    come = await client.post("/tours/import", content=packed.content)
    assert (come.status_code, come.json()["tour"]) == (201, made.json()["tour"])
    assert (await client.get(f"/tour-media/{file}")).content == picture()

    replaced = await client.post("/tours/import", content=packed.content, headers={"If-Match": come.headers["ETag"]})
    assert replaced.status_code == 200
    is_problem(await client.post("/tours/import", content=packed.content[:-60]), 422, "invalid-archive")
    is_problem(await client.post("/tours/import", content=b"#" * 1_000_001), 413, "body-too-large")
    assert await asyncio.to_thread(kept, system) == ["arm.png"], "nothing partial is left"

"""The console on a real program, called in process or really served."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI
from fastapi.dependencies import utils
from fastapi.dependencies.models import Dependant

from app.console.app import create_app
from app.console.live.hub import Hub
from app.program.system import System
from tests.console.program import Body, build, served, write_page
from tests.console.scripted_recorder import ScriptedRecorder
from tests.logs.replay.playing import Played, played


@pytest.fixture(scope="session", autouse=True)
def _parameters_are_examined_once() -> Iterator[None]:
    """What FastAPI finds out about an endpoint's parameters, it finds out again for each application.

    Hundreds of tests make one application each, whose endpoints are of the same code: that took half of their time.
    """
    known: dict[tuple[str, object], Dependant] = {}

    def get_dependant(*, path: str, call: Callable[..., Any], **options: Any) -> Dependant:
        key = path, getattr(call, "__code__", call)
        if key not in known:
            known[key] = utils.get_dependant(path=path, call=call, **options)
        return replace(known[key], call=call)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fastapi.routing.get_dependant", get_dependant)
        yield


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """The program before it runs."""
    return build(tmp_path)


@pytest.fixture
def page(tmp_path: Path) -> Path:
    """The built page's folder."""
    return write_page(tmp_path)


@pytest.fixture
async def system(built: tuple[System, Body]) -> AsyncIterator[System]:
    """The program at work."""
    async with built[0] as system:
        await system.translator.settled()
        yield system


@pytest.fixture
def body(built: tuple[System, Body]) -> Body:
    """Its body, to feed."""
    return built[1]


@pytest.fixture
def app(system: System, page: Path) -> FastAPI:
    """The console on loopback without a token."""
    return create_app(system, static_dir=page, early_view=False)


@pytest.fixture
def hub(app: FastAPI) -> Hub:
    """All its viewers."""
    found: Hub = app.state.hub
    return found


@pytest.fixture
async def client(app: FastAPI) -> AsyncIterator[httpx.AsyncClient]:
    """REST in process, as a program on this computer sees it."""
    async with app.router.lifespan_context(app):
        transport = httpx.ASGITransport(app, raise_app_exceptions=True)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:8080/api/v1") as client:
            yield client


@pytest.fixture
async def url(app: FastAPI) -> AsyncIterator[str]:
    """The console really served."""
    async with served(app) as url:
        yield url


@pytest.fixture
def recorder(system: System) -> ScriptedRecorder:
    """The Recorder at work."""
    module = system.graph.modules["Recorder"].module
    assert isinstance(module, ScriptedRecorder)
    return module


@pytest.fixture
async def play(prepared: Any) -> AsyncIterator[Played]:
    """The recording that a test calls ``prepared``, standing at its beginning."""
    async with played(prepared) as play:
        yield play


@pytest.fixture
async def replay_url(play: Played, tmp_path: Path) -> AsyncIterator[str]:
    """Its console."""
    static = await asyncio.to_thread(write_page, tmp_path)
    app = create_app(play.replay.system, static_dir=static, early_view=False, playback=play.playback)
    async with served(app) as url:
        yield url

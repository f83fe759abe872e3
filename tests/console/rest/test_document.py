"""docs/rest.md is true: every example in it works, and every problem it names exists."""

from __future__ import annotations

import asyncio
import os
import re
from pathlib import Path

import pytest
from fastapi import FastAPI

from app.program.system import System
from tests.console.places import FakeMapServer, StraightPlanner
from tests.console.program import Body, build
from tests.patience import PATIENCE_S

DOCUMENT = Path(__file__).parents[3] / "docs" / "rest.md"
SOURCES = Path(__file__).parents[3] / "app" / "console"


@pytest.fixture
def script() -> str:
    """All shell examples of the document, one after the other."""
    text = DOCUMENT.read_text(encoding="utf-8")
    return "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL))


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program with a Recorder."""
    return build(tmp_path, recorder=True)


async def test_every_example_works(url: str, script: str, app: FastAPI, system: System, tmp_path: Path) -> None:
    system.map.attach(FakeMapServer(system.maps))
    system.routes.attach(StraightPlanner())
    assert script.count("curl") >= 30
    # What a replay does is tested elsewhere.
    app.state.replays.command = ("sh", "-c", "echo 'HBBA is up: http://127.0.0.1:4711  (...)'; exec sleep 60")
    here = script.replace("http://127.0.0.1:8080", url)
    process = await asyncio.create_subprocess_exec(
        "sh",
        "-euc",
        here,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    try:
        out, err = await asyncio.wait_for(process.communicate(), PATIENCE_S)
    finally:
        if process.returncode is None:
            process.kill()
    assert process.returncode == 0, err.decode()
    assert b"urn:hbba:problem:unknown-desire-class" in out
    assert b"http://127.0.0.1:4711" in out
    assert await asyncio.to_thread((tmp_path / "tour.mcap").is_file)


def test_every_problem_there_is_is_listed() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    kinds = {
        kind
        for file in SOURCES.rglob("*.py")
        for kind in re.findall(r"Problem\(\s*\d{3},\s*\"([a-z-]+)\"", file.read_text(encoding="utf-8"))
    }
    assert len(kinds) >= 14
    assert {kind for kind in kinds if f"`{kind}`" not in text} == set()

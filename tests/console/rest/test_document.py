"""docs/rest.md is true: every example in it works, and every problem it names exists."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path

import pytest

DOCUMENT = Path(__file__).parents[3] / "docs" / "rest.md"
SOURCES = Path(__file__).parents[3] / "app" / "console"


@pytest.fixture
def script() -> str:
    """All shell examples of the document, one after the other."""
    text = DOCUMENT.read_text(encoding="utf-8")
    return "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL))


async def test_every_example_works(url: str, script: str) -> None:
    assert script.count("curl") >= 20
    here = script.replace("http://127.0.0.1:8080", url)
    process = await asyncio.create_subprocess_exec(
        "sh", "-euc", here, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
    )
    out, err = await process.communicate()
    assert process.returncode == 0, err.decode()
    assert b"urn:hbba:problem:unknown-desire-class" in out


def test_every_problem_there_is_is_listed() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    kinds = {
        kind
        for file in SOURCES.rglob("*.py")
        for kind in re.findall(r"Problem\(\s*\d{3},\s*\"([a-z-]+)\"", file.read_text(encoding="utf-8"))
    }
    assert len(kinds) >= 14
    assert {kind for kind in kinds if f"`{kind}`" not in text} == set()

"""``hbba node``: what it refuses before it joins anything, and the robot's refusal."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from app import cli
from tests.patience import PATIENCE_S
from tests.remote.program import build, free_port, node_process, write


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--join", "tcp/192.168.1.2:7447"], "--join: tcp/192.168.1.2:7447 leaves this computer unencrypted"),
        (["--join", "7447"], "--join: should be tcp/HOST:PORT or tls/HOST:PORT"),
        (["--join", "tls/robot.lan:7447"], "--join: tls/robot.lan:7447 needs certificates"),
        (["--join", "tls/robot.lan:7447", "--ca", "ca.pem"], "--certificate: is needed beside the others"),
        (["--join", "tcp/127.0.0.1:7447", "--name", "attic"], "--name: this program has no computer 'attic'"),
        (["--join", "tcp/127.0.0.1:7447", "--modules", "Light"], "there is no module 'Light'"),
    ],
)
def test_what_cannot_join_is_refused_with_the_reason(
    arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = write(tmp_path / "robot", 7447)
    assert cli.main(["node", "--config", str(program), *arguments]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.slow
async def test_the_robots_refusal_ends_it_with_the_reason(tmp_path: Path) -> None:
    pytest.importorskip("zenoh", reason="needs Zenoh: the extra `remote`")
    port = free_port()
    program = await asyncio.to_thread(write, tmp_path / "robot", port)
    other = await asyncio.to_thread(write, tmp_path / "node", port, settings="{step: 4}")
    system = await asyncio.to_thread(build, program)
    async with system, node_process(other) as node:
        async with asyncio.timeout(PATIENCE_S):
            _, errors = await node.communicate()
    assert node.returncode == 1
    assert "the robot refuses desk: Darkness has other settings on desk" in errors.decode()

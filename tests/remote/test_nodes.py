"""Modules on another computer: two programs that speak over real links of Zenoh on this one."""

from __future__ import annotations

import asyncio
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from app.program.system import System
from app.remote.node import Refused
from app.remote.settings import TlsFiles
from tests.console.program import sound
from tests.patience import PATIENCE_S
from tests.remote.program import (
    ME,
    build,
    chosen,
    free_port,
    image,
    joined,
    looks,
    node_of_program,
    node_process,
    until,
    write,
)
from tests.remote.stuck import STUCK

pytest.importorskip("zenoh", reason="needs Zenoh: the extra `remote`")

#: So many messages are under way at once: fewer than an inbox holds.
IN_FLIGHT = 40
HOME, AT_DESK = {"look-seldom"}, {"look@desk"}


def _desire(system: System) -> None:
    system.workspace.add("DetectDarkness", intensity=5, utility=1, source=ME)


@pytest.mark.slow
async def test_a_node_that_is_killed_or_frozen_is_done_without_and_comes_back(tmp_path: Path) -> None:
    """Attention chooses the other computer while it is there, and what it can afford at home while it is not."""
    program = await asyncio.to_thread(write, tmp_path / "robot", free_port())
    system = await asyncio.to_thread(build, program)
    async with system:
        _desire(system)
        await until(system, lambda: chosen(system) == HOME)
        await looks(system, 100.0)
        async with node_process(program) as node:
            await until(system, lambda: chosen(system) == AT_DESK)
            local = system.graph.modules["Darkness"].context.inputs["images"].subscription
            taken, looked = local.taken, system.graph.modules["Darkness"].context.persistent["looks"]
            await looks(system, 200.0)
            assert local.taken == taken
            # The images are much smaller than was reckoned with, which the solver then knows.
            await until(system, lambda: system.translator.table["look@desk"].costs["bandwidth@desk"] < 0.1)
            # It went on from what was kept at home.
            assert system.graph.modules["Darkness"].context.persistent["looks"] > looked

            node.send_signal(signal.SIGSTOP)
            await until(system, lambda: chosen(system) == HOME)
            assert "desk" in system.nodes.hub.link("desk").health.why
            await looks(system, 300.0)
            node.send_signal(signal.SIGCONT)
            await until(system, lambda: chosen(system) == AT_DESK)
            await looks(system, 400.0)

            node.kill()
            await until(system, lambda: chosen(system) == HOME)
            await looks(system, 500.0)
        texts = [event.text for event in system.timeline.query(kinds=("capacity",))]
        assert any("desk is lost" in text for text in texts)
        assert {state.restarts for state in system.supervisor.states.values()} == {0}


async def test_a_node_that_answers_too_late_is_not_used_and_said_so(tmp_path: Path) -> None:
    program = await asyncio.to_thread(write, tmp_path / "robot", free_port(), deadline_s=1.0)
    system = await asyncio.to_thread(build, program)
    made = await asyncio.to_thread(node_of_program, program)
    async with system, joined(made):
        _desire(system)
        await until(system, lambda: chosen(system) == AT_DESK)
        link = system.nodes.hub.link("desk")
        stuck = asyncio.create_task(_stick(system))
        await until(system, lambda: chosen(system) == HOME)
        stuck.cancel()
        assert not link.usable
        assert "desk" in link.health.why
        await looks(system, 100.0)


async def _stick(system: System) -> None:
    """Publish images that the node never comes to an end with."""
    stamp = 0.0
    while True:
        stamp += 0.1
        system.graph.channels["camera"].publish(image(stamp, STUCK))
        await system.clock.sleep(0.05)


async def test_of_sound_nothing_is_lost(tmp_path: Path) -> None:
    program = await asyncio.to_thread(write, tmp_path / "robot", free_port())
    await asyncio.to_thread(_for_sound, program)
    system = await asyncio.to_thread(build, program)
    made = await asyncio.to_thread(node_of_program, program)
    async with system, joined(made):
        _desire(system)
        await until(system, lambda: chosen(system) == AT_DESK)
        counted = system.graph.channels["darkness"].subscribe("test", capacity=400)
        messages = []
        async with asyncio.timeout(PATIENCE_S):
            for number in range(300):
                system.graph.channels["camera"].publish(sound(float(number), 512 * number))
                if number >= IN_FLIGHT:
                    messages.append(await counted.receive())
            messages += [await counted.receive() for _ in range(IN_FLIGHT)]
        assert [message.luma for message in messages] == [512.0 * number for number in range(300)]


def _for_sound(program: Path) -> None:
    """Let the program's module take sound instead of images."""
    for name, old, new in (
        ("program.yaml", "StuckDetector", "SampleCounter"),
        ("channels.yaml", "camera: {type: Image", "camera: {decimable: false, type: Audio"),
        ("strategies.yaml", "Darkness.images: 2", "Darkness.images: 1"),
    ):
        file = program.with_name(name)
        file.write_text(file.read_text().replace(old, new))


async def test_a_node_with_other_settings_is_refused_in_words(tmp_path: Path) -> None:
    port = free_port()
    program = await asyncio.to_thread(write, tmp_path / "robot", port)
    other = await asyncio.to_thread(write, tmp_path / "node", port, settings="{step: 4}")
    system = await asyncio.to_thread(build, program)
    made = await asyncio.to_thread(node_of_program, other)
    async with system, joined(made) as node:
        await asyncio.wait({node}, timeout=PATIENCE_S)
        with pytest.raises(Refused, match="Darkness has other settings on desk: step is 8 on the robot and 4 there"):
            node.result()


def _certificates(folder: Path) -> tuple[TlsFiles, TlsFiles]:
    """The robot's and the node's certificates, of one authority, made by OpenSSL."""

    def openssl(*arguments: str) -> None:
        subprocess.run(["openssl", *arguments], cwd=folder, check=True, capture_output=True)

    curve = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
    openssl("req", "-x509", *curve, "-keyout", "ca.key", "-out", "ca.pem", "-days", "2", "-subj", "/CN=the authority")
    (folder / "names").write_text("subjectAltName=IP:127.0.0.1\n")
    for name in ("robot", "desk"):
        openssl("req", *curve, "-keyout", f"{name}.key", "-out", f"{name}.csr", "-subj", f"/CN={name}")
        openssl(
            "x509", "-req", "-in", f"{name}.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial",
            "-out", f"{name}.pem", "-days", "2", "-extfile", "names",
        )  # fmt: skip
    robot, desk = (
        TlsFiles(ca=folder / "ca.pem", certificate=folder / f"{name}.pem", key=folder / f"{name}.key")
        for name in ("robot", "desk")
    )
    return robot, desk


@pytest.mark.skipif(shutil.which("openssl") is None, reason="needs OpenSSL, which makes the certificates")
async def test_certificates_of_one_authority_join_and_others_do_not(tmp_path: Path) -> None:
    files, strangers = tmp_path / "robot", tmp_path / "strangers"
    files.mkdir()
    strangers.mkdir()
    _, desk = await asyncio.to_thread(_certificates, files)
    _, stranger = await asyncio.to_thread(_certificates, strangers)
    tls = "tls: {ca: ca.pem, certificate: robot.pem, key: robot.key}"
    program = await asyncio.to_thread(write, files, free_port(), protocol="tls", tls=tls)
    system = await asyncio.to_thread(build, program)
    # The stranger comes first, and has all the time that the other takes.
    first = await asyncio.to_thread(node_of_program, program)
    second = await asyncio.to_thread(node_of_program, program)
    async with system, joined(first, stranger) as outside:
        link = system.nodes.hub.link("desk")
        async with joined(second, desk):
            await until(system, lambda: link.usable)
            assert link.offer is not None
            assert link.offer.process == second[0].process
            assert not outside.done()

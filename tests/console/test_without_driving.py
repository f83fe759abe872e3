"""A program that only looks: no base, and no module that takes teleop_command. It runs, and the console serves it."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Literal

import pytest

from app.console.app import create_app
from app.console.drive import drive_lease
from app.console.drive.drive_controller import Driving
from app.console.live.hub import Hub
from app.program.config import load_configuration
from app.program.system import System
from tests.console.program import Body

FILES = {
    "program.yaml": """\
robot: robot.yaml
channels: channels.yaml
strategies: [strategies.yaml]
modules:
  Kinect:
    class: app.modules.sensors.kinect:Kinect
    outputs: {images: kinect}
  QRCodeDetector:
    class: app.modules.perception.qr_code_detector:QRCodeDetector
    inputs: {images: kinect}
""",
    # As in the table that programs share: a channel is there, used or not.
    "channels.yaml": """\
kinect: {type: Image, rate_hz: 15}
teleop_command: {type: TeleopCommand, decimable: false, external: true}
""",
    "robot.yaml": "{}\n",
    "strategies.yaml": """\
resources: {cpu: {capacity: 6}}
strategies:
  - {name: look, class: FindQRCodes, utility: 1, filters: {QRCodeDetector.images: 1}, costs: {cpu: 1}}
""",
}


@pytest.fixture
def system(tmp_path: Path) -> System:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return System(load_configuration(tmp_path / "program.yaml"), link=Body())


async def test_it_goes_on_and_is_served(system: System) -> None:
    async with system:
        failed = asyncio.create_task(system.wait_failed())
        app = create_app(system, early_view=False)
        async with app.router.lifespan_context(app):
            await system.translator.settled()
            await asyncio.wait({failed}, timeout=0.2)
            assert not failed.done()
        failed.cancel()


async def test_a_page_desires_no_pictures_where_nothing_makes_any(system: System) -> None:
    """It would stand there unfulfilled, as if something were wrong."""
    async with system:
        hub = Hub(system)
        hub.open()
        hub.join("Ann")
        assert "Telepresence" not in system.classes
        assert system.workspace.desires() == ()
        hub.close()


async def test_a_page_learns_that_there_is_nothing_to_drive(system: System) -> None:
    async with system:
        hub = Hub(system)
        hub.open()
        viewer = hub.join("Ann")
        hello = json.loads(await viewer.outbox.take())
        assert hello["drive"] is False
        assert not any(hello["channels"].values())
        hub.close()


async def test_a_page_that_would_drive_gets_one_notice_and_no_wheel(system: System) -> None:
    notices: list[str] = []

    def notify(session: str, level: Literal["info", "warning", "error"], text: str) -> None:
        notices.append(text)

    driving = Driving(system.clock, system.link, None, notify, lambda: None)
    driving.handle(drive_lease.Connected("page", "operator"))
    for sequence in range(3):
        driving.handle(drive_lease.Drive("page", sequence, True, 1.0, 0.0))
    driving.handle(drive_lease.TakeControl("page"))
    assert driving.lease.driver is None
    assert notices == ["This program drives nothing: no module takes teleop_command."]
    driving.handle(drive_lease.Disconnected("page"))

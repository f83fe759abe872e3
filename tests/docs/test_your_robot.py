"""docs/your-robot.md, followed as a reader would: its files are written, its commands are run, and the robot drives."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest

from app import cli
from app.base.child_processes import python
from app.robots.drivers.config import load_drivers_config
from tests.patience import PATIENCE_S
from tests.robots.drivers.parts import PartsDriver, free_port
from tests.robots.played import odometry

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "your-robot.md").read_text("utf-8")
FILES = dict(re.findall(r"```(?:xml|yaml|python)\n(?:# |<!-- )(\S+)(?: -->)?\n(.*?)```", TEXT, flags=re.DOTALL))
COMMANDS = [line for block in re.findall(r"```sh\n(.*?)```", TEXT, flags=re.DOTALL) for line in block.splitlines()]
#: Ports that the page names, which other tests might have.
BASE, LASER, CODE, CONSOLE = "/tmp/my_base", "127.0.0.1:10940", "127.0.0.1:7001", "127.0.0.1:8080"


class Reader:
    """Follows the page in a folder, with ports of this test's own in place of those that it names."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.console = free_port()
        self.others = {
            BASE: str(folder / "my_base"),
            LASER: f"127.0.0.1:{free_port()}",
            CODE: f"127.0.0.1:{free_port()}",
            CONSOLE: f"127.0.0.1:{self.console}",
        }
        self.running: list[subprocess.Popen[str]] = []

    def write(self, *names: str) -> None:
        """Save blocks of the page as the files that they name."""
        for name in names:
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            text = FILES[name]
            for before, after in self.others.items():
                host, _, port = before.rpartition(":")
                own = after.rpartition(":")[2]
                text = text.replace(before, after).replace(f'("{host}", {port})', f'("{host}", {own})')
            path.write_text(text, "utf-8")

    def command(self, begin: str) -> list[str]:
        """The one command of the page that begins so, as its words."""
        (line,) = [line for line in COMMANDS if line.startswith(begin)]
        for before, after in self.others.items():
            line = line.replace(before, after)
        return shlex.split(line.removesuffix(" &"))

    def start(self, words: list[str], until: str) -> subprocess.Popen[str]:
        """Start a program of the page, and wait until it says so much."""
        arguments = {"python": python(), "hbba": python("-m", "app.cli")}[words[0]] + words[1:]
        environment = os.environ | {"PYTHONPATH": str(ROOT), "HOME": str(self.folder)}
        program = subprocess.Popen(
            arguments, cwd=self.folder, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self.running.append(program)
        assert program.stdout is not None
        for line in program.stdout if until else ():
            if line.startswith(until):
                break
        return program

    def close(self) -> None:
        for program in self.running:
            program.terminate()
            program.wait()
            assert program.stdout is not None
            program.stdout.close()


@pytest.fixture
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Reader]:
    monkeypatch.chdir(tmp_path)
    found = Reader(tmp_path)
    yield found
    found.close()


def test_the_page_has_the_files_and_commands_that_are_followed() -> None:
    assert FILES.keys() == {"my_robot/robot.urdf", "my_robot/robot.yaml", "my_base.py", "my_robot/by_code.yaml"}
    assert {line.split()[0] for line in COMMANDS} == {"hbba", "pip", "python", "curl"}


@pytest.mark.slow
def test_a_serial_base_and_a_laser_drive_to_a_goal(reader: Reader, capsys: pytest.CaptureFixture[str]) -> None:
    reader.write("my_robot/robot.urdf", "my_robot/robot.yaml")
    assert cli.main(reader.command("hbba check my_robot/robot.yaml")[1:]) == 0, capsys.readouterr().out
    log = reader.folder / "truth.log"
    player = reader.command("python -m app.robots.simulated.parts.player")
    # A tenth of the laser's own rate, so that a busy computer can follow.
    reader.start([*player, "--scan-hz", "5", "--log", str(log)], "ready")
    run = reader.command("hbba run --config serial_base")
    reader.start([*run, "--port", str(reader.console), "--scene-port", "0"], "HBBA is up")
    curl = reader.command("curl -fsS -X PUT")
    goal = httpx.put(curl[4], content=curl[-1], headers={"Content-Type": "application/json"}, timeout=PATIENCE_S)
    assert goal.is_success, goal.text

    def driven_m() -> float:
        lines = log.read_text("utf-8").splitlines()[:-1]
        return float(lines[-1].split()[3]) if lines else 0.0

    def drives(program: subprocess.Popen[str]) -> bool:
        return driven_m() > 0.5 or program.poll() is not None

    wait_until(lambda: drives(reader.running[-1]))
    assert driven_m() > 0.5
    report = httpx.get(f"http://127.0.0.1:{reader.console}/api/v1/robot", timeout=PATIENCE_S).json()
    assert report["robot"]["name"] == "My robot"


def wait_until(found: Callable[[], bool]) -> None:
    """Look until ``found()``."""
    deadline = time.monotonic() + PATIENCE_S
    while not found():
        assert time.monotonic() < deadline
        time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.blocking(reason="follows the page; nothing else is on the loop")
async def test_motors_behind_code_are_driven(reader: Reader, capsys: pytest.CaptureFixture[str]) -> None:
    reader.write("my_robot/robot.urdf", "my_robot/by_code.yaml", "my_base.py")
    assert cli.main(reader.command("hbba check my_robot/by_code.yaml")[1:]) == 0, capsys.readouterr().out
    reader.start(reader.command("python my_base.py"), "")
    config = load_drivers_config(reader.folder / "my_robot" / "by_code.yaml")
    async with PartsDriver(config.model_copy(update={"found_within_s": PATIENCE_S})) as driver:
        await driver.set_out()
        driver.commands = False
        await driver.stopped_for("no fresh command")
        await driver.wait_for("standing", lambda seen: odometry(seen).linear_mps == 0.0)

"""The whole program as a process, with its guard's log: for the browser tests and the benchmark of driving."""

from __future__ import annotations

import json
import math
import os
import queue
import re
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from app.base.geometry import Pose2
from app.base.paths import config_dir
from app.base.yaml_source import parse
from app.robots.config import load_robot_config
from app.robots.simulated.guard_log import GuardLogReader, GuardRow
from app.robots.simulated.world_config import WorldConfig
from tests.patience import PATIENCE_S

CHROMIUM_ARGUMENTS = [
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
#: The suite debugs its own loops. A program runs as people run it: debugged, it would be too slow to keep its pace.
LOOPS_DEBUG = "PYTHONASYNCIODEBUG"
CALM_PANORAMA_HZ = 2
#: Of a light robot: rates (Hz) of pictures and scans, and the size of small pictures (px).
LIGHT_KINECT_HZ, LIGHT_SCAN_HZ, LIGHT_SIZE = 5, 10, {"width": 320, "height": 240}


@dataclass(frozen=True)
class Robot:
    """A running program: its address, and what a test may know that no module does."""

    url: str
    guard_log: GuardLogReader
    start: Pose2
    posters: dict[str, tuple[float, float, float]]
    process: subprocess.Popen[str]

    def request(self, method: str, path: str, body: Any = None) -> tuple[int, str, Any]:
        """One REST call: status, content type, decoded body."""
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(
            f"{self.url}/api/v1{path}", data, {"Content-Type": "application/json"}, method=method
        )
        try:
            with urllib.request.urlopen(request, timeout=PATIENCE_S) as answer:
                text = answer.read()
                return answer.status, answer.headers.get("content-type", ""), json.loads(text) if text else None
        except urllib.error.HTTPError as refusal:
            with refusal:
                return refusal.code, refusal.headers.get("content-type", ""), json.loads(refusal.read())

    def get(self, path: str) -> Any:
        """The body of a GET."""
        return self.request("GET", path)[2]

    def odometry(self) -> dict[str, float]:
        """Pose and twist by the wheels' odometry."""
        odometry: dict[str, float] = self.get("/robot")["odometry"]
        return odometry

    def wheels(self) -> list[GuardRow]:
        """Everything the wheels were given so far."""
        return self.guard_log.rows()

    def true_place(self, text: str) -> tuple[float, float, float]:
        """Where the poster that says ``text`` hangs, in ``odom`` as it would be without drift."""
        x, y, z = self.posters[text]
        seen = self.start.inverse() @ Pose2(x, y, 0.0)
        return seen.x, seen.y, z


@contextmanager
def running_robot(
    folder: Path,
    scenario: Path | None = None,
    *,
    calm: bool = False,
    light: bool = False,
    charge: float | None = None,
) -> Iterator[Robot]:
    """``hbba run`` on a free port, its files in ``folder``, with the people of ``scenario``; stopped at the end.

    ``charge``: of the battery at the start, 0 to 1; None: as shipped.

    ``calm``: it desires codes and driving alone, and looks round seldom, so that two cores are enough for world,
    program and browser together where a test is about time.

    ``light``: its camera draws few and small pictures, its laser scans seldom: half of what the robot and its page take
    of the computer, for tests that are not about what it sees.
    """
    guard_log = folder / "guard.log"
    program, start = _program(folder, guard_log, scenario, calm=calm, light=light, charge=charge)
    with running_program(program, guard_log, start) as robot:
        yield robot


@contextmanager
def running_program(program: Path, guard_log: Path, start: Pose2, world_file: Path | None = None) -> Iterator[Robot]:
    """``hbba run`` of any ``program`` in the lab, or in the world of ``world_file``, on a free port.

    It keeps ``guard_log``, its robot begins at ``start``, and it is stopped at the end.
    """
    world = parse(world_file or config_dir() / "worlds" / "lab.yaml", WorldConfig)
    process = subprocess.Popen(
        [Path(sys.executable).with_name("hbba"), "run", "--config", program, "--port", "0"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={name: value for name, value in os.environ.items() if name != LOOPS_DEBUG},
    )
    lines: queue.Queue[str] = queue.Queue()
    output: list[str] = []
    reader = threading.Thread(target=_read, args=(process, lines, output), daemon=True)
    reader.start()
    try:
        posters = {p.text: (p.at[0], p.at[1], p.height) for p in world.posters}
        yield Robot(_address(lines, output), GuardLogReader(guard_log), start, posters, process)
    finally:
        process.terminate()
        process.wait(PATIENCE_S)
        reader.join()
        assert process.stdout is not None
        process.stdout.close()


def _program(
    folder: Path, guard_log: Path, scenario: Path | None, *, calm: bool, light: bool, charge: float | None
) -> tuple[Path, Pose2]:
    """The lab's program with the guard's log turned on, written to ``folder``; and where the robot starts."""
    config = config_dir()
    body = yaml.safe_load((config / "robots" / "irl1_tr.yaml").read_text())
    body |= {
        "guard_log": str(guard_log),
        "model": str(config / "robots" / body["model"]),
        "world": str(config / "worlds" / "lab.yaml"),
        "scenario": None if scenario is None else str(scenario),
    }
    if charge is not None:
        body["battery"]["charge"] = charge
    program = yaml.safe_load((config / "lab.yaml").read_text())
    channels = yaml.safe_load((config / program["channels"]).read_text())
    if calm:
        # Before the longest free way there is: test after test drives on, and before a wall the robot is held up.
        body["start"] = {"x": 3.5, "y": 7.9, "heading_deg": 0}
        look_round_seldom(body, channels)
        desires: list[dict[str, Any]] = [{"desire": "FindQRCodes"}, {"desire": "Teleoperation", "security": True}]
        program["rules"] = [write_rules(folder, desires)]
    if light:
        lighten(body, channels)
    (folder / "robot.yaml").write_text(yaml.safe_dump(body, sort_keys=False))
    (folder / "channels.yaml").write_text(yaml.safe_dump(channels))
    program |= {
        "robot": "robot.yaml",
        "channels": "channels.yaml",
        "strategies": [str(config / file) for file in program["strategies"]],
        # What attention gives must not depend on how busy the computer is.
        "attention": program["attention"] | {"closed_loop": "off"},
        "rules": [str(config / file) for file in program["rules"]],
    }
    path = folder / "program.yaml"
    path.write_text(yaml.safe_dump(program))
    start = load_robot_config(folder / "robot.yaml").start
    return path, Pose2(start.x, start.y, math.radians(start.heading_deg))


def write_rules(folder: Path, desires: list[dict[str, Any]]) -> str:
    """A file of rules with ``desires`` from start to stop; returns its path."""
    path = folder / "rules.yaml"
    path.write_text(yaml.safe_dump({"rules": [{"name": "scenario", "while": "always", "then": desires}]}))
    return str(path.resolve())


def lighten(body: dict[str, Any], channels: dict[str, Any], *, small: bool = True) -> None:
    """Make the robot of ``body`` and the table of its ``channels`` light, in place; its pictures ``small``, too."""
    streams = body["streams"]
    if small:
        streams["kinect"] |= LIGHT_SIZE
    streams["kinect"]["rate_hz"] = channels["kinect"]["rate_hz"] = LIGHT_KINECT_HZ
    streams["hokuyo"]["rate_hz"] = channels["scan"]["rate_hz"] = LIGHT_SCAN_HZ


def look_round_seldom(body: dict[str, Any], channels: dict[str, Any]) -> None:
    """Fewer pictures of all directions, in place: each takes more of the computer than any other."""
    body["streams"]["panorama"]["rate_hz"] = channels["panorama"]["rate_hz"] = CALM_PANORAMA_HZ


def _read(process: subprocess.Popen[str], lines: queue.Queue[str], output: list[str]) -> None:
    assert process.stdout is not None
    for line in process.stdout:
        output.append(line)
        lines.put(line)
    lines.put("")


def _address(lines: queue.Queue[str], output: list[str]) -> str:
    end = time.monotonic() + PATIENCE_S
    while line := lines.get(timeout=max(0.1, end - time.monotonic())):
        if found := re.search(r"HBBA is up: (\S+)", line):
            return found[1]
    raise AssertionError("the program did not come up:\n" + "".join(output))

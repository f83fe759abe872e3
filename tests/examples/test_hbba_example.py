"""The example package, installed as a person would, and run: every door is open to a package of others."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import httpx
import pytest

from app import cli
from app.base import paths
from app.commands.doctor import packages
from app.console.app import create_app
from app.console.panels import Panel, load_panels
from app.logs.library import RecordingLibrary
from app.logs.replay.unpack_attachments import extract
from app.program.attachments import snapshot
from app.program.config import Configuration, load_configuration
from app.program.system import System
from app.robots.factory import Body, create_link, load_body
from app.runtime.clock import RealClock
from tests.console.live_client import page as connected
from tests.console.program import served
from tests.patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "hbba-example"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder into which pip installed the package."""
    pytest.importorskip("hatchling", reason="the package is built with hatchling, which is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index",
               "--disable-pip-version-check", "--target", str(folder), str(EXAMPLE)]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture
def installed(site: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The package on the import path."""
    monkeypatch.syspath_prepend(str(site))
    yield site / "hbba_example"
    for name in [name for name in sys.modules if name.partition(".")[0] == "hbba_example"]:
        del sys.modules[name]


def test_the_doctor_lists_all_it_brings(installed: Path) -> None:
    finding = packages()
    assert finding.ok
    for what in ("bodies: example", "configurations: example", "experiments: near", "panels: near-things"):
        assert f"{what} (hbba-example)" in finding.found


def test_its_program_is_in_order_by_its_name(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", "example"]) == 0
    assert capsys.readouterr().out == f"{installed / 'example.yaml'}: program, no mistake found; it uses hbba_example\n"
    for name in ("robot.yaml", "strategies.yaml", "channels.yaml"):
        assert cli.main(["check", str(installed / name)]) == 0
        assert cli.main(["check", f"package:hbba_example/{name}"]) == 0


def test_its_experiment_runs_its_program_in_virtual_time(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["experiment", "near", "--seconds", "3"]) == 0
    scans, _, rest = capsys.readouterr().out.partition(" scans in 3 s, ")
    assert int(scans) > 10
    assert rest == f"{scans} with something nearby\n"


def test_its_own_tests_pass(site: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(site), str(ROOT)))}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(EXAMPLE)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture
def program(installed: Path, tmp_path: Path) -> tuple[System, dict[str, Panel]]:
    """Its program on its body, and its panels."""
    configuration: Configuration = load_configuration(installed / "example.yaml")
    body: Body = load_body(configuration.path(configuration.program.robot))
    clock = RealClock()
    link = create_link(body, clock.offset)
    recordings = RecordingLibrary(tmp_path / "recordings")
    return System(configuration, link=link, body=body, clock=clock, recordings=recordings), load_panels()


@pytest.fixture
async def url(program: tuple[System, dict[str, Panel]], tmp_path: Path) -> AsyncIterator[str]:
    """Its program's console."""
    system, panels = program
    async with system, served(create_app(system, static_dir=tmp_path, early_view=False, panels=panels)) as address:
        yield address


async def test_its_desire_class_is_desired_over_rest_and_its_panel_sees_what_comes(url: str) -> None:
    async with httpx.AsyncClient(base_url=url, timeout=PATIENCE_S) as rest:
        classes = {each["name"]: each for each in (await rest.get("/api/v1/desire-classes")).json()["classes"]}
        assert classes["CountNearThings"]["served"] is True
        assert classes["CountNearThings"]["schema"]["properties"]["within_m"]["default"] == 1.5
        (panel,) = (await rest.get("/panels/index.json")).json()
        assert panel == {
            "name": "near-things",
            "title": "Near things",
            "url": "panels/near-things.js",
            "kinds": ["channel/near_things"],
        }
        script = await rest.get(f"/{panel['url']}")
        assert script.text == (EXAMPLE / "hbba_example" / "panel.js").read_text("utf-8")
        assert "default-src 'self'" in script.headers["content-security-policy"]
        async with connected(url) as ann:
            frame = await ann.until("channel")
            assert frame["channel"] == "near_things"
            assert frame["message"]["count"] == 1
            desire = {"class": "CountNearThings", "intensity": 8, "utility": 1, "params": {"within_m": 0.5}}
            answer = await rest.post("/api/v1/desires", json=desire)
            assert answer.status_code == 201, answer.text
            while (frame := await ann.until("channel"))["message"]["count"]:
                pass
            assert frame["message"] == {"stamp": frame["message"]["stamp"], "count": 0, "nearest_m": None}
            refused = await rest.post("/api/v1/desires", json={**desire, "params": {"within_m": -1}})
            assert refused.status_code == 422
            assert "within_m" in json.dumps(refused.json())


def test_a_recording_carries_its_files_and_is_replayed_with_them(
    program: tuple[System, dict[str, Panel]], tmp_path: Path
) -> None:
    system, _ = program
    manifest = snapshot(system.config, system.graph, "a post")
    files = {file.name: file.data for file in manifest.files}
    assert {"example.yaml", "channels.yaml", "strategies.yaml", "robot.yaml", "robot.urdf"} <= files.keys()
    assert files["_packages/hbba/channels.yaml"] == (paths.config_dir() / "channels.yaml").read_bytes()
    home = extract(manifest, tmp_path)
    replayed = load_configuration(home / "example.yaml")
    assert replayed.channel_documents["scan"].file == str(home / "_packages" / "hbba" / "channels.yaml")
    assert replayed.channels == system.config.channels

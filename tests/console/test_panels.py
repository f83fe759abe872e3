"""Panels of packages: served to those alone who may use the console, and given the messages that they name."""

from __future__ import annotations

import logging
import sys
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import httpx
import pytest

from app.console.app import create_app
from app.console.panels import Panel, load_panels
from app.messages import Landmark, Landmarks
from app.program.system import System
from tests.console.live_client import page as connected
from tests.console.program import served
from tests.distributions import install
from tests.patience import PATIENCE_S

TOKEN = "correct horse battery"
SOURCE = """\
from pathlib import Path

from app.console.panels import Panel

KITE = Panel("Kite", Path(__file__).with_name("kite.js"), ("channel/landmarks", "channel/nowhere", "status"))
LOST = Panel("Lost", Path(__file__).with_name("lost.js"))
"""
SCRIPT = "export default (element) => { element.textContent = 'kite'; };\n"


@pytest.fixture
def panels(site: Path) -> dict[str, Panel]:
    """The panels that the package brings."""
    return load_panels()


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of the import path with a package that brings a panel."""
    folder = tmp_path / "site"
    files = {"kites_p/__init__.py": SOURCE, "kites_p/kite.js": SCRIPT}
    install(folder, "hbba-kites", files, panels={"kite": "kites_p:KITE"})
    monkeypatch.syspath_prepend(str(folder))
    yield folder
    sys.modules.pop("kites_p", None)


@pytest.fixture
async def guarded(panels: dict[str, Panel], system: System, page: Path) -> AsyncIterator[str]:
    """The console, served with a token."""
    async with served(create_app(system, static_dir=page, token=TOKEN, early_view=False, panels=panels)) as url:
        yield url


async def test_a_panel_is_served_behind_the_login_under_the_pages_policy(guarded: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=guarded) as stranger:
        page = await stranger.get("/")
        for path in ("/panels/index.json", "/panels/kite.js", "/panels/"):
            assert (await stranger.get(path)).status_code == 401, path
    async with httpx.AsyncClient(
        timeout=PATIENCE_S, base_url=guarded, headers={"Authorization": f"Bearer {TOKEN}"}
    ) as known:
        assert (await known.get("/panels/index.json")).json() == [
            {
                "name": "kite",
                "title": "Kite",
                "url": "panels/kite.js",
                "kinds": ["channel/landmarks", "channel/nowhere", "status"],
            }
        ]
        script = await known.get("/panels/kite.js")
        assert script.text == SCRIPT
        assert script.headers["content-type"].startswith("text/javascript")
        assert script.headers["content-security-policy"] == page.headers["content-security-policy"]
        missing = await known.get("/panels/kyte.js")
        assert missing.status_code == 404
        assert missing.json()["detail"] == "No package brings a panel 'kyte'."


async def test_messages_of_its_channels_come_on_the_live_stream(
    panels: dict[str, Panel], system: System, page: Path
) -> None:
    landmarks = system.graph.channel("landmarks")
    landmarks.publish(Landmarks(1.0, (Landmark("door", (1.0, 2.0, 0.5), 0.1, 3, 1.0, 2.0),)))
    app = create_app(system, static_dir=page, early_view=False, panels=panels)
    async with served(app) as url, connected(url) as ann:
        first = await ann.until("channel")
        assert first["channel"] == "landmarks"
        assert first["message"]["stamp"] == 1.0
        assert first["message"]["landmarks"][0]["text"] == "door"
        landmarks.publish(Landmarks(2.0, ()))
        assert (await ann.until("channel"))["message"] == {"stamp": 2.0, "landmarks": [], "frame": "odom"}


def test_one_that_cannot_be_used_is_left_out_with_a_sentence(site: Path, caplog: pytest.LogCaptureFixture) -> None:
    install(
        site,
        "hbba-worse",
        {"worse_p.py": "1 / 0\n"},
        panels={"broken": "worse_p:PANEL", "lost": "kites_p:LOST", "path": "kites_p:Path", "Kite!": "kites_p:KITE"},
    )
    with caplog.at_level(logging.WARNING, "hbba.console"):
        assert set(load_panels()) == {"kite"}
    said = "\n".join(caplog.messages)
    assert "panel broken is left out: 'broken' of hbba.panels, from hbba-worse: worse_p cannot be imported: " in said
    assert "panel path is left out: kites_p:Path of hbba-worse is no Panel" in said
    assert f"panel lost is left out: there is no file {site / 'kites_p' / 'lost.js'} of hbba-worse" in said
    assert "panel Kite! is left out: the name 'Kite!' has other characters than a-z, 0-9, _ and -" in said

"""A panel that a package brings: the page loads it under its own content policy and gives it the robot's messages."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from app.base.geometry import Pose2
from tests.browser.running import Robot, running_program
from tests.distributions import announce

EXAMPLE = Path(__file__).parents[2] / "examples" / "hbba-example"


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robot]:
    """The example package's program on its own body, the package put on the import path."""
    package = tmp_path / "hbba-example"
    shutil.copytree(EXAMPLE, package)
    announce(package)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(package), os.environ.get("PYTHONPATH", ""))))
    with running_program(package / "hbba_example" / "example.yaml", tmp_path / "guard.log", Pose2()) as running:
        yield running


def test_a_panel_shows_what_its_channel_says(open_page: Callable[..., Page]) -> None:
    page = open_page()
    tab = page.get_by_test_id("tab-panel-near-things")
    expect(tab).to_have_text("Near things")
    tab.click()
    words = page.get_by_test_id("near-things")
    expect(words).to_have_text("1 near, the nearest 1.00 m away")
    page.get_by_test_id("tab-attention").click()
    expect(words).to_have_count(0)
    tab.click()
    expect(words).to_have_text(re.compile("^1 near"))

"""One robot for all files of this folder: its start takes as long as most of their tests.

Each test leaves it where it is, without a desire of its own, its stop released and its link as it was: turned, at most.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.browser.running import Robot, running_robot


@pytest.fixture(scope="package")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """A calm and light robot, with a folder of recordings of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HBBA_RECORDINGS", str(tmp_path_factory.mktemp("recordings")))
        with running_robot(tmp_path_factory.mktemp("robot"), calm=True, light=True) as running:
            yield running


@pytest.fixture(autouse=True)
def _released(robot: Robot) -> None:
    """Whatever a test before left, if it failed: no stop, no shaped link."""
    assert robot.request("PUT", "/link", {})[0] == 200
    assert robot.request("DELETE", f"/stop?seen={robot.get('/robot')['stamp']}")[0] == 200

"""Pictures of a page in bad health are not written."""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("playwright")

# By its name: the scripts are no package for the type checker.
photographs: Any = import_module("scripts.photographs")
illness, shoot = photographs.illness, photographs.shoot

HEALTHY = {"[data-testid=connection][data-phase=live]": "Connected", "[data-testid=view-age]": "88 ms"}


class FakePage:
    """A page of which only what is there, by selector, is known."""

    def __init__(self, **more: str) -> None:
        found = {f"[data-testid={name.replace('_', '-')}]": text for name, text in more.items()}
        self.found = HEALTHY | found
        self.frames: list[Any] = [None]

    def locator(self, selector: str) -> Any:
        there = selector in self.found
        one = SimpleNamespace(count=lambda: int(there), inner_text=lambda: self.found[selector])
        one.first = one
        return one

    def get_by_test_id(self, name: str) -> Any:
        return self.locator(f"[data-testid={name}]")

    def wait_for_timeout(self, _: float) -> None:
        """Time passes."""


def test_a_page_in_good_health_has_no_illness() -> None:
    assert illness(FakePage()) == ""


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("world_rate", "World runs at 0.61\u00d7 real time", "0.61"),
        ("view_age", "1544 ms", "1544 ms old"),
        ("notice", "The 3D view is slow on this computer.", "3D view is slow"),
    ],
)
def test_what_ails_it_is_said_and_no_picture_is_written(name: str, text: str, words: str) -> None:
    page = FakePage(**{name: text})
    assert words in illness(page)
    with pytest.raises(SystemExit, match="tour-first-look: not written"):
        shoot(page, "tour-first-look")
    assert not list(photographs.FOLDER.glob("tour-first-look.jpeg"))


def test_an_old_picture_or_a_lost_page_are_seen() -> None:
    around = FakePage(around_age="3.3 s old")
    around.found["[data-testid=around-age].old"] = ""
    assert "3.3 s old" in illness(around)
    old = FakePage(camera_age="2.5 s old")
    old.found["[data-testid=camera].old"] = ""
    assert "2.5 s old" in illness(old)
    late = FakePage(camera_age="850 ms")
    late.found["[data-testid=camera-age].late"] = ""
    assert "late (850 ms)" in illness(late)
    lost = FakePage()
    del lost.found["[data-testid=connection][data-phase=live]"]
    assert "does not hear" in illness(lost)

"""What counts as useful, and as transferred, in the benchmark of the page's first paint."""

from __future__ import annotations

import pytest

from benchmarks.first_paint import Load, case_rows, own_bytes


def test_a_page_is_useful_once_state_and_picture_are_there() -> None:
    loads = [
        Load({"code": 200.0, "state": 500.0, "picture": 800.0}, 150_000, browser=0.5, program=0.1),
        Load({"code": 200.0, "state": 700.0, "picture": 600.0}, 170_000, browser=0.7, program=0.1),
    ]
    rows = {each.metric: each for each in case_rows("desk", loads)}
    assert rows["useful"].ours == 750
    assert rows["useful"].ratio == pytest.approx(0.75)
    assert rows["transferred"].ours == pytest.approx(160)
    assert rows["transferred"].peer == 200
    assert rows["browser"].ours == pytest.approx(600)
    assert [rows[name].n for name in ("code", "state", "picture")] == [2, 2, 2]


def test_the_3d_view_is_not_the_pages_own() -> None:
    came = [("http://h:1/", 500), ("http://h:1/assets/index.js", 9_000), ("http://h:2/viser/", 700_000)]
    assert own_bytes(came) == 9_500

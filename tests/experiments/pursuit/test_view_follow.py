"""The study's operator turns head and base as the page does."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from app.experiments.pursuit.view_follow import STILL, Follow, follow

EXAMPLES = Path(__file__).resolve().parents[3] / "web/src/drive/viewFollow.examples.json"


def test_the_page_does_the_same() -> None:
    for example in json.loads(EXAMPLES.read_text(encoding="utf-8")):
        found = follow(
            Follow(**example["before"]),
            example["bearing"],
            example["gaze"],
            limit=example["limit"],
            passed=example["passed"],
        )
        wanted = example["after"]
        assert found.turning == wanted["turning"], example["name"]
        assert (found.pan, found.angular) == pytest.approx((wanted["pan"], wanted["angular"]), abs=1e-6), example[
            "name"
        ]


def test_what_is_no_angle_moves_nothing() -> None:
    assert follow(Follow(True, 1.0, 0.5), math.nan, 0.0, passed=0.05) == STILL

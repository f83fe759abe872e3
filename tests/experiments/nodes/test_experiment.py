"""What a second computer is worth in the lab."""

from __future__ import annotations

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.experiments.nodes.experiment import BUDGETS, CLASSES, plan, run, table

LAB = paths.config_dir() / "lab.yaml"


def test_two_computers_give_at_least_what_one_does_and_most_where_one_is_far_too_small() -> None:
    what = plan(LAB, CLASSES, BUDGETS, bandwidth=5.0)
    assert set(what.node.settings.modules) == {"FaceDetector", "VoiceLocalizer", "SoundClassifier", "DarknessDetector"}
    found = run(what)
    assert all(gain.together >= gain.alone for gain in found)
    assert {gain.budget: gain.ratio for gain in found}[20.0] >= 1.7
    assert all(name in table(what, found) for name in ("locate-faces-2", "20", "two computers"))


def test_without_a_link_there_is_nothing_to_gain() -> None:
    (gain,) = run(plan(LAB, ("LocateFaces", "LocateVoices"), (15.0,), bandwidth=0.0))
    assert gain.together_by == gain.alone_by


def test_a_class_that_is_not_served_is_refused() -> None:
    with pytest.raises(ConfigError, match="no strategy serves 'LocateFace'"):
        plan(LAB, ("LocateFace",), (15.0,), bandwidth=1.0)

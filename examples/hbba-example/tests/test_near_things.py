"""The package's parts by themselves, and its program in virtual time."""

from __future__ import annotations

from pathlib import Path

import hbba_example
import pytest
from hbba_example import experiment
from hbba_example.body import PostConfig, scan
from hbba_example.messages import NearThings
from hbba_example.near_thing_counter import near_things

from app.base.geometry import Pose3
from app.robots.config import load_body_config


@pytest.fixture
def post() -> PostConfig:
    """The package's body."""
    return load_body_config(Path(hbba_example.__file__).with_name("robot.yaml"), PostConfig)


@pytest.mark.parametrize("at_s", [0.0, 2.5, 7.0, 9.9, 10.0, 10.1, 13.0])
def test_the_thing_is_one_wherever_it_is(post: PostConfig, at_s: float) -> None:
    assert near_things(scan(at_s, post, Pose3.identity()), 1.5) == NearThings(at_s, 1, 1.0)


def test_what_is_far_is_not_near(post: PostConfig) -> None:
    assert near_things(scan(3.0, post, Pose3.identity()), 0.9) == NearThings(3.0, 0, None)


def test_the_program_counts_while_it_is_desired() -> None:
    things = experiment.near_things(3.0)
    assert len(things) > 10
    assert {each.count for each in things} == {1}

from __future__ import annotations

import math

import pytest
from pydantic import ValidationError

from app.messages import LaserScan
from app.runtime.channel_table import ChannelSpec


def spec(**values: object) -> ChannelSpec:
    return ChannelSpec.model_validate({"type": "LaserScan", **values})


def test_a_row_names_a_message_class() -> None:
    assert spec().message_type is LaserScan


@pytest.mark.parametrize("name", ["Nothing", "Pose2", "CameraModel", "QRCode", "Message", "read_only", "np"])
def test_only_messages_cross_channels(name: str) -> None:
    with pytest.raises(KeyError, match=name):
        _ = spec(type=name).message_type


def test_the_age_allowed_grows_with_the_divisor_but_has_a_floor() -> None:
    row = spec(rate_hz=40)
    assert [row.stale_after_s(divisor) for divisor in (1, 4, 8, 80)] == pytest.approx([0.3, 0.3, 0.6, 6])
    assert row.stale_after_s(math.inf) == math.inf
    assert spec().stale_after_s(5) is None


@pytest.mark.parametrize("wrong", [{"rate_hz": 0}, {"stale_periods": -1}, {"log": "sometimes"}, {"rate": 5}])
def test_a_wrong_row_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        spec(**wrong)

"""Every message class there is goes into records and comes back as it was."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.logs.ros.converters import converter
from app.logs.ros.record import MAIN, Converter, Record
from app.logs.stamps import to_ns
from app.messages import Image, Odometry
from tests.logs.ros.messages import instances, message_classes, same, sequences


def parts_of(codec: Converter, records: list[Record]) -> dict[str, bytes]:
    """The data of the parts among ``records``, which stand in the order they are written."""
    part_of = {topic.name: topic.part for topic in codec.topics}
    found = [(part, record.data) for record in records if (part := part_of[record.topic]) is not None]
    assert found[-1][0] == MAIN
    assert len(dict(found)) == len(found)
    return dict(found)


def there_and_back(codec: Converter, message: Any) -> Any:
    """``message`` through its records; checks that these are what the converter announced."""
    records = codec.encode(message, to_ns(message.stamp))
    announced = {(topic.name, topic.type) for topic in codec.topics}
    assert {(record.topic, record.type) for record in records} <= announced
    assert all(type(record.data) is bytes for record in records)
    return codec.decode(parts_of(codec, records))


@pytest.mark.parametrize("cls", message_classes(), ids=lambda cls: cls.__name__)
@settings(max_examples=40, suppress_health_check=[HealthCheck.differing_executors])
@given(data=st.data())
def test_every_message_comes_back_as_it_was(cls: type[Any], data: st.DataObject) -> None:
    codec = converter("channel", cls)
    for message in data.draw(sequences(cls)):
        back = there_and_back(codec, message)
        if cls is Odometry:
            assert abs(back.X_OB.theta - message.X_OB.theta) < 1e-12
            back = replace(back, X_OB=replace(back.X_OB, theta=message.X_OB.theta))
        if cls is Image:
            assert back.color.dtype == np.uint8
            assert np.abs(back.color.astype(int) - message.color).max() <= 6
            back = replace(back, color=message.color)
        assert same(back, message)


@pytest.mark.parametrize("cls", message_classes(), ids=lambda cls: cls.__name__)
@settings(max_examples=5, suppress_health_check=[HealthCheck.differing_executors])
@given(data=st.data())
def test_arrays_read_back_are_read_only(cls: type[Any], data: st.DataObject) -> None:
    back = there_and_back(converter("channel", cls), data.draw(instances(cls)))
    for name in cls.__dataclass_fields__:
        value = getattr(back, name)
        if isinstance(value, np.ndarray):
            assert not value.flags.writeable


@pytest.mark.parametrize("cls", message_classes(), ids=lambda cls: cls.__name__)
@settings(max_examples=5, suppress_health_check=[HealthCheck.differing_executors])
@given(data=st.data())
def test_a_message_with_a_part_lost_is_none_and_not_half_a_message(cls: type[Any], data: st.DataObject) -> None:
    codec = converter("channel", cls)
    message = data.draw(instances(cls))
    parts = parts_of(codec, codec.encode(message, to_ns(message.stamp)))
    for lost in parts.keys() - {MAIN}:
        assert codec.decode({part: data for part, data in parts.items() if part != lost}) is None

"""The one way to the map."""

from __future__ import annotations

from typing import cast

import pytest

from app.maps.control import MapControl, MapKeeper, MapUnavailable


class Someone:
    """Stands for a keeper; nothing of it is called."""


def test_nobody_keeps_maps_until_somebody_attaches_and_after_they_left() -> None:
    control = MapControl()
    first, second = (cast(MapKeeper, Someone()) for _ in range(2))
    with pytest.raises(MapUnavailable, match="makes no maps"):
        _ = control.keeper
    leave = control.attach(first)
    assert control.available
    assert control.keeper is first
    control.attach(second)
    leave()  # the first one's, after a restart: the second stays
    assert control.keeper is second

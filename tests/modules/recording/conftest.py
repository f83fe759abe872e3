"""A disk that fails on request, in place of the Recorder's."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from app.modules.recording.recorder import Recorder
from tests.logs.mcap.disks import Disk


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Disk]:
    disk = Disk()
    monkeypatch.setattr(Recorder, "open_file", staticmethod(disk.open))
    yield disk
    disk.unblock.set()

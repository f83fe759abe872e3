"""The pressure of a computer, from what Linux would say of it."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest

from app.runtime.pressure import PressureMeter


def write(proc: Path, *, ran: int, waited: int, idle: int, stalled: int) -> None:
    """What Linux says: ns, ticks and µs since its begin."""
    for thread, share in (("10", 3), ("11", 1)):
        folder = proc / "self" / "task" / thread
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "schedstat").write_text(f"{ran * share} {waited * share} 7\n")
    core = min(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 0
    (proc / "stat").write_text(f"cpu  1 1 1 9999 0\ncpu{core} 5 0 5 {idle} 0 0\ncpu4711 5 0 5 99999 0 0\n")
    (proc / "pressure").mkdir(exist_ok=True)
    (proc / "pressure" / "cpu").write_text(f"some avg10=1.0 avg60=1.0 avg300=1.0 total={stalled}\nfull total=0\n")
    (proc / "loadavg").write_text("1.0 1.0 1.0 6/200 4711\n")


def test_a_window_is_what_was_between_two_looks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    times = iter((100.0, 102.0))
    monkeypatch.setattr("app.runtime.pressure.time.monotonic", lambda: next(times))
    write(tmp_path, ran=0, waited=0, idle=1000, stalled=0)
    meter = PressureMeter(tmp_path)
    write(tmp_path, ran=300, waited=100, idle=1050, stalled=500_000)
    found = meter.sample()
    assert found.waiting == pytest.approx(0.25)
    assert found.room == pytest.approx(25), "half a second in two"
    assert found.stalled == pytest.approx(0.25)
    assert found.runnable > 0


def test_what_cannot_be_read_is_not_known(tmp_path: Path) -> None:
    found = PressureMeter(tmp_path).sample()
    assert all(math.isnan(value) for value in (found.waiting, found.room, found.stalled, found.runnable))


def test_this_computer_can_be_read() -> None:
    found = PressureMeter().sample()
    assert not found.room < 0
    assert math.isnan(found.waiting) or 0 <= found.waiting <= 1

"""The guard's log: what is written is read, a torn last row is left out."""

from __future__ import annotations

from pathlib import Path

from app.robots.simulated.guard_log import GuardLog, GuardRow, read_guard_log


def test_rows_come_back_in_order_and_a_torn_one_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "guard.log"
    log = GuardLog(path, joints=2)
    rows = [GuardRow(float(i), 0.1 * i, -0.2 * i, (0.3 * i, -0.4), lateral_mps=0.01 * i) for i in range(500)]
    for row in rows:
        log.write(row)
    log.close(timeout_s=10.0)
    assert read_guard_log(path) == rows
    with path.open("ab") as file:
        file.write(b"torn")
    assert read_guard_log(path) == rows

"""The guard's log: what is written is read, a torn last row is left out."""

from __future__ import annotations

from pathlib import Path

from app.robots.simulated.guard_log import GuardLog, GuardLogReader, GuardRow, read_guard_log


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


def test_a_log_that_is_still_written_is_read_on(tmp_path: Path) -> None:
    """In pieces of any size, the header's and rows' among them."""
    whole = tmp_path / "whole.log"
    log = GuardLog(whole, joints=1)
    rows = [GuardRow(float(i), 0.1, 0.0, (0.5 * i,)) for i in range(20)]
    for row in rows:
        log.write(row)
    log.close(timeout_s=10.0)
    data = whole.read_bytes()
    path = tmp_path / "growing.log"
    path.touch()
    reader = GuardLogReader(path)
    sizes = []
    for begin in range(0, len(data), 3):
        with path.open("ab") as file:
            file.write(data[begin : begin + 3])
        read = reader.rows()
        sizes.append(len(read))
        assert read == rows[: len(read)]
    assert sizes[-1] == len(rows)
    assert sizes == sorted(sizes)


def test_a_log_that_was_begun_again_is_read_from_its_begin(tmp_path: Path) -> None:
    """Also where it has more rows by then than the one before."""
    path = tmp_path / "guard.log"
    reader = GuardLogReader(path)
    for first, count in ((0.0, 5), (100.0, 50)):
        log = GuardLog(path, joints=1)
        rows = [GuardRow(first + i, 0.1, 0.0, (0.5,)) for i in range(count)]
        for row in rows:
            log.write(row)
        log.close(timeout_s=10.0)
        assert reader.rows() == rows
        assert reader.rows() == rows

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from benchmarks.report import print_table, row, write_json


def test_a_row_of_paired_rounds_compares_round_by_round() -> None:
    # The computer was twice as slow in the last round, for both: the ratio does not notice.
    measured = row("b", "c", "CPU", "µs", [3.0, 3.0, 6.0], [2.0, 2.0, 4.0], "peer")
    assert (measured.ours, measured.peer, measured.ratio, measured.n) == (3.0, 2.0, 1.5, 3)


def test_unequal_samples_are_compared_by_their_medians() -> None:
    assert row("b", "c", "m", "s", [4.0, 4.0], [2.0, 1.0, 9.0]).ratio == 2.0
    assert row("b", "c", "m", "s", [4.0], [0.0, 0.0]).ratio is None
    assert row("b", "c", "m", "s", [4.0]).peer is None


def test_spread_is_the_interquartile_range_over_the_median() -> None:
    assert row("b", "c", "m", "s", [8.0, 9.0, 10.0, 11.0, 12.0]).spread == pytest.approx(0.2)
    assert row("b", "c", "m", "s", [5.0]).spread == 0.0
    assert row("b", "c", "m", "s", [0.0, 0.0]).spread == 0.0


def test_the_table_has_aligned_columns_and_plain_figures(tmp_path: Path) -> None:
    rows = [
        row("channels", "1->1", "rate", "1/s", [123456.0]),
        row("channels", "1->10", "CPU", "µs", [0.01234], [0.02]),
    ]
    out = io.StringIO()
    print_table(rows, out)
    machine, header, first, second = out.getvalue().splitlines()
    assert "cores" in machine
    assert "123,456" in first
    assert "0.0123" in second
    assert first.index("1/s") == second.index("µs") == header.index("unit")
    write_json(rows, tmp_path / "rows.json")
    read = json.loads((tmp_path / "rows.json").read_text())
    assert read["rows"][1]["ratio"] == pytest.approx(0.617)
    assert set(read["rows"][0]) == {
        "benchmark", "case", "metric", "unit", "ours", "peer", "peer_name", "ratio", "spread", "n"
    }  # fmt: skip

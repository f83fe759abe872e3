from __future__ import annotations

import json
from pathlib import Path

from benchmarks.document import document
from benchmarks.report import read_rows, row, write_json


def test_a_page_says_what_was_measured_on_what_and_how(tmp_path: Path) -> None:
    rows = [
        row("solver", "13 strategies", "cold", "ms", [0.5, 0.6], [5.0, 6.0], "CP-SAT | direct"),
        row("solver", "13 strategies", "cached", "ms", [0.005]),
    ]
    write_json(rows, tmp_path / "rows.json")
    content = json.loads((tmp_path / "rows.json").read_text(encoding="utf-8"))
    assert content["versions"]["numpy"][0].isdigit()
    page = document(read_rows(content))
    assert page == document(rows)
    assert page.count("## ") == 1
    assert "Strategy selection: how long a proven optimum takes" in page
    assert "| 13 strategies | cold | ms | 0.55 | 5.5 | CP-SAT \\| direct | 0.10 | 9 % | 2 |" in page
    assert "numpy " in page

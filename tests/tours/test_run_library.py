"""Reports on runs, and the run that is under way, on the disk; reports as a table."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import pytest

from app.messages import TourFailure
from app.tours import run_library
from app.tours.run_library import RunLibrary, UnknownRun
from app.tours.run_report import COLUMNS, RunReport, StopReport, table

REPORT = RunReport("20261123-080000-lab", "lab", {"en": "The lab"}, "en", began=1795000000.0)


def test_reports_are_kept_the_newest_first(tmp_path: Path) -> None:
    library = RunLibrary(tmp_path / "runs")
    assert library.reports() == ()
    later = replace(REPORT, run="20261124-080000-lab", stops=(StopReport("arm", 1.0, questions={"weight": 2}),))
    for report in (REPORT, later):
        library.add(report)
    assert library.reports() == (later, REPORT)
    assert library.report(REPORT.run) == REPORT
    library.add(replace(REPORT, outcome="changed"))
    assert library.report(REPORT.run).outcome == "changed"
    library.delete(REPORT.run)
    with pytest.raises(UnknownRun, match="no report on a run '20261123-080000-lab'"):
        library.report(REPORT.run)
    with pytest.raises(UnknownRun):
        library.delete(REPORT.run)


def test_a_report_is_listed_before_it_is_written(tmp_path: Path) -> None:
    library = RunLibrary(tmp_path)
    library.add(replace(REPORT, run="20261122-080000-lab"))
    library.expect(REPORT)
    assert [report.run for report in library.reports()] == [REPORT.run, "20261122-080000-lab"]
    assert library.report(REPORT.run) == REPORT
    library.add(REPORT)
    assert len(library.reports()) == len(list(tmp_path.iterdir())) == 2
    library.expect(later := replace(REPORT, run="20261124-080000-lab"))
    library.delete(later.run)
    assert later not in library.reports()


def test_the_oldest_are_deleted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_library, "MOST_REPORTS", 2)
    library = RunLibrary(tmp_path)
    for hour in range(4):
        library.add(replace(REPORT, run=f"20261123-0{hour}0000-lab"))
    assert [report.run[9:11] for report in library.reports()] == ["03", "02"]


def test_a_damaged_file_is_no_report(tmp_path: Path) -> None:
    library = RunLibrary(tmp_path)
    library.add(REPORT)
    (tmp_path / "20261125-000000-x.json").write_text("{")
    assert library.reports() == (REPORT,)


def test_the_run_under_way_is_for_the_next_program_if_that_resumes(tmp_path: Path) -> None:
    library = RunLibrary(tmp_path / "runs")
    assert library.kept() is None
    library.keep(b"run")
    assert library.kept() == b"run"
    assert library.reports() == ()
    other = RunLibrary(tmp_path / "runs", resumes=False)
    assert other.kept() is None
    other.keep(None)
    assert library.kept() == b"run", "another program leaves it alone"
    library.keep(None)
    library.keep(None)
    assert library.kept() is None


def test_a_table_has_a_line_for_each_stop() -> None:
    stops = (StopReport("arm", 1795000010.0, people=2, questions={"b": 1, "a": 2}), StopReport("leg", 1795000020.0))
    whole = replace(REPORT, stops=stops, outcome='said "no", and left', failures=(TourFailure("leg", "not reached"),))
    head, first, second, none = csv.reader(io.StringIO(table([whole, REPORT])))
    assert tuple(head) == COLUMNS
    arm, leg = (dict(zip(head, row, strict=True)) for row in (first, second))
    assert (arm["stop"], arm["people"], arm["questions"], arm["failures"]) == ("arm", "2", "a=2 b=1", "")
    assert (leg["stop"], leg["failures"], leg["outcome"]) == ("leg", "not reached", 'said "no", and left')
    assert dict(zip(head, none, strict=True))["stop"] == ""

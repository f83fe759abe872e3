"""``hbba check`` of certificates and recordings, and ``hbba solve --certificate``."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path

import pytest

from app import cli
from app.attention.intention import Intention
from app.attention.problem import SelectionProblem
from app.attention.proof.statement import TABLE_FILE, table_data
from app.attention.reports import intention_report
from app.attention.solver import solve
from app.commands import check_proofs
from app.logs.log import Logged
from app.logs.manifest import JSON, AttachedFile, Manifest
from app.messages import ChangedStrategy, IntentionReport
from app.runtime.channel_table import ChannelSpec
from tests.attention.thesis import CPU, TABLE_4_4, desire, problem
from tests.logs.mcap.mcap_files import write_log
from tests.patience import PATIENCE_S

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
PROBLEMS = [
    problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU),
    problem([desire("GoTo", 8), desire("LocateFaces", 2, 4)], TABLE_4_4, CPU, previous=["6", "11", "13"]),
    problem([desire("FindQRCodes", 1), desire("LocateFaces", 8, security=True)], TABLE_4_4, {"cpu": 60.0}, ["13"]),
]


def solved(*arguments: str) -> int:
    return cli.main(["solve", *arguments, "--time-limit", str(PATIENCE_S)])


@pytest.fixture
def file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """A certificate of the thesis's second example."""
    path = tmp_path / "certificate.json"
    assert solved(str(EXAMPLES / "thesis-4.3.3.yaml"), "--certificate", str(path)) == 0
    assert "Ω = 28" in capsys.readouterr().out
    return path


def test_a_certificate_is_checked(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", str(file)]) == 0
    assert capsys.readouterr().out == f"{file}: certificate, its selection is the best there is, Ω = 28\n"


def test_a_certificate_is_printed_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert solved(str(EXAMPLES / "thesis-4.3.3.yaml"), "--certificate", "-") == 0
    path = tmp_path / "printed.json"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    assert cli.main(["check", str(path)]) == 0


def test_a_certificate_for_another_problem_is_refused(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace('"capacities": {"cpu": 100000}', '"capacities": {"cpu": 110000}'), encoding="utf-8")
    assert cli.main(["check", str(file)]) == 2
    assert capsys.readouterr().err.startswith(f"{file}: this certificate proves nothing: ")


def test_a_certificate_that_cannot_be_written_is_a_mistake(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "missing" / "certificate.json"
    assert solved(str(EXAMPLES / "thesis-4.3.3.yaml"), "--certificate", str(missing)) == 2
    assert f"{missing} cannot be written" in capsys.readouterr().err


def test_there_is_no_certificate_beyond_its_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The answer is printed all the same."""
    classes = [{"name": f"s{n}", "class": "A", "utility": 1, "costs": {"cpu": 7}} for n in range(13)]
    stated = {
        "resources": {"cpu": {"capacity": 50}},
        "strategies": classes,
        "desires": [{"class": "A", "intensity": 8}],
    }
    monkeypatch.setattr("sys.stdin", io.StringIO(json.dumps(stated)))
    assert solved("-", "--certificate", str(tmp_path / "none.json")) == 1
    out, err = capsys.readouterr()
    assert "Ω = 15" in out
    assert err == "hbba solve: no certificate: class A has more than 4096 choices\n"
    assert not (tmp_path / "none.json").exists()


def report(p: SelectionProblem, stamp: float) -> IntentionReport:
    """As the translator publishes it."""
    selection = solve(p)
    chosen = tuple(s for s in p.strategies if s.name in selection.strategies)
    intention = Intention(stamp, selection, chosen, {}, {}, {}, p.desires, p.capacities, p.previous)
    return intention_report(intention, {})


def recording(path: Path, reports: list[IntentionReport], *, table: bool = True) -> Path:
    files = (AttachedFile(TABLE_FILE, JSON, table_data(PROBLEMS[0])),) if table else ()
    messages = [Logged(r.stamp, "intention", r) for r in reports]
    channels = {"intention": ChannelSpec(type="IntentionReport", external=True)}
    return write_log(path, messages, channels, Manifest(files, {"program": "lab.yaml"}))


def reports() -> list[IntentionReport]:
    """The first is published again, once its reasons are complete; the last is what hysteresis held back."""
    first, second, third = (report(p, 100.0 + at) for at, p in enumerate(PROBLEMS))
    return [first, first, second, third, replace(third, stamp=110.0, proven=False)]


def test_each_proven_selection_of_a_recording_is_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = recording(tmp_path / "a.mcap", reports())
    assert cli.main(["check", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}: recording, 3 of 3 proven selections are certified and checked\n"


def test_a_selection_under_measured_costs_is_checked_with_those(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The cheapest way got dear meanwhile, and another produces less: the recording says so."""
    first = PROBLEMS[0]
    name = solve(first).strategies[0]
    now = tuple(replace(s, costs={"cpu": 60.0}, utility=0.5) if s.name == name else s for s in first.strategies)
    measured = report(replace(first, strategies=now, prepared=None), 100.0)
    changed = (ChangedStrategy(name, 0.5, {"cpu": 60.0}),)
    path = recording(tmp_path / "a.mcap", [replace(measured, changed=changed)])
    assert cli.main(["check", str(path)]) == 0
    assert "1 of 1 proven selections are certified and checked" in capsys.readouterr().out
    path = recording(tmp_path / "b.mcap", [measured])
    assert cli.main(["check", str(path)]) == 2, "by what was declared it is another problem"
    capsys.readouterr()


def test_a_selection_that_is_not_the_best_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, _, second, *_ = reports()
    wrong = replace(second, strategies=second.strategies[:1], fulfilled=("LocateFaces",))
    path = recording(tmp_path / "a.mcap", [first, wrong])
    assert cli.main(["check", str(path)]) == 2
    err = capsys.readouterr().err
    assert "1 of 2 proven selections are not the best: that of 101.000 s: there is a better selection" in err


def test_an_omega_that_is_wrong_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = recording(tmp_path / "a.mcap", [replace(reports()[0], omega=29.0)])
    assert cli.main(["check", str(path)]) == 2
    assert "its Ω is 28, not 29" in capsys.readouterr().err


def test_what_an_older_program_recorded_is_not_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = [replace(r, asked={}) for r in reports()]
    path = recording(tmp_path / "a.mcap", old)
    assert cli.main(["check", str(path)]) == 0
    out, err = capsys.readouterr()
    assert "0 of 3 proven selections are certified and checked, 1 warning" in out
    assert "an older program recorded it" in err
    path = recording(tmp_path / "b.mcap", reports(), table=False)
    assert cli.main(["check", str(path)]) == 0
    assert "carries no table of strategies" in capsys.readouterr().err


def test_no_recording_and_no_certificate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(b"no recording")
    assert cli.main(["check", str(path)]) == 2
    assert str(path) in capsys.readouterr().err
    assert check_proofs.check_proofs(EXAMPLES / "thesis-4.3.3.yaml") is None

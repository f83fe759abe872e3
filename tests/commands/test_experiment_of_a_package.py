"""An experiment of a package is run by its name; one that cannot be used says why."""

from __future__ import annotations

from pathlib import Path

import pytest

from app import cli
from app.commands.doctor import packages
from tests.distributions import install

SOURCE = """\
def add_parser(experiments):
    parser = experiments.add_parser("drift", help="where the wind blows it")
    parser.add_argument("--knots", type=int, default=3)


def run(args):
    print(f"it drifted {args.knots} kn")
    return 0
"""


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the import path."""
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def test_it_runs_with_its_arguments(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(site, "hbba-wind", {"wind_a.py": SOURCE}, experiments={"drift": "wind_a"})
    assert cli.main(["experiment", "drift", "--knots", "7"]) == 0
    assert capsys.readouterr().out == "it drifted 7 kn\n"
    with pytest.raises(SystemExit):
        cli.main(["experiment", "--help"])
    assert "where the wind blows it" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "source", "said"),
    [
        ("wind_b", "import no_such_wind\n", "wind_b cannot be imported: "),
        ("wind_c", "", "wind_c of hbba-wind has no add_parser and run"),
        ("wind_d", SOURCE.replace('"drift"', '"drive"'), "add_parser of wind_d declares no experiment 'drift'"),
    ],
)
def test_one_that_cannot_be_used_says_why_and_leaves_the_others_alone(
    site: Path, name: str, source: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    install(site, "hbba-wind", {f"{name}.py": source}, experiments={"drift": name})
    assert cli.main(["experiment", "drift"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    with pytest.raises(SystemExit) as left:
        cli.main(["experiment", "trial", "--help"])
    assert left.value.code == 0


def test_the_doctor_lists_packages_and_names_one_that_is_broken(site: Path) -> None:
    install(site, "hbba-wind", {"wind_e.py": SOURCE}, experiments={"drift": "wind_e"})
    finding = packages()
    assert finding.ok
    assert finding.found == "experiments: drift (hbba-wind)"
    install(site, "hbba-tide", {"tide_e.py": SOURCE}, experiments={"ebb": "tide_e"}, messages={"tide": "tide_e"})
    finding = packages()
    assert finding.ok
    assert finding.found == "experiments: drift (hbba-wind), ebb (hbba-tide); messages: tide (hbba-tide)"
    install(site, "hbba-storm", {"storm_e.py": "1 / 0\n"}, panels={"storm": "storm_e:PANEL"})
    finding = packages()
    assert not finding.ok
    assert not finding.required
    assert "'storm' of hbba.panels, from hbba-storm: storm_e cannot be imported: " in finding.found

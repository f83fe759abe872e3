"""``hbba experiment``: mistakes are one sentence, and scenarios are named as for ``hbba run``."""

from __future__ import annotations

import pytest

from app import cli


@pytest.mark.parametrize("which", ["trial", "overload"])
@pytest.mark.parametrize(
    ("scenario", "words"),
    [
        ("none", "--scenario: an experiment needs a scenario that drives"),
        ("trail", "--scenario: there is no scenario trail; a file, none, or one of: lab, trial"),
    ],
)
def test_a_scenario_that_does_not_drive_is_refused(
    which: str, scenario: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["experiment", which, "--scenario", scenario]) == 2
    assert words in capsys.readouterr().err

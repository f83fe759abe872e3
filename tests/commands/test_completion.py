"""``hbba completion``: a script for each shell, and what bash makes of its own."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from app import cli
from app.commands import COMMANDS
from app.commands.completion import SHELLS
from tests.patience import PATIENCE_S

#: Completes its arguments as bash does when the last word is followed by a tab.
_TAB = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(( $# - 1 )); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}
function=$(complete -p hbba | sed 's/.*-F \\([^ ]*\\).*/\\1/')
$function hbba "${@: -1}" "${@: -2:1}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.mark.parametrize("shell", SHELLS)
def test_each_shell_completes_every_command(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert {name for name in COMMANDS if name not in script} == set()
    assert "SCENARIOS" not in script


@pytest.fixture
def script(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """The script for bash."""
    assert cli.main(["completion", "bash"]) == 0
    file = tmp_path / "hbba.bash"
    file.write_text(capsys.readouterr().out)
    return file


@pytest.mark.parametrize(
    ("line", "completed"),
    [
        ("sol", {"solve"}),
        ("log re", {"repair", "rerun"}),
        ("replay t", {"talk", "tour", "tape.bag"}),
        ("log info to", {"tour"}),
        ("log export tour p", {"png", "pcd"}),
        ("run --scenario wal", {"walkers"}),
        ("replay tour --headl", {"--headless"}),
        ("completion f", {"fish"}),
    ],
)
def test_commands_options_and_names_are_completed(
    line: str, completed: set[str], script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recordings, here = tmp_path / "my recordings", tmp_path / "here"
    recordings.mkdir()
    here.mkdir()
    for name in ("tour.mcap", "talk.mcap", "walk.mcap"):
        (recordings / name).touch()
    (here / "tape.bag").touch()
    monkeypatch.setenv("HBBA_RECORDINGS", str(recordings))
    words = ["bash", "--norc", "-c", _TAB, "bash", str(script), "hbba", *line.split()]
    done = subprocess.run(words, cwd=here, capture_output=True, text=True, timeout=PATIENCE_S, check=True)
    assert set(done.stdout.split()) == completed


def test_another_shell_is_refused_with_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main(["completion", "bahs"])
    assert left.value.code == 2
    assert "invalid choice: 'bahs'; did you mean bash? (choose from bash, zsh, fish)" in capsys.readouterr().err

"""A command beside others: what it prints is shown as it comes, and one that hangs says where."""

from __future__ import annotations

import io
import sys
import time
from pathlib import Path
from types import ModuleType

import pytest

HANGS = """
import faulthandler, subprocess, sys, threading
from pathlib import Path

def where_it_hangs(name):
    (Path(__file__).parent / name).touch()
    threading.Event().wait()

faulthandler.enable()
if len(sys.argv) > 1:
    where_it_hangs("child")
child = subprocess.Popen([sys.executable, __file__, "child"])
print("the child is", child.pid, flush=True)
where_it_hangs("parent")
"""


def has_ended(process: int) -> bool:
    """Whether the process is gone, or waits only for its status to be taken."""
    try:
        stat = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
    except FileNotFoundError:
        return True
    return stat.rpartition(")")[2].split()[0] == "Z"


def script(folder: Path, text: str) -> list[object]:
    path = folder / "script.py"
    path.write_text(text, encoding="utf-8")
    return [sys.executable, path]


@pytest.mark.parametrize("status", [0, 3])
def test_output_and_status_are_those_of_the_command(alongside: ModuleType, tmp_path: Path, status: int) -> None:
    command = script(tmp_path, f"import sys; print('höre'); print('trouble', file=sys.stderr); sys.exit({status})")
    to = io.StringIO()
    with alongside.alongside(command) as started:
        assert started.show(to=to, period=0.01) == status
        assert started.took_s() > 0
    assert sorted(to.getvalue().split()) == ["höre", "trouble"]


def test_output_is_shown_while_the_command_goes_on(alongside: ModuleType, tmp_path: Path) -> None:
    """The command ends only when what it printed has been seen."""
    flag = tmp_path / "seen"

    class Watching(io.StringIO):
        def write(self, text: str) -> int:
            if "first" in text:
                flag.touch()
            return super().write(text)

    command = script(
        tmp_path,
        f"import pathlib, time\nprint('first', flush=True)\n"
        f"while not pathlib.Path({str(flag)!r}).exists(): time.sleep(0.01)\nprint('last')",
    )
    to = Watching()
    with alongside.alongside(command) as started:
        assert started.show(to=to, period=0.01) == 0
    assert to.getvalue().split() == ["first", "last"]


def test_a_command_that_hangs_says_where_and_all_its_group_ends(alongside: ModuleType, tmp_path: Path) -> None:
    to = io.StringIO()
    with alongside.alongside(script(tmp_path, HANGS)) as started:
        while not ((tmp_path / "parent").exists() and (tmp_path / "child").exists()):
            time.sleep(0.01)
        assert started.show(to=to, silent_after=0.2, period=0.01) != 0
    text = to.getvalue()
    assert "no output for" in text
    assert text.count("in where_it_hangs") == 2
    assert has_ended(int(text.split("the child is")[1].split()[0]))


def test_what_still_runs_at_the_end_is_ended(alongside: ModuleType, tmp_path: Path) -> None:
    with alongside.alongside(script(tmp_path, "import time\nwhile True: time.sleep(0.1)")) as started:
        assert started.running()
    assert not started.running()

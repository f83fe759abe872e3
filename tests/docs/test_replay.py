"""The example in docs/replay.md does what it says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.logs.replay.logs import lab_manifest, lab_messages, write_log

PAGE = Path(__file__).parents[2] / "docs" / "replay.md"


@pytest.mark.blocking(reason="the virtual loop waits for threads by design")
def test_the_example_prints_what_the_detector_cost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_log(tmp_path / "walk.mcap", lab_messages(2.0), lab_manifest())
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    names: dict[str, object] = {}
    exec(compile(example, str(PAGE), "exec"), names)
    cpu_s, taken, codes = capsys.readouterr().out.split()
    assert float(cpu_s) > 0
    assert int(taken) == int(codes) == 5
    names["log"].close()  # type: ignore[attr-defined]

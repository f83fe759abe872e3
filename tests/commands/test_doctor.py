"""``hbba doctor``: what it finds and what it says to do."""

from __future__ import annotations

import json
import socket
import sys
import types
from pathlib import Path

import pytest

from app import cli
from app.base import paths
from app.commands import doctor
from app.commands.doctor import Finding


def test_every_failure_of_something_required_says_what_to_do(capsys: pytest.CaptureFixture[str]) -> None:
    code = cli.main(["doctor", "--json"])
    findings = [Finding(**entry) for entry in json.loads(capsys.readouterr().out)]
    assert code == int(any(finding.required and not finding.ok for finding in findings))
    assert {"Python", "configuration", "EGL", "port", "cores", "cameras", "microphones", "spoken text"} <= {
        f.name for f in findings
    }
    assert all(finding.remedy for finding in findings if not finding.ok)


def test_a_taken_port_is_found() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        finding = doctor.port_free("127.0.0.1", port)
    assert not finding.ok
    assert finding.required
    assert f"--port {port + 1}" in finding.remedy
    assert doctor.port_free("127.0.0.1", port).ok


@pytest.mark.parametrize(
    ("quota", "cores"),
    [("max 100000", 8.0), ("150000 100000", 1.5), ("3200000 100000", 8.0), ("nonsense", 8.0), (None, 8.0)],
)
def test_a_containers_quota_counts_as_cores(quota: str | None, cores: float, tmp_path: Path) -> None:
    file = tmp_path / "cpu.max"
    if quota is not None:
        file.write_text(quota, encoding="ascii")
    assert doctor.available_cores(8, file) == cores


def test_a_broken_configuration_is_found_with_its_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "lab.yaml").write_text("robot: nowhere.yaml\nmodules: 3\n", encoding="utf-8")
    monkeypatch.setattr(paths, "config_dir", lambda: tmp_path)
    finding = doctor.configuration()
    assert not finding.ok
    assert f"{tmp_path}/lab.yaml:" in finding.found


def test_no_egl_library_says_which_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.robots.simulated.gl.ctypes.CDLL", _missing)
    finding = doctor.graphics()
    assert not finding.ok
    assert finding.required
    assert "libegl1" in finding.remedy


def test_the_inputs_that_can_be_named_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    devices = [{"name": "HDMI", "max_input_channels": 0}, {"name": "USB array", "max_input_channels": 8}]
    library = types.SimpleNamespace(query_devices=lambda: devices)
    monkeypatch.setitem(sys.modules, "sounddevice", library)
    assert doctor.audio() == Finding("microphones", True, False, "USB array (8 ch)", doctor.audio().remedy)
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    assert "hbba[devices]" in doctor.audio().found
    assert not doctor.audio().ok


def _missing(name: str) -> None:
    raise OSError(f"{name}: cannot open shared object file")


def test_the_networks_that_see_faces_and_judge_voices_are_found_or_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert doctor.face_model().ok
    assert doctor.voice_network().ok
    monkeypatch.setattr("app.modules.perception.faces.yunet.MODEL", Path("/no/such/model.onnx"))
    missed = doctor.face_model()
    assert (missed.ok, missed.required) == (False, False)
    assert "/no/such/model.onnx" in missed.found
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    missed = doctor.voice_network()
    assert (missed.ok, missed.required) == (False, False)
    assert "onnxruntime" in missed.remedy


def test_kernels_that_are_not_compiled_yet_are_no_obstacle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.base.compiled.is_ready", lambda: False)
    finding = doctor.kernels()
    assert (finding.ok, finding.required) == (False, False)
    assert "hbba run" in finding.remedy
    monkeypatch.setattr("app.base.compiled.is_ready", lambda: True)
    assert doctor.kernels().ok


def test_the_browser_can_be_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HBBA_CHROMIUM", "/opt/chrome")
    assert doctor.find_chromium() == "/opt/chrome"
    monkeypatch.delenv("HBBA_CHROMIUM")
    monkeypatch.setenv("PATH", "")
    assert doctor.find_chromium() is None
    assert not doctor.chromium().required


def test_the_table_marks_what_stops_a_run_and_what_does_not() -> None:
    shown = doctor.table(
        [
            Finding("port", ok=True, required=True, found="8080 is free"),
            Finding("EGL", ok=False, required=True, found="no library", remedy="install it"),
            Finding("cameras", ok=False, required=False, found="none", remedy="only for a real robot"),
        ]
    )
    assert [line.split()[0] for line in shown.splitlines() if line.strip()] == ["✓", "✗", "→", "–", "→", "`hbba"]
    assert shown.endswith("`hbba run` will not work yet: EGL.")

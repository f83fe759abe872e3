from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from app.cli import main
from tests.patience import PATIENCE_S

#: What rosidl takes for the name of a field.
FIELD = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")


@pytest.mark.timeout(PATIENCE_S)
def test_the_package_is_one_that_ros_2_builds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "src" / "hbba_msgs"
    assert main(["ros", "package", str(folder)]) == 0
    cmake = (folder / "CMakeLists.txt").read_text("utf-8")
    manifest = ElementTree.parse(folder / "package.xml").getroot()
    depends = {each.text for each in manifest.findall("depend")}
    files = {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in folder.glob("*/*.*")}
    assert {"msg/Desires.msg", "msg/IntentionReport.msg", "msg/Localization.msg", "srv/AddDesire.srv"} <= set(files)
    for name, text in files.items():
        assert f'  "{name}"\n' in cmake
        for line in text.splitlines():
            if line != "---":
                kind, field = line.split()
                assert FIELD.fullmatch(field), (name, line)
                package, _, message = kind.split("[")[0].rpartition("/")
                assert not package or package in depends or f"msg/{message}.msg" in files, (name, line)
        if importlib.util.find_spec("rosidl_adapter") is not None:
            from rosidl_adapter.parser import parse_message_string, parse_service_string

            parse = parse_service_string if name.startswith("srv/") else parse_message_string
            parse("hbba_msgs", Path(name).stem, text)
    assert main(["ros", "package", str(folder)]) == 2
    assert "is there already" in capsys.readouterr().err

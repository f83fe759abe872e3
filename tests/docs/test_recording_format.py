"""docs/recording-format.md: its topics are those that are written, its definition the real one, its code runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from app.logs.ros import typestore
from app.logs.ros.camera_converter import FisheyeImageInfo
from app.logs.ros.converters import CONVERTERS, Options, converter
from app.logs.ros.generated import generated
from app.logs.ros.record import MAIN, Converter
from app.messages import Image, QRCodes
from tests.logs.mcap.mcap_files import drive, write_log

PAGE = (Path(__file__).parents[2] / "docs" / "recording-format.md").read_text("utf-8")


def table() -> dict[str, dict[str, tuple[list[str], bool]]]:
    """Topics by message class: the ROS types it may have, and whether it is the main one."""
    rows: dict[str, dict[str, tuple[list[str], bool]]] = {}
    of = ""
    for line in PAGE[PAGE.index("| message | topics") :].splitlines()[2:]:
        if not line.startswith("|"):
            break
        first, topic, kind, _ = (cell.strip() for cell in line.strip("|").split("|"))
        of = first or of
        for name in of.split(", "):
            path = re.findall(r"`([^`]+)`", topic)[0].replace("<ch>", "ch")
            rows.setdefault(name, {})[path] = (re.findall(r"`([^`]+)`", kind), "**main**" in topic)
    return rows


def topics(of: Converter) -> dict[str, tuple[str, bool]]:
    """Each topic's type as the page writes it, and whether it is the main one."""
    return {topic.name: (topic.type.replace("/msg/", "/"), topic.part == MAIN) for topic in of.topics}


@pytest.mark.parametrize("cls", list(CONVERTERS), ids=lambda cls: cls.__name__)
def test_the_table_of_topics_is_what_is_written(cls: type[object]) -> None:
    shown = table()[cls.__name__]
    assert {path: (kinds[0], main) for path, (kinds, main) in shown.items()} == topics(converter("ch", cls))


def test_a_fisheyes_main_topic_has_its_own_type() -> None:
    written = topics(converter("ch", Image, Options(main_type=generated(FisheyeImageInfo).type)))
    assert {path: (kinds[-1], main) for path, (kinds, main) in table()["Image"].items()} == written
    assert written["/ch/info"] != topics(converter("ch", Image))["/ch/info"]


def test_the_definition_shown_is_the_real_one() -> None:
    (shown,) = re.findall(r"```text\n(.*?)```", PAGE, flags=re.DOTALL)
    assert shown == typestore.definition(converter("ch", QRCodes).topics[0].type)


def test_the_code_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    write_log(tmp_path / "recording.mcap", drive(1.5))
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    printed = []
    for block in blocks:
        exec(compile(block, "recording-format.md", "exec"), {})
        printed.append(len(capsys.readouterr().out.splitlines()))
    assert printed == [150, 1 + 7]

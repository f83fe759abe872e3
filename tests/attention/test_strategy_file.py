"""Strategy files: what they mean, and every mistake with file and line."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from app.attention.strategies import exclusive, trimmed
from app.attention.strategy_file import load_strategies
from app.base.errors import ConfigError

CLASSES = ("FindQRCodes", "GoTo", "SLAM")
PORTS = {"QRCodeDetector": ("images", "codes"), "PlanAndFollowPath": ("scans", "twist"), "SLAM2D": ("scans",)}
GOOD = """\
resources:
  cpu: {capacity: 100, unit: "% of one core", description: The computer}
strategies:
  - name: find-qr-codes-1
    class: FindQRCodes
    utility: 8
    filters: {QRCodeDetector.images: 1}
    parameters: {QRCodeDetector: {upscale: true}}
    costs: {cpu: 80}
  - name: find-qr-codes-2
    class: FindQRCodes
    utility: 4
    filters: {QRCodeDetector.images: 2, QRCodeDetector.codes: off}
    costs: {cpu: 40.5}
  - name: go-to
    class: GoTo
    utility: 8
    requires: {SLAM: 1}
    filters: {PlanAndFollowPath.twist: 1, PlanAndFollowPath.scans: .inf}
    costs: {cpu: 0}
"""


def load(tmp_path: Path, *texts: str):  # type: ignore[no-untyped-def]
    paths = []
    for number, text in enumerate(texts):
        path = tmp_path / f"{number}.yaml"
        path.write_text(text)
        paths.append(path)
    return load_strategies(paths, classes=CLASSES, ports=PORTS)


def test_a_good_file(tmp_path: Path) -> None:
    table = load(tmp_path, GOOD)
    first, second, goto = table.strategies
    assert (first.cls, first.utility, first.costs, first.parameters) == (
        "FindQRCodes",
        8,
        {"cpu": 80},
        {"QRCodeDetector": {"upscale": True}},
    )
    assert second.filters == {"QRCodeDetector.images": 2, "QRCodeDetector.codes": math.inf}
    assert (goto.requires, goto.costs) == ({"SLAM": 1}, {})
    assert goto.filters["PlanAndFollowPath.scans"] == math.inf
    assert str(second.location) == f"{tmp_path / '0.yaml'}:10"
    assert table["go-to"] is goto
    assert table.classes == ("FindQRCodes", "GoTo")
    assert table.capacities() == {"cpu": 100}
    assert goto.modules == ("PlanAndFollowPath",)
    assert table.filters == {f"QRCodeDetector.{p}" for p in ("images", "codes")} | {
        "PlanAndFollowPath.twist",
        "PlanAndFollowPath.scans",
    }
    assert exclusive(first, second)
    assert not exclusive(first, goto)


def test_several_files_make_one_table(tmp_path: Path) -> None:
    more = "strategies:\n  - {name: slam, class: SLAM, utility: 8, filters: {SLAM2D.scans: 40}, costs: {cpu: 20}}\n"
    table = load(tmp_path, GOOD, more)
    assert [s.name for s in table.strategies] == ["find-qr-codes-1", "find-qr-codes-2", "go-to", "slam"]
    load(tmp_path, GOOD, "resources:\n  cpu: {capacity: 100}\n")


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        (
            "class: GoTo",
            "class: Goto",
            16,
            "unknown class 'Goto'; did you mean 'GoTo'? allowed: FindQRCodes, GoTo, SLAM",
        ),
        ("{SLAM: 1}", "{Slam: 1}", 18, "requires unknown class 'Slam'"),
        ("{SLAM: 1}", "{GoTo: 1}", 18, "requires its own class"),
        ("{SLAM: 1}", "{SLAM: 9}", 18, "less than or equal to 8, not 9"),
        ("{QRCodeDetector.images: 1}", "{QRDetector.images: 1}", 7, "unknown module 'QRDetector'"),
        ("{QRCodeDetector.images: 1}", "{QRCodeDetector.image: 1}", 7, "unknown port 'image' of QRCodeDetector"),
        ("{QRCodeDetector.images: 1}", "{images: 1}", 7, "named Module.port"),
        ("{QRCodeDetector.images: 1}", "{QRCodeDetector.images: 0}", 7, "integer of at least 1, or off"),
        ("{QRCodeDetector.images: 1}", "{QRCodeDetector.images: 1.5}", 7, "integer of at least 1, or off"),
        ("{QRCodeDetector: {upscale", "{QRDetector: {upscale", 8, "parameters of unknown module 'QRDetector'"),
        ("costs: {cpu: 80}", "costs: {gpu: 80}", 9, "unknown resource 'gpu'"),
        ("costs: {cpu: 80}", "costs: {cpu: -1}", 9, "greater than or equal to 0"),
        ("costs: {cpu: 80}", "costs: {cpu: 0.0001}", 9, "at most 3 decimals"),
        ("costs: {cpu: 80}", "costs: {cpu: .inf}", 9, "finite number"),
        ("utility: 4", "utility: 0", 12, "greater than 0, not 0"),
        ("utility: 4", "utility: 8.5", 12, "less than or equal to 8"),
        ("utility: 4", "utility: fast", 12, "'fast'"),
        ("utility: 4", "utilty: 4", 12, "did you mean 'utility'"),
        ("name: find-qr-codes-2", "name: find-qr-codes-1", 10, "already declared at"),
        ("capacity: 100", "capacity: -1", 2, "greater than or equal to 0"),
    ],
)
def test_mistakes_name_file_and_line(tmp_path: Path, old: str, new: str, line: int, words: str) -> None:
    assert old in GOOD
    with pytest.raises(ConfigError) as caught:
        load(tmp_path, GOOD.replace(old, new))
    assert words in caught.value.message
    assert (caught.value.file, caught.value.line) == (str(tmp_path / "0.yaml"), line)


def test_files_that_disagree(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="capacity 50 here and 100 elsewhere") as caught:
        load(tmp_path, GOOD, "resources:\n  cpu: {capacity: 50}\n")
    assert caught.value.file == str(tmp_path / "1.yaml")


def test_ports_are_checked_only_where_known(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(GOOD)
    assert len(load_strategies([path], classes=CLASSES, ports=None).strategies) == 3


def test_the_whole_program_keeps_its_table(tmp_path: Path) -> None:
    table = load(tmp_path, GOOD)
    assert trimmed(table, PORTS) == table


def test_what_may_not_be_decimated_is_opened_or_closed(tmp_path: Path) -> None:
    path = tmp_path / "sound.yaml"
    text = "strategies:\n  - {name: hear, class: SLAM, utility: 8, filters: {SLAM2D.scans: %s}}\n"
    for allowed in ("1", "off"):
        path.write_text(text % allowed)
        load_strategies([path], classes=CLASSES, ports=PORTS, undivided={"SLAM2D.scans"})
    path.write_text(text % "2")
    with pytest.raises(ConfigError, match=r"sound\.yaml:2.*may not be decimated: 1 or off"):
        load_strategies([path], classes=CLASSES, ports=PORTS, undivided={"SLAM2D.scans"})

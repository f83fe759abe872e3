"""Bodies of packages: their kind is found by entry point; what cannot be used is one sentence with file and line."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.commands.check import check_file
from app.robots.config import BodyConfig
from app.robots.devices.config import DevicesConfig
from app.robots.factory import create_link, load_body, standing_streams
from tests.distributions import install

SOURCE = """\
from app.robots.config import BodyConfig, load_body_config
from app.robots.factory import BodyKind


class BalloonConfig(BodyConfig):
    volume_m3: float = 3.0


BALLOON = BodyKind(lambda path: load_body_config(path, BalloonConfig), lambda body, offset: "a link")
"""


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the import path."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    return folder


def body_file(tmp_path: Path, kind: str) -> Path:
    model = paths.config_dir() / "robots" / "desk.urdf"
    path = tmp_path / "body.yaml"
    path.write_text(f"name: Montgolfiere\nmodel: {model}\nkind: {kind}\nvolume_m3: 4\n", "utf-8")
    return path


def test_a_package_brings_a_body(site: Path, tmp_path: Path) -> None:
    install(site, "hbba-balloons", {"balloons_a.py": SOURCE}, bodies={"balloon": "balloons_a:BALLOON"})
    path = body_file(tmp_path, "balloon")
    body = load_body(path)
    assert isinstance(body, BodyConfig)
    assert body.model_dump()["volume_m3"] == 4.0
    assert body.files == (paths.config_dir() / "robots" / "desk.urdf",)
    assert {name: stream.rate_hz for name, stream in standing_streams(body).items()} == {
        "odometry": 100, "joints": 30, "status": 20,
    }  # fmt: skip
    assert str(create_link(body, 0.0)) == "a link"
    assert check_file(path) == ("robot", ())


def test_a_mistake_in_a_packages_body_has_file_and_line(site: Path, tmp_path: Path) -> None:
    install(site, "hbba-balloons", {"balloons_b.py": SOURCE}, bodies={"balloon": "balloons_b:BALLOON"})
    path = body_file(tmp_path, "balloon")
    path.write_text(path.read_text("utf-8").replace("volume_m3: 4", "volume_m3: much"), "utf-8")
    with pytest.raises(ConfigError) as refused:
        load_body(path)
    assert (refused.value.file, refused.value.line, refused.value.key) == (str(path), 4, "volume_m3")


def test_an_unknown_kind_names_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no kind of body 'simulate'; did you mean 'simulated'\?") as refused:
        load_body(body_file(tmp_path, "simulate"))
    assert refused.value.line == 3
    assert refused.value.message.endswith(", and those of a package once it is installed")


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("1 / 0\n", "'balloon' of hbba.bodies, from hbba-balloons: balloons_c cannot be imported: "),
        ("BALLOON = 3\n", "balloons_c:BALLOON of hbba-balloons is no BodyKind"),
    ],
)
def test_a_body_that_cannot_be_used_is_one_sentence(
    site: Path, tmp_path: Path, source: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(__import__("sys").modules, "balloons_c", raising=False)
    install(site, "hbba-balloons", {"balloons_c.py": source}, bodies={"balloon": "balloons_c:BALLOON"})
    with pytest.raises(ConfigError) as refused:
        load_body(body_file(tmp_path, "balloon"))
    assert refused.value.line == 3
    assert said in refused.value.message
    assert "\n" not in str(refused.value)


def test_our_own_kinds_come_by_the_same_door() -> None:
    assert isinstance(load_body(paths.config_dir() / "robots" / "webcam.yaml"), DevicesConfig)
    assert load_body(paths.config_dir() / "robots" / "jackal.yaml").kind == "simulated"

"""What packages of others bring, and what is said of those that cannot be used."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.base.extensions import (
    GROUPS,
    announced_configuration,
    announced_configurations,
    announced_names,
    announced_packages,
    extensions,
    load_named,
    may_be_imported_for_a_log,
    package_file,
)
from app.commands.packaged import config_names
from tests.distributions import install


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the import path."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    return folder


def test_an_entry_point_is_found_by_group_and_name(site: Path) -> None:
    install(site, "hbba-kites", {"kites/__init__.py": "KITE = 3\n"}, panels={"kite": "kites:KITE"})
    found = extensions("hbba.panels")["kite"]
    assert (found.distribution, found.load()) == ("hbba-kites", 3)
    assert "kite" not in extensions("hbba.bodies")
    assert "kites" in announced_packages()


def test_a_checkouts_own_entry_points_are_those_of_its_project_file() -> None:
    root = paths.checkout_dir()
    assert root is not None
    declared = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"].get("entry-points", {})
    assert declared.keys() <= GROUPS.keys()
    for group in GROUPS:
        own = {name: e.value for name, e in extensions(group).items() if e.distribution == "hbba"}
        assert own == declared.get(group, {})


def test_metadata_older_than_a_checkout_is_passed_over_and_from_a_wheel_it_counts(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(site, "hbba", {}, panels={"of-old": "app.nowhere:PANEL"})
    assert "of-old" not in extensions("hbba.panels")
    monkeypatch.setattr(paths, "checkout_dir", lambda: None)
    assert extensions("hbba.panels")["of-old"].distribution == "hbba"


def test_two_packages_with_one_name_are_refused(site: Path) -> None:
    for name in ("hbba-kites", "hbba-balloons"):
        install(site, name, {}, bodies={"flyer": f"{name[5:]}:FLYER"})
    with pytest.raises(ConfigError, match=r"two packages bring 'flyer' of hbba\.bodies: hbba-\w+ and hbba-\w+; uninst"):
        extensions("hbba.bodies")


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("import no_such_library\n", "kites_x/__init__.py:1: ModuleNotFoundError: No module named 'no_such_library'"),
        ("x = 1\nx / 0\n", "kites_x/__init__.py:2: ZeroDivisionError: division by zero"),
        ("def broken(:\n", "kites_x/__init__.py:1: invalid syntax"),
    ],
)
@pytest.mark.parametrize("value", ["kites_x:KITE", "kites_x"])
def test_a_package_that_cannot_be_imported_is_one_sentence(site: Path, source: str, said: str, value: str) -> None:
    install(site, "hbba-kites", {"kites_x/__init__.py": source}, panels={"kite": value})
    with pytest.raises(ConfigError) as refused:
        extensions("hbba.panels")["kite"].load()
    sentence = str(refused.value)
    assert sentence.startswith("'kite' of hbba.panels, from hbba-kites: kites_x cannot be imported: ")
    assert said in sentence
    assert "\n" not in sentence


def test_an_object_that_is_not_there_is_said(site: Path) -> None:
    install(site, "hbba-kites", {"kites_y/__init__.py": ""}, panels={"kite": "kites_y:KITE"})
    with pytest.raises(ConfigError, match="from hbba-kites: there is no kites_y:KITE"):
        extensions("hbba.panels")["kite"].load()
    assert load_named("kites_y:KITE") is None
    assert load_named("kites_y") is None


def test_a_log_imports_only_what_announces_itself(site: Path) -> None:
    install(site, "hbba-kites", {"kites_z/__init__.py": ""}, messages={"kites_z": "kites_z"})
    install(site, "balloons", {"balloons_z/__init__.py": ""})
    assert may_be_imported_for_a_log("kites_z.messages:Kite")
    assert not may_be_imported_for_a_log("balloons_z:Balloon")
    assert may_be_imported_for_a_log(f"{__name__}:Kite")


def test_a_file_of_a_package_is_found_without_importing_it(site: Path, tmp_path: Path) -> None:
    install(site, "hbba-kites", {"kites_f/__init__.py": "1 / 0\n", "kites_f/conf/a.yaml": "{}"})
    assert package_file("package:kites_f/conf/a.yaml", tmp_path) == site / "kites_f" / "conf" / "a.yaml"
    assert package_file("package:hbba/channels.yaml", tmp_path) == paths.config_dir() / "channels.yaml"
    assert package_file("conf/a.yaml", tmp_path) == tmp_path / "conf" / "a.yaml"
    attached = tmp_path / "_packages" / "kites_f" / "conf" / "a.yaml"
    attached.parent.mkdir(parents=True)
    attached.write_text("{}", "utf-8")
    assert package_file("package:kites_f/conf/a.yaml", tmp_path) == attached
    with pytest.raises(ConfigError, match="there is no package 'zeppelins' installed"):
        package_file("package:zeppelins/a.yaml", tmp_path)


def test_a_package_announces_configurations(site: Path) -> None:
    install(
        site, "hbba-kites", {"kites_c/__init__.py": "", "kites_c/conf/kite.yaml": "{}"},
        configurations={"kite": "kites_c.conf"},
    )  # fmt: skip
    assert announced_configurations()["kite"] == site / "kites_c" / "conf" / "kite.yaml"


def test_a_configuration_that_is_not_there_is_said(site: Path) -> None:
    install(site, "hbba-kites", {"kites_n/__init__.py": ""}, configurations={"kite": "kites_n"})
    with pytest.raises(ConfigError, match="configuration 'kite', from hbba-kites: there is no file"):
        announced_configurations()


def test_a_package_whose_folder_is_gone_leaves_the_others_alone(site: Path) -> None:
    install(site, "hbba-gone", {"readme": ""}, configurations={"gone": "gone_away"})
    install(
        site, "hbba-kites", {"kites_w/__init__.py": "", "kites_w/kite.yaml": "{}"}, configurations={"kite": "kites_w"}
    )
    assert announced_configuration("kite") == site / "kites_w" / "kite.yaml"
    assert announced_configuration("dragon") is None
    assert {"gone", "kite"} <= set(announced_names())
    assert "kite" in config_names("program")
    with pytest.raises(ConfigError, match="no package 'gone_away' installed; install hbba-gone again, or uninstall it"):
        announced_configuration("gone")

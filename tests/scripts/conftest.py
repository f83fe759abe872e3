"""The set-up scripts as modules; they are no package, as they run before anything is installed."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

SCRIPTS = Path(__file__).resolve().parent.parent.parent / "scripts"


def _load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, SCRIPTS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up, and dev imports the others
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def page() -> Iterator[ModuleType]:
    yield _load("page")
    del sys.modules["page"]


@pytest.fixture(scope="session")
def installing() -> Iterator[ModuleType]:
    yield _load("installing")
    del sys.modules["installing"]


@pytest.fixture(scope="session")
def locking(installing: ModuleType) -> Iterator[ModuleType]:
    yield _load("locking")
    del sys.modules["locking"]


@pytest.fixture(scope="session")
def alongside() -> Iterator[ModuleType]:
    yield _load("alongside")
    del sys.modules["alongside"]


@pytest.fixture(scope="session")
def parts() -> Iterator[ModuleType]:
    yield _load("parts")
    del sys.modules["parts"]


@pytest.fixture(scope="session")
def suite() -> Iterator[ModuleType]:
    yield _load("suite")
    del sys.modules["suite"]


@pytest.fixture(scope="session")
def ros_environment(installing: ModuleType) -> Iterator[ModuleType]:
    yield _load("ros_environment")
    del sys.modules["ros_environment"]


@pytest.fixture(scope="session")
def running() -> Iterator[ModuleType]:
    yield _load("running")
    del sys.modules["running"]


@pytest.fixture(scope="session")
def environment(page: ModuleType, installing: ModuleType, running: ModuleType) -> Iterator[ModuleType]:
    yield _load("environment")
    del sys.modules["environment"]


@pytest.fixture(scope="session")
def debian_packages(page: ModuleType, running: ModuleType) -> Iterator[ModuleType]:
    yield _load("debian_packages")
    del sys.modules["debian_packages"]


@pytest.fixture(scope="session")
def dev(
    page: ModuleType,
    installing: ModuleType,
    environment: ModuleType,
    debian_packages: ModuleType,
    locking: ModuleType,
    alongside: ModuleType,
    parts: ModuleType,
    suite: ModuleType,
    ros_environment: ModuleType,
) -> Iterator[ModuleType]:
    yield _load("dev")
    del sys.modules["dev"]


@pytest.fixture
def checkout(environment: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with an environment that holds nothing yet."""
    venv = tmp_path / ".venv"
    (venv / "bin").mkdir(parents=True)
    (venv / "bin" / "python").write_text("")
    (tmp_path / "requirements").mkdir()
    for name in ("pyproject.toml", "hatch_build.py", "requirements/run.lock"):
        (tmp_path / name).write_text(name)
    for name, value in {
        "ROOT": tmp_path,
        "VENV": venv,
        "STAMP": venv / "installed.json",
        "PYTHON": venv / "bin" / "python",
    }.items():
        monkeypatch.setattr(environment, name, value)
    return tmp_path


@pytest.fixture(scope="session")
def words() -> Iterator[ModuleType]:
    yield _load("words")
    del sys.modules["words"]


@pytest.fixture(scope="session")
def commit_message() -> Iterator[ModuleType]:
    yield _load("commit_message")
    del sys.modules["commit_message"]


@pytest.fixture(scope="session")
def page_types() -> Iterator[ModuleType]:
    yield _load("page_types")
    del sys.modules["page_types"]


@pytest.fixture(scope="session")
def client_types() -> Iterator[ModuleType]:
    yield _load("client_types")
    del sys.modules["client_types"]


@pytest.fixture(scope="session")
def typescript_client(page_types: ModuleType, client_types: ModuleType) -> Iterator[ModuleType]:
    yield _load("typescript_client")
    del sys.modules["typescript_client"]

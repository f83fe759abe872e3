"""The page's French of what the program says: no sentence or name in it has gone from the program."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from typing import Any

import pytest

from app.base.paths import checkout_dir, config_dir
from app.program.config import load_configuration
from app.program.desire_classes import desire_classes

#: What the page makes of a sentence itself.
OWN = frozenset({"would be at its best with"})


def texts_of_the_program() -> str:
    """Every string of ``app/`` and ``config/``, a line each: of an f-string, the parts between its values."""
    root = checkout_dir()
    assert root is not None
    found = [file.read_text(encoding="utf-8") for file in sorted((root / "config").rglob("*.yaml"))]
    for file in sorted((root / "app").rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        found += [
            node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)
        ]
        found += [node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    return "\n".join(found)


def french() -> dict[str, dict[str, str]]:
    root = checkout_dir()
    if root is None or not (file := root / "web" / "src" / "i18n" / "fr" / "robot.json").is_file():
        pytest.skip("the page's sources are not here")
    words: dict[str, dict[str, str]] = json.loads(file.read_text(encoding="utf-8"))
    return words


def parts(sentence: str) -> Iterator[str]:
    """The words between a sentence's values, without what joins them."""
    for part in re.split(r"\{\w+\}", sentence):
        if re.search(r"[A-Za-z]{2}", part):
            yield part.strip(" ,;:.()%")


def test_the_program_still_says_what_the_page_translates() -> None:
    said = texts_of_the_program()
    lost = [
        sentence
        for sentence in french()["sentences"]
        if any(part not in said and part not in OWN for part in parts(sentence))
    ]
    assert lost == []


def texts_of(schema: dict[str, Any]) -> Iterator[str]:
    """Titles and descriptions of a form's fields."""
    for field in schema.get("properties", {}).values():
        yield from (field[key] for key in ("title", "description") if key in field)


def test_what_forms_say_of_desires_has_its_french() -> None:
    words = french()
    known = words["names"].keys() | words["sentences"].keys()
    said: list[str] = []
    for kind in desire_classes(load_configuration(config_dir() / "lab.yaml")).values():
        said += [kind.title, kind.description, *texts_of(kind.parameters.model_json_schema())]
    assert len(said) > 150
    assert [text for text in said if text and text not in known] == []

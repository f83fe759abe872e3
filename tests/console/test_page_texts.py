"""The page's French of what the program says: no sentence or name in it has gone from the program."""

from __future__ import annotations

import ast
import json
import math
import re
from collections.abc import Iterator
from typing import Any, Literal

import pytest
from pydantic import BaseModel, Field, ValidationError, field_validator

from app.attention.desires import NoParameters
from app.base.broken_rule import broken_rule
from app.base.paths import checkout_dir, config_dir
from app.console import app as rest
from app.console.rest.models import Request
from app.program.config import load_configuration
from app.program.desire_classes import desire_classes
from app.tours.model import Tour

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


def said_by(node: ast.AST) -> Iterator[str]:
    """What the code of ``node`` says in words, with {} for values: not its docstrings, logs and descriptions."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.JoinedStr):
        yield "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    elif not isinstance(node, ast.Expr) or isinstance(node.value, ast.Await | ast.Yield | ast.YieldFrom):
        for child in ast.iter_child_nodes(node):
            if not (isinstance(child, ast.keyword) and child.arg == "description"):
                yield from said_by(child)


def test_why_a_tour_goes_as_it_goes_has_its_french() -> None:
    root = checkout_dir()
    assert root is not None
    guide = root / "app" / "modules" / "motivations" / "tour_guide"
    files = [*guide.glob("*.py"), root / "app" / "maps" / "place_checks.py"]
    said = {text for file in files for text in said_by(ast.parse(file.read_text(encoding="utf-8")))}
    reasons = {text for text in said if re.match(r"[a-z{].*[a-z}]{2,} [a-z{]", text) and "%s" not in text}
    reasons = {text for text in reasons if not text.endswith(".")}
    known = {re.sub(r"\{\w+\}", "{}", sentence) for sentence in french()["sentences"]}
    assert len(reasons) > 40
    assert reasons - known == set()


#: What pydantic may say of a value, by the type of its schema, and by what the schema says of it beside that.
OF_TYPE: dict[str, tuple[str, ...]] = {
    "bool": ("bool_type", "bool_parsing"),
    "dict": ("dict_type",),
    "float": ("float_type", "float_parsing", "finite_number"),
    "int": ("int_type", "int_parsing", "int_from_float", "int_parsing_size"),
    "list": ("list_type",),
    "literal": ("literal_error",),
    "model": ("model_type", "model_attributes_type"),
    "model-fields": ("missing", "extra_forbidden"),
    "str": ("string_type", "string_unicode"),
    "tagged-union": ("union_tag_invalid", "union_tag_not_found"),
    "tuple": ("tuple_type",),
    **dict.fromkeys(("function-after", "function-plain"), ("value_error",)),
    **dict.fromkeys(("any", "default", "model-field", "no-info", "nullable"), ()),
}
OF_BOUND = {"ge": "greater_than_equal", "gt": "greater_than", "le": "less_than_equal", "lt": "less_than"}
OF_LENGTH = {
    "str": {"min_length": "string_too_short", "max_length": "string_too_long", "pattern": "string_pattern_mismatch"},
    **{kind: {"min_length": "too_short", "max_length": "too_long"} for kind in ("dict", "list", "tuple")},
}


def schemas_in(schema: Any) -> Iterator[dict[str, Any]]:
    """All that a schema of pydantic's core is made of."""
    if isinstance(schema, dict):
        if isinstance(schema.get("type"), str):
            yield schema
        for key, value in schema.items():
            if key not in ("metadata", "serialization", "json_schema_input_schema"):
                yield from schemas_in(value)
    elif isinstance(schema, list | tuple):
        for each in schema:
            yield from schemas_in(each)


def requests(kind: type[BaseModel] = Request) -> Iterator[type[BaseModel]]:
    """The bodies that REST takes."""
    for each in kind.__subclasses__():
        yield each
        yield from requests(each)


def test_every_rule_that_a_form_can_break_has_its_french() -> None:
    assert rest.__name__, "all routes are there"
    classes = desire_classes(load_configuration(config_dir() / "lab.yaml")).values()
    rules = french()["rules"]
    models: list[type[BaseModel]] = [Tour, *requests(), *(kind.parameters for kind in classes)]
    assert len(models) > 50
    kinds: set[str] = set()
    for schema in (part for model in models for part in schemas_in(model.__pydantic_core_schema__)):
        kinds.update(OF_TYPE[schema["type"]])
        kinds.update(rule for bound, rule in OF_BOUND.items() if schema.get(bound) is not None)
        kinds.update(
            rule for length, rule in OF_LENGTH.get(schema["type"], {}).items() if schema.get(length) is not None
        )
    assert kinds - rules.keys() == set()
    assert rules.keys() - kinds == set(), "of these nothing is left to say"


class Everything(BaseModel):
    """A value of each kind."""

    model_config = {"extra": "forbid"}

    number: float = Field(1.0, gt=0, le=8, allow_inf_nan=False)
    above: float = Field(1.0, ge=0, lt=8)
    count: int = 1
    flag: bool = True
    name: str = Field("abc", min_length=2, max_length=4, pattern="^[a-z]*$")
    kind: Literal["a", "b", "c"] = "a"
    some: list[int] = Field([1], min_length=1, max_length=2)
    pair: tuple[int, ...] = ()
    named: dict[str, int] = {}
    inner: NoParameters = NoParameters()
    needed: int

    @field_validator("above")
    @classmethod
    def check(cls, value: float) -> float:
        if value == 3:
            raise ValueError("must not be three")
        return value


@pytest.mark.parametrize(
    ("field", "value", "kind", "values"),
    [
        ("number", 0, "greater_than", {"gt": 0.0, "given": "0"}),
        ("number", 9, "less_than_equal", {"le": 8.0, "given": "9"}),
        ("number", math.inf, "finite_number", {"given": "inf"}),
        ("number", None, "float_type", {"given": "nothing"}),
        ("above", -1, "greater_than_equal", {"ge": 0.0, "given": "-1"}),
        ("above", 8, "less_than", {"lt": 8.0, "given": "8"}),
        ("above", 3, "value_error", {"error": "must not be three", "given": "3"}),
        ("count", 1.5, "int_from_float", {"given": "1.5"}),
        ("flag", "perhaps", "bool_parsing", {"given": "'perhaps'"}),
        ("name", "a", "string_too_short", {"min_length": 2, "given": "'a'"}),
        ("name", "abcde", "string_too_long", {"max_length": 4, "given": "'abcde'"}),
        ("name", "AB", "string_pattern_mismatch", {"pattern": "^[a-z]*$", "given": "'AB'"}),
        ("kind", "d", "literal_error", {"expected": "'a', 'b', 'c'", "given": "'d'"}),
        ("some", {}, "list_type", {"given": "a mapping"}),
        ("some", [], "too_short", {"min_length": 1, "actual_length": 0, "field_type": "List", "given": "a list"}),
        ("pair", 3, "tuple_type", {"given": "3"}),
        ("inner", 3, "model_type", {"class_name": "NoParameters", "given": "3"}),
        ("needed", ..., "missing", {}),
        ("other", 1, "extra_forbidden", {}),
    ],
)
def test_a_rule_s_french_has_all_its_figures(field: str, value: Any, kind: str, values: dict[str, Any]) -> None:
    given = {"needed": 1, field: value} if value is not ... else {}
    with pytest.raises(ValidationError) as refused:
        Everything.model_validate(given)
    (detail,) = refused.value.errors()
    rule = broken_rule(detail)
    assert (rule.kind, rule.values) == (kind, values)
    assert set(re.findall(r"\{(\w+)\}", french()["rules"][kind])) <= rule.values.keys()


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

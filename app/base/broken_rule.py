"""Which rule of its model a value breaks: for clients that say it in another language than English."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pydantic_core import ErrorDetails

from app.base.yaml_source import shown


@dataclass(frozen=True, slots=True)
class Rule:
    """``kind`` is the type of pydantic's error, ``values`` what the rule says (``{"gt": 0}``), and the value that was
    ``given``, where there is one."""

    kind: str
    values: Mapping[str, str | int | float]


def broken_rule(detail: ErrorDetails) -> Rule:
    """The rule of one pydantic error."""
    kind = detail["type"]
    values = {name: _said(value) for name, value in detail.get("ctx", {}).items()}
    if kind in ("literal_error", "enum"):
        # One list: its last "or" is English.
        values["expected"] = ", ".join(str(values["expected"]).rsplit(" or ", 1))
    if kind not in ("missing", "extra_forbidden"):
        values["given"] = shown(detail.get("input"))
    return Rule(kind, values)


def _said(value: object) -> str | int | float:
    return value if isinstance(value, str | int | float) and not isinstance(value, bool) else str(value)

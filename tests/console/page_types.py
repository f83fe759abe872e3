"""The page's own declarations (``web/src/protocol/types.ts``), read so that what is sent can be held against them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

TYPES = Path(__file__).parents[2] / "web" / "src" / "protocol" / "types.ts"

#: Says what does not fit in a value at a path, in sentences.
Check = Callable[[Any, str], list[str]]
_DECLARATION = re.compile(
    r"^(?:export )?(?:interface|type) (\w+)(?: extends (\w+))?\s*=?(.*?)(?=^(?:export |interface |type )|\Z)",
    flags=re.DOTALL | re.MULTILINE,
)
_TOKEN = re.compile(r'"[^"]*"|[A-Za-z_$][\w$]*|-?\d+|[{}()\[\]<>|&;:,?=]')
_PRIMITIVES: dict[str, Callable[[Any], bool]] = {
    "string": lambda value: isinstance(value, str),
    "number": lambda value: isinstance(value, int | float) and not isinstance(value, bool),
    "boolean": lambda value: isinstance(value, bool),
    "null": lambda value: value is None,
    "undefined": lambda value: False,
    "unknown": lambda value: True,
}
#: Declared elsewhere: of it the page names what it uses.
_FOREIGN = {"JsonSchema"}
#: ``name -> (optional, check)``: an object's members.
Members = dict[str, tuple[bool, Check]]


class PageTypes:
    """Every exported interface and type by name; :meth:`problems` holds a value against one."""

    def __init__(self, text: str) -> None:
        text = re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.DOTALL)
        self._sources: dict[str, str] = {}
        #: What an interface extends, by its name.
        self._above: dict[str, str] = {}
        for match in _DECLARATION.finditer(text):
            name, above, source = match.groups()
            self._sources[name] = source.strip()
            if above:
                self._above[name] = above

    @classmethod
    def read(cls) -> PageTypes:
        """Those of the page."""
        return cls(TYPES.read_text("utf-8"))

    def problems(self, value: Any, name: str) -> list[str]:
        """What is missing, undeclared or of another type in ``value``, which should be a ``name``."""
        return self._named(name)(value, name)

    def _named(self, name: str) -> Check:
        return _object(self.members(name)) if name in self._above else _Parser(self._sources[name], self).whole()

    def members(self, name: str) -> Members:
        """Those of the interface ``name``, and of what it extends."""
        above = self.members(self._above[name]) if name in self._above else {}
        return above | _Parser(self._sources[name], self).members()

    def check(self, name: str) -> Check:
        """Of the type ``name``, looked up when it is needed: types name each other."""
        if name in _FOREIGN:
            return lambda value, path: []
        if name in _PRIMITIVES:
            return lambda value, path: [] if _PRIMITIVES[name](value) else [f"{path} is no {name}: {value!r}"]
        return lambda value, path: self._named(name)(value, path)


class _Parser:
    """The part of TypeScript's types that the page declares its messages with."""

    def __init__(self, source: str, types: PageTypes) -> None:
        self._tokens = _TOKEN.findall(source)
        self._at = 0
        self._types = types

    def whole(self) -> Check:
        return self._union()

    @property
    def _next(self) -> str:
        return self._tokens[self._at] if self._at < len(self._tokens) else ""

    def _take(self, *expected: str) -> str:
        token = self._next
        assert not expected or token in expected, (
            f"{token!r} where {expected} should be, after {self._tokens[: self._at]}"
        )
        self._at += 1
        return token

    def _union(self) -> Check:
        if self._next == "|":
            self._take()
        choices = [self._choice()]
        while self._next == "|":
            self._take()
            choices.append(self._choice())
        return choices[0] if len(choices) == 1 else _either(choices)

    def _choice(self) -> Check:
        begin = self._at
        check = self._postfix()
        if self._next != "&":
            return check
        self._at = begin
        joined = self._named_or_given()
        while self._next == "&":
            self._take()
            joined |= self._named_or_given()
        return _object(joined)

    def _named_or_given(self) -> Members:
        if self._next == "{":
            return self.members()
        name = self._take()
        return self._omitted() if name == "Omit" else self._types.members(name)

    def _omitted(self) -> Members:
        self._take("<")
        members = dict(self._types.members(self._take()))
        while self._take(",", "|", ">") != ">":
            members.pop(self._take().strip('"'))
        return members

    def _postfix(self) -> Check:
        check = self._primary()
        while self._next == "[":
            self._take("[")
            self._take("]")
            check = _every(check)
        return check

    def _primary(self) -> Check:
        token = self._next
        if token == "{":
            return _object(self.members())
        self._take()
        if token == "(":
            check = self._union()
            self._take(")")
            return check
        if token == "[":
            return self._tuple()
        if token == "readonly":
            return self._postfix()
        if token.startswith('"'):
            literal = token.strip('"')
            return lambda value, path: [] if value == literal else [f"{path} is not {token}: {value!r}"]
        if self._next == "<":
            return self._generic(token)
        if self._next == "[" and self._tokens[self._at + 1] != "]":  # one member of another type
            self._take("[")
            member = self._take().strip('"')
            self._take("]")
            return lambda value, path: self._types.members(token)[member][1](value, path)
        return self._types.check(token)

    def _generic(self, name: str) -> Check:
        if name == "Omit":
            return _object(self._omitted())
        self._take("<")
        arguments = [self._union()]
        while self._next == ",":
            self._take()
            arguments.append(self._union())
        check = _values(arguments[-1]) if name == "Record" else arguments[0]  # Readonly
        self._take(">")
        return check

    def _tuple(self) -> Check:
        parts = []
        while self._next != "]":
            if self._tokens[self._at + 1] == ":":  # a part's name
                self._at += 2
            parts.append(self._union())
            if self._next == ",":
                self._take()
        self._take("]")

        def check(value: Any, path: str) -> list[str]:
            if not isinstance(value, list) or len(value) != len(parts):
                return [f"{path} is no list of {len(parts)}: {value!r}"]
            return [said for i, part in enumerate(parts) for said in part(value[i], f"{path}[{i}]")]

        return check

    def members(self) -> Members:
        members: Members = {}
        self._take("{")
        while self._next != "}":
            name = self._take().strip('"')
            optional = self._next == "?"
            if optional:
                self._take()
            self._take(":")
            members[name] = optional, self._union()
            if self._next in (";", ","):
                self._take()
        self._take("}")
        return members


def _object(members: Members) -> Check:
    def check(value: Any, path: str) -> list[str]:
        if not isinstance(value, Mapping):
            return [f"{path} is no object: {value!r}"]
        return list(_differences(value, members, path))

    return check


def _differences(value: Mapping[str, Any], members: Members, path: str) -> Iterator[str]:
    for name, (optional, check) in members.items():
        if name in value:
            yield from check(value[name], f"{path}.{name}")
        elif not optional:
            yield f"{path}.{name} is missing"
    for name in value.keys() - members.keys():
        yield f"{path}.{name} is not declared"


def _either(choices: list[Check]) -> Check:
    def check(value: Any, path: str) -> list[str]:
        found = [choice(value, path) for choice in choices]
        # Of messages, the one of this type: what is wrong in it shall be said.
        return min(
            found, key=lambda said: (any(".type is not" in one or " is no " in one for one in said[:1]), len(said))
        )

    return check


def _every(check: Check) -> Check:
    def checked(value: Any, path: str) -> list[str]:
        if not isinstance(value, list):
            return [f"{path} is no list: {value!r}"]
        return [said for i, item in enumerate(value) for said in check(item, f"{path}[{i}]")]

    return checked


def _values(check: Check) -> Check:
    def checked(value: Any, path: str) -> list[str]:
        if not isinstance(value, Mapping):
            return [f"{path} is no object: {value!r}"]
        return [said for name, item in value.items() for said in check(item, f"{path}.{name}")]

    return checked

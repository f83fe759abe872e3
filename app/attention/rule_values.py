"""Values of messages in rules: fields, tests on them, and parameters that take them. Pure.

A test is a value (equal to it), a list (one of these) or a mapping, all of whose members must hold: operators
(``above``, ``below``, ``at_least``, ``at_most``, ``is``, ``not``, ``any``) or names of fields with a test each. A
field that is absent or None passes no test but ``not``; NaN compares with nothing.
"""

from __future__ import annotations

import enum
import math
import re
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin, get_type_hints

import msgspec

from app.base.yaml_source import suggestion

#: Operators that compare numbers.
_COMPARE: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "above": lambda value, bound: value > bound,
    "below": lambda value, bound: value < bound,
    "at_least": lambda value, bound: value >= bound,
    "at_most": lambda value, bound: value <= bound,
}
OPERATORS: Final = (*_COMPARE, "is", "not", "any")
_PLACE: Final = re.compile(r"\{([A-Za-z0-9_]+(?:\.[A-Za-z0-9_]+)*)\}")
Path = tuple[str | int, ...]


class NoValue(Exception):
    """A parameter takes a value that the event does not have. ``field`` is its dotted name."""

    def __init__(self, field: str) -> None:
        self.field = field
        super().__init__(f"the event has no {field}")


class InvalidTest(Exception):
    """A test cannot be of such a value; ``path`` leads to it in the test, ``message`` says what is allowed."""

    def __init__(self, path: Path, message: str) -> None:
        self.path = path
        self.message = message
        super().__init__(message)


def field_of(value: Any, name: str) -> Any:
    """Member ``name`` of a message, mapping or sequence (by its number, from 0); None where there is none."""
    if isinstance(value, Mapping):
        return value.get(name)
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return value[int(name)] if name.isdigit() and int(name) < len(value) else None
    if name not in field_types(type(value)):
        return None
    return getattr(value, _attribute(name), None)


def passes(value: Any, test: Any) -> bool:
    """Whether ``value`` passes ``test``."""
    if isinstance(test, Mapping):
        return all(_holds(value, name, each) for name, each in test.items())
    if isinstance(test, list | tuple):
        return any(passes(value, each) for each in test)
    value = value.value if isinstance(value, enum.Enum) else value
    if isinstance(value, bool) or isinstance(test, bool):
        return value is test
    return bool(value == test)


def resolved(template: Any, event: Any) -> Any:
    """``template`` with the values of ``event`` in place of each ``{field}`` of its texts.

    A text that is one such place alone becomes the value itself. Raises NoValue.
    """
    if isinstance(template, Mapping):
        return {key: resolved(each, event) for key, each in template.items()}
    if isinstance(template, list | tuple):
        return [resolved(each, event) for each in template]
    if not isinstance(template, str):
        return template
    if alone := _PLACE.fullmatch(template):
        return _plain(_value_at(event, alone[1]))
    return _PLACE.sub(lambda place: str(_plain(_value_at(event, place[1]))), template)


def places_of(template: Any) -> Iterator[str]:
    """The dotted names of all fields that ``template`` takes."""
    if isinstance(template, Mapping):
        template = list(template.values())
    if isinstance(template, list | tuple):
        for each in template:
            yield from places_of(each)
    elif isinstance(template, str):
        yield from _PLACE.findall(template)


def check_test(kind: Any, test: Any, path: Path = ()) -> None:
    """Raise InvalidTest where ``test`` names a field that values of the type ``kind`` do not have, or compares what is
    no number."""
    if isinstance(test, list | tuple):
        for number, each in enumerate(test):
            check_test(kind, each, (*path, number))
    if not isinstance(test, Mapping):
        return
    for name, each in test.items():
        inside = (*path, name)
        if name in _COMPARE:
            if isinstance(each, bool) or not isinstance(each, int | float) or not math.isfinite(each):
                raise InvalidTest(inside, f"must be a number, not {each!r}")
        elif name == "any":
            check_test(_member(kind), each, inside)
        elif name in ("is", "not"):
            check_test(kind, each, inside)
        else:
            check_test(member_type(kind, str(name), inside), each, inside)


def member_type(kind: Any, name: str, path: Path = ()) -> Any:
    """The type of member ``name`` of values of the type ``kind``; ``Any`` where it is not known before. Raises
    InvalidTest."""
    kind = _core(kind)
    if kind is Any or kind is object:
        return Any
    origin = get_origin(kind) or kind
    if isinstance(origin, type) and issubclass(origin, Mapping):
        arguments = get_args(kind)
        return arguments[1] if len(arguments) == 2 else Any
    if isinstance(origin, type) and issubclass(origin, Sequence) and origin is not str:
        if name.isdigit():
            return _member(kind)
        raise InvalidTest(path, f"is a list: a member is named by its number from 0, or by `any`, not {name!r}")
    known = field_types(origin) if isinstance(origin, type) else {}
    if name not in known:
        if not known:
            raise InvalidTest(path, f"has no parts; {suggestion(name, OPERATORS)}")
        raise InvalidTest(path, f"unknown field; {suggestion(name, [*known, *OPERATORS])}")
    return known[name]


def check_place(kind: Any, dotted: str) -> None:
    """Raise InvalidTest where messages of the type ``kind`` have no ``dotted`` field."""
    for name in dotted.split("."):
        kind = member_type(kind, name)


def field_types(kind: type[Any]) -> Mapping[str, Any]:
    """Type by name of the fields of a record; empty for what is none."""
    if kind not in _FIELDS:
        found: dict[str, Any] = {}
        if is_dataclass(kind) or issubclass(kind, msgspec.Struct):
            names = [field.name for field in fields(kind)] if is_dataclass(kind) else list(kind.__struct_fields__)
            hints = get_type_hints(kind)
            found = {"class" if name == "cls" else name: hints[name] for name in names}
        _FIELDS[kind] = found
    return _FIELDS[kind]


#: A memory of what is derived from types alone.
_FIELDS: Final[dict[type[Any], Mapping[str, Any]]] = {}


def _attribute(name: str) -> str:
    return "cls" if name == "class" else name


def _holds(value: Any, name: str, test: Any) -> bool:
    if compare := _COMPARE.get(name):
        return isinstance(value, int | float) and not isinstance(value, bool) and compare(value, test)
    match name:
        case "is":
            return passes(value, test)
        case "not":
            return not passes(value, test)
        case "any":
            return isinstance(value, Sequence) and any(passes(each, test) for each in value)
        case _:
            return passes(field_of(value, name), test)


def _value_at(event: Any, dotted: str) -> Any:
    value = event
    for name in dotted.split("."):
        value = field_of(value, name)
    if value is None:
        raise NoValue(dotted)
    return value


def _plain(value: Any) -> Any:
    """A value as JSON has it. Raises NoValue for a number that is not finite, which no parameter may be."""
    value = value.value if isinstance(value, enum.Enum) else value
    if isinstance(value, float) and not math.isfinite(value):
        raise NoValue("number that is finite")
    return list(value) if isinstance(value, tuple) else value


def _core(kind: Any) -> Any:
    """``kind`` without Annotated and None; ``Any`` where several types are left."""
    if get_origin(kind) is Annotated:
        return _core(get_args(kind)[0])
    if get_origin(kind) in (Union, types.UnionType):
        left = [each for each in get_args(kind) if each is not type(None)]
        return _core(left[0]) if len(left) == 1 else Any
    return str if get_origin(kind) is Literal else kind


def _member(kind: Any) -> Any:
    """The type of a sequence's members; ``Any`` where it is not known."""
    kind = _core(kind)
    arguments = [each for each in get_args(kind) if each is not Ellipsis]
    return arguments[0] if arguments and all(each == arguments[0] for each in arguments) else Any

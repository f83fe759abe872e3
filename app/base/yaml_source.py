"""YAML (and JSON, its subset) read so that every error can name file, line and key.

Scalars follow the YAML 1.2 core schema: ``off``, ``no`` and ``12:30`` are strings and ``1e3`` is a number, where YAML
1.1 would have made them False, False, 750 and a string. A key given twice is an error.

Reading takes bounded time and memory, whatever the text: its size, its depth, the number of its values and the digits
of a number are limited, and a value that an alias repeats counts as often as it is repeated.
"""

from __future__ import annotations

import difflib
import json
import re
import types
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from app.base.errors import ConfigError
from app.base.json_source import DEEPEST, MOST_DIGITS
from app.base.plain_file import megabytes, read_plain

KeyPath = tuple[str | int, ...]
ModelT = TypeVar("ModelT", bound=BaseModel)


#: YAML's word for a mapping, as messages use it.
MAPPING = "a mapping (name: value lines)"
#: The value expected, by the type of pydantic's error.
_SHAPES = {
    **dict.fromkeys(("model_type", "model_attributes_type", "dict_type", "mapping_type"), MAPPING),
    **dict.fromkeys(("list_type", "tuple_type"), "a list"),
    "string_type": "text",
}
#: A pattern that is a choice of words.
_CHOICES = re.compile(r"\^\(([\w|]+)\)\$")
_LIBRARYS_WORDS = re.compile(r"^(Input|Value|String|List|Tuple|Dictionary) (?=should|is |must)| after validation")
#: A longer value is not repeated whole.
_LONGEST = 80

#: A file has no more bytes than these,
MOST_BYTES = 10_000_000
#: and no more names and values, however few of them it writes out beside its aliases (700 bytes of memory each or so).
MOST_VALUES = 500_000
#: The slow loader describes a mistake better; it reads no longer texts than this (characters).
_EXPLAINED = 1_000_000

#: Scalars of YAML 1.2's core schema: tag, pattern, and with what it can begin.
_SCALARS = (
    ("null", r"^(?:~|null|Null|NULL|)$", ["~", "n", "N", ""]),
    ("bool", r"^(?:true|True|TRUE|false|False|FALSE)$", list("tTfF")),
    ("int", r"^[-+]?(?:[0-9]+|0x[0-9a-fA-F]+)$", list("-+0123456789")),
    (
        "float",
        r"^(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$",
        list("-+.0123456789"),
    ),
    ("merge", r"^<<$", ["<"]),
)


class _CoreLoader(yaml.SafeLoader):
    """SafeLoader with the scalars of YAML 1.2's core schema. Of the loaders, its error messages are the most
    precise."""


class _QuickLoader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]  # known at run time alone
    """The same by libyaml, where PyYAML has it: a tenth of the time."""


def _construct_scalar(loader: yaml.SafeLoader, node: yaml.Node) -> Any:
    """A scalar of the core schema. Raises yaml's ConstructorError where tag and value do not match."""
    if not isinstance(node, yaml.ScalarNode) or not _PATTERNS[node.tag].match(node.value):
        kind = node.tag.rpartition(":")[2]
        raise yaml.constructor.ConstructorError(None, None, f"what is tagged !!{kind} is none", node.start_mark)
    return _CONSTRUCT[node.tag](node.value)


def _int(text: str) -> int:
    return int(text, 16) if "x" in text else int(text)  # a leading 0 is decimal in YAML 1.2, octal in 1.1


_TAG = "tag:yaml.org,2002:"
_INT, _MERGE = f"{_TAG}int", f"{_TAG}merge"
_PATTERNS = {_TAG + name: re.compile(pattern) for name, pattern, _ in _SCALARS}
_CONSTRUCT: dict[str, Callable[[str], Any]] = {
    f"{_TAG}null": lambda text: None,
    f"{_TAG}bool": lambda text: text.lower() == "true",
    _INT: _int,
    f"{_TAG}float": lambda text: float(text.lower().replace(".inf", "inf").replace(".nan", "nan")),
}
for _loader in (_CoreLoader, _QuickLoader):
    _loader.yaml_implicit_resolvers = {}
    for _name, _pattern, _first in _SCALARS:
        _loader.add_implicit_resolver(_TAG + _name, re.compile(_pattern), _first)
    # No date, set or bytes: what comes of a file is what JSON knows.
    _loader.yaml_constructors = {
        tag: construct
        for tag, construct in _loader.yaml_constructors.items()
        if tag is None or tag.removeprefix(_TAG) in ("str", "seq", "map")
    }
    for _tag in _CONSTRUCT:
        _loader.add_constructor(_tag, _construct_scalar)


@dataclass(frozen=True)
class Document:
    """A file's content and the position of each value.

    ``data`` is the parsed content (dict, list, str, int, float, bool, None); ``file`` its name for people; ``lines``
    the line, from 1, of each key path.
    """

    data: Any
    file: str
    lines: Mapping[KeyPath, int] = field(repr=False)

    def line(self, key_path: Sequence[str | int]) -> int:
        """The line (from 1) of ``key_path``, or of its nearest part that the file holds."""
        known: KeyPath = ()
        for key in key_path:
            if (*known, key) in self.lines:
                known = (*known, key)
        return self.lines.get(known, 1)

    def error(self, message: str, key_path: Sequence[str | int] = ()) -> ConfigError:
        """A :class:`ConfigError` (to raise) that points at ``key_path``."""
        return ConfigError(message, self.file, self.line(key_path), dotted(key_path))

    def validate(self, model: type[ModelT]) -> ModelT:
        """The document as a ``model``; raises ConfigError at the first value that does not fit."""
        try:
            return model.model_validate({} if self.data is None else self.data)
        except ValidationError as failure:
            raise self._explained(model, failure) from None

    def _explained(self, model: type[BaseModel], failure: ValidationError) -> ConfigError:
        details = failure.errors(include_url=False)
        # A misspelt key is also a missing one: the message about the misspelling is more helpful.
        first = next((detail for detail in details if detail["type"] == "extra_forbidden"), details[0])
        path = tuple(part for part in first["loc"] if part != "[key]")
        message = validation_message(model, first)
        if len(details) > 1:
            message += f" (and {len(details) - 1} more mistake{'s' * (len(details) > 2)})"
        return self.error(f"{dotted(path)}: {message}" if path else message, path)


def load_yaml(path: Path | str) -> Document:
    """Read a YAML or JSON file. Raises ConfigError if it cannot be read or is no such file."""
    try:
        text = read_plain(path, MOST_BYTES).decode("utf-8")
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror or failure}", str(path)) from None
    except UnicodeDecodeError:
        raise ConfigError("is not a text file in UTF-8", str(path)) from None
    return load_text(text, str(path))


def load_text(text: str, file: str) -> Document:
    """Read YAML or JSON from ``text``; ``file`` is its name in errors (for example "<standard input>").

    Raises ConfigError for what is neither, and for more than ``MOST_BYTES``, ``MOST_VALUES``, ``DEEPEST`` or
    ``MOST_DIGITS``.
    """
    if len(text) > MOST_BYTES:
        raise ConfigError(f"has more than {megabytes(MOST_BYTES)}, the most that is read", file)
    if "\t" in text and _is_json(text):
        text = text.replace("\t", " ")  # legal white space in JSON, not in YAML
    try:
        try:
            _check_extent(text, file)
            return _loaded(_QuickLoader, text, file)
        except yaml.YAMLError:
            if len(text) > _EXPLAINED:
                raise
            return _loaded(_CoreLoader, text, file)
    except yaml.MarkedYAMLError as failure:
        mark = failure.problem_mark or failure.context_mark
        problem = failure.problem or failure.context or "is not YAML"
        raise ConfigError(f"is not valid YAML: {problem}", file, mark.line + 1 if mark else 0) from None
    except yaml.YAMLError as failure:
        raise ConfigError(f"is not valid YAML: {str(failure).splitlines()[0]}", file) from None


def _check_extent(text: str, file: str) -> None:
    """Raise ConfigError for a text that would become too much, before anything is made of it; YAMLError for none.

    Neither the parser nor this calls itself, so that no depth harms them. Loaders do, and libyaml's without a limit.
    """
    parser = _QuickLoader(text)
    count = 0
    sizes: dict[str, int] = {}
    around: list[tuple[str | None, int]] = []
    try:
        while parser.check_event():
            event = parser.get_event()
            match event:
                case yaml.AliasEvent():
                    count += sizes.get(str(event.anchor), 1)
                case yaml.CollectionStartEvent():
                    around.append((event.anchor, count))
                    count += 1
                case yaml.CollectionEndEvent():
                    anchor, before = around.pop()
                    if anchor is not None:
                        sizes[anchor] = count - before
                case yaml.ScalarEvent():
                    count += 1
                case _:
                    continue
            if len(around) > DEEPEST:
                raise ConfigError(
                    f"is nested too deeply: values lie at most {DEEPEST} deep within others",
                    file,
                    event.start_mark.line + 1,
                )
            if count > MOST_VALUES:
                raise ConfigError(
                    f"has more than {MOST_VALUES:,} names and values up to here, the most that are read; what an alias"
                    " (*name) stands for counts each time",
                    file,
                    event.start_mark.line + 1,
                )
    finally:
        parser.dispose()


def _loaded(kind: type[_CoreLoader] | type[_QuickLoader], text: str, file: str) -> Document:
    """Raises YAMLError and ConfigError. For texts that :func:`_check_extent` let pass, or that are no YAML."""
    loader = kind(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return Document(None, file, {(): 1})
        lines: dict[KeyPath, int] = {}
        _walk(node, (), lines, file, ())
        return Document(loader.construct_document(node), file, lines)
    finally:
        loader.dispose()


def parse(path: Path | str, model: type[ModelT]) -> ModelT:
    """Read the file ``path`` as a ``model``; raises ConfigError naming file, line, key and what is allowed."""
    return load_yaml(path).validate(model)


def dotted(key_path: Sequence[str | int]) -> str:
    """``("strategies", 3, "costs")`` as people write it: ``strategies[3].costs``."""
    text = ""
    for key in key_path:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else key
    return text


def suggestion(word: str, known: Sequence[str]) -> str:
    """``'x' is unknown; allowed: a, b`` with the likeliest meant word first, for messages about names."""
    return f"{likeliest(word, known)}allowed: {', '.join(sorted(known)) or 'none'}"


def likeliest(word: str, known: Collection[str]) -> str:
    """``did you mean 'x'? `` with a space behind it, or nothing where no known name is near."""
    close = difflib.get_close_matches(word, known, n=1)
    return f"did you mean {close[0]!r}? " if close else ""


def validation_message(model: type[BaseModel] | None, detail: ErrorDetails, mapping: str = MAPPING) -> str:
    """One sentence for people about one pydantic error of ``model``: the mistake and the allowed values.

    Without a model the allowed keys are not known; ``mapping`` is the word for a mapping in the file's format.
    """
    location = detail["loc"]
    if detail["type"] == "extra_forbidden":
        owner = None if model is None else _model_at(model, location[:-1])
        allowed = [info.alias or name for name, info in owner.model_fields.items()] if owner else []
        return f"unknown key; {suggestion(str(location[-1]), allowed)}" if owner else "unknown key"
    if detail["type"] == "missing":
        return "is missing"
    given = detail.get("input")
    if (shape := _SHAPES.get(detail["type"])) is not None:
        return f"should be {mapping if shape == MAPPING else shape}, not {shown(given)}"
    text = str(detail["msg"])
    if detail["type"] == "string_pattern_mismatch" and (choices := _CHOICES.search(text)):
        text = f"should be one of {', '.join(choices[1].split('|'))}"
    text = _LIBRARYS_WORDS.sub("", text.removeprefix("Value error, "))
    if isinstance(given, str | int | float | bool):
        text += f", not {shown(given)}"
    return text


def shown(given: object) -> str:
    """A value as messages repeat it: no longer than :data:`_LONGEST` characters."""
    match given:
        case None:
            return "nothing"
        case dict():
            return "a mapping"
        case list() | tuple():
            return "a list"
    text = repr(given)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 2]}…{text[-1]}"


def _is_json(text: str) -> bool:
    try:
        json.loads(text, parse_int=len)  # of its numbers nothing is wanted, and long ones would not be made
    except (ValueError, RecursionError):
        return False
    return True


def _walk(node: yaml.Node, path: KeyPath, lines: dict[KeyPath, int], file: str, above: tuple[yaml.Node, ...]) -> None:
    """Note the line of every value under ``node``; refuse doubled keys and a value that contains itself."""
    line = node.start_mark.line + 1
    lines.setdefault(path, line)
    if node in above:
        raise ConfigError("a value contains itself", file, line, dotted(path))
    inside = (*above, node)
    if node.tag == _INT and isinstance(node, yaml.ScalarNode):
        _check_digits(node, file, path)
    elif isinstance(node, yaml.SequenceNode):
        for index, item in enumerate(node.value):
            _walk(item, (*path, index), lines, file, inside)
    elif isinstance(node, yaml.MappingNode):
        seen: set[Any] = set()
        merged: list[yaml.Node] = []
        for key_node, value_node in node.value:
            if key_node.tag == _MERGE:
                merged.append(value_node)
                continue
            if not isinstance(key_node, yaml.ScalarNode):
                raise ConfigError("a key must be a word or a number", file, key_node.start_mark.line + 1, dotted(path))
            key = _key(key_node, file, path)
            here = (*path, key)
            if key in seen:
                raise ConfigError(f"the key {key!r} is here twice", file, key_node.start_mark.line + 1, dotted(here))
            seen.add(key)
            lines.setdefault(here, key_node.start_mark.line + 1)
            _walk(value_node, here, lines, file, inside)
        for value_node in merged:
            for source in value_node.value if isinstance(value_node, yaml.SequenceNode) else [value_node]:
                _walk(source, path, lines, file, inside)


def _key(node: yaml.ScalarNode, file: str, path: KeyPath) -> str | int:
    if node.tag != _INT or not _PATTERNS[_INT].match(node.value):
        return str(node.value)
    _check_digits(node, file, path)
    return _int(node.value)


def _check_digits(node: yaml.ScalarNode, file: str, path: KeyPath) -> None:
    if len(node.value) > MOST_DIGITS:
        raise ConfigError(
            f"a number has {len(node.value)} digits; at most {MOST_DIGITS} are read",
            file,
            node.start_mark.line + 1,
            dotted(path),
        )


def _model_at(model: type[BaseModel], location: Sequence[str | int]) -> type[BaseModel] | None:
    """The pydantic model that holds the value at ``location`` inside ``model``, if the annotations say so."""
    kind: Any = model
    for key in location:
        candidates = _choices(kind)
        kind = None
        for candidate in candidates:
            if isinstance(candidate, type) and issubclass(candidate, BaseModel):
                info = next((i for n, i in candidate.model_fields.items() if key in (n, i.alias)), None)
                if info is not None:
                    kind = info.annotation
                    break
            elif get_origin(candidate) is not None and get_args(candidate):
                kind = get_args(candidate)[-1] if get_args(candidate)[-1] is not Ellipsis else get_args(candidate)[0]
                break
        if kind is None:
            return None
    return next((c for c in _choices(kind) if isinstance(c, type) and issubclass(c, BaseModel)), None)


def _choices(kind: Any) -> list[Any]:
    """``kind`` without Annotated and as the list of its union's members."""
    if get_origin(kind) is Annotated:
        return _choices(get_args(kind)[0])
    if get_origin(kind) in (Union, types.UnionType):
        return [choice for member in get_args(kind) for choice in _choices(member)]
    return [kind]

"""Tours as YAML: read within bounds, with file, line and field in every refusal; written in one order.

Comments are lost when a tour is written: a tour is edited on the page or in its file, and what is not data is not kept.
All texts are quoted, so that none (``no``, ``1e3``, ``a: b``) is taken for anything else.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import yaml

from app.base.errors import ConfigError
from app.base.plain_file import megabytes, read_plain
from app.base.yaml_source import Document, dotted, load_text
from app.tours.consistency import tour_of
from app.tours.model import Tour
from app.tours.problems import InvalidTour

#: A file has no more bytes than these: a hundred stops with texts in four languages.
MOST_BYTES = 1_000_000
#: A list of scalars up to so many characters is written on one line.
_ONE_LINE = 80

_TAG = "tag:yaml.org,2002:"
_HEADER = "# A guided tour; see docs/guided-tours.md. Comments are lost when the program writes this file.\n"


def load_tour(path: Path) -> tuple[Tour, Document]:
    """The tour in the file ``path``, and where its values are. Raises ConfigError."""
    try:
        text = read_plain(path, MOST_BYTES).decode("utf-8")
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror or failure}", str(path)) from None
    except UnicodeDecodeError:
        raise ConfigError("is not a text file in UTF-8", str(path)) from None
    return read_tour(text, str(path))


def read_tour(text: str, file: str) -> tuple[Tour, Document]:
    """The tour that ``text`` is, called ``file`` in refusals, and where its values are. Raises ConfigError."""
    if len(text) > MOST_BYTES:
        raise ConfigError(f"has more than {megabytes(MOST_BYTES)}, the most that is read", file)
    document = load_text(text, file)
    if not isinstance(document.data, Mapping):
        raise document.error("is no tour: it must be a mapping (name: value lines)")
    try:
        return tour_of(document.data), document
    except InvalidTour as refusal:
        first, *others = refusal.problems
        more = f" (and {len(others)} more mistake{'s' * (len(others) > 1)})" if others else ""
        raise document.error(f"{dotted(first.path)}: {first.message}{more}", first.path) from None


def tour_text(tour: Tour) -> str:
    """The content of the file of ``tour``: what has its usual value is left out."""
    data = tour.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    return _HEADER + yaml.serialize(_node(data), Dumper=yaml.SafeDumper, allow_unicode=True, width=1_000_000, indent=2)


def digest(tour: Tour) -> str:
    """16 hexadecimal digits that two tours share only if they are equal."""
    return hashlib.sha256(tour_text(tour).encode()).hexdigest()[:16]


def _node(value: Any) -> yaml.Node:
    match value:
        case dict():
            pairs = [(_key(str(key)), _node(each)) for key, each in value.items()]
            return yaml.MappingNode(f"{_TAG}map", pairs, flow_style=not pairs)
        case list():
            scalars = not any(isinstance(each, dict | list) for each in value)
            short = scalars and sum(len(str(each)) + 4 for each in value) <= _ONE_LINE
            return yaml.SequenceNode(f"{_TAG}seq", [_node(each) for each in value], flow_style=short)
        case str():
            return yaml.ScalarNode(f"{_TAG}str", value, style='"')
        case None:
            return yaml.ScalarNode(f"{_TAG}null", "null")
        case bool():
            return yaml.ScalarNode(f"{_TAG}bool", str(value).lower())
        case int():
            return yaml.ScalarNode(f"{_TAG}int", str(value))
        case float() if value.is_integer() and abs(value) < 1e15:
            return yaml.ScalarNode(f"{_TAG}int", str(int(value)))
    # YAML 1.1 wants a point in it.
    text = repr(cast(float, value))
    return yaml.ScalarNode(f"{_TAG}float", text if "." in text else text.replace("e", ".0e"))


def _key(name: str) -> yaml.ScalarNode:
    # Keys are names of fields and parameters and tags of languages; "no" is Norwegian.
    plain = name.isascii() and name.replace("_", "").isalnum() and name[0].isalpha() and name not in _NOT_PLAIN
    return yaml.ScalarNode(f"{_TAG}str", name, style=None if plain else '"')


#: Words that YAML 1.1 or 1.2 takes for something else than text.
_NOT_PLAIN = frozenset(("y", "n", "yes", "no", "on", "off", "true", "false", "null"))

"""Numbers in a YAML file replaced by others; everything else in it, comments and layout too, stays as it is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from app.base.errors import ConfigError
from app.base.plain_file import read_plain
from app.base.whole_file import write_whole
from app.base.yaml_source import MOST_BYTES, KeyPath, dotted, load_text


def replaced(text: str, numbers: Mapping[KeyPath, str], file: str) -> str:
    """``text`` with each of ``numbers``, as they are to be written, in place of the value at its key path.

    Raises ConfigError if ``text`` is no YAML, has no number there, or has it by an alias (``*name``), which would
    change it elsewhere, too.
    """
    before = load_text(text, file)
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    spans: dict[tuple[int, int], str] = {}
    for path, number in numbers.items():
        node = _node(root, path)
        value = _value(before.data, path)
        if not isinstance(node, yaml.ScalarNode) or isinstance(value, bool) or not isinstance(value, int | float):
            raise before.error("there is no number here to be replaced", path)
        span = (node.start_mark.index, node.end_mark.index)
        if span in spans:
            raise before.error("is written once for several places (*name); write each out", path)
        spans[span] = number
    after = text
    for (begin, end), number in sorted(spans.items(), reverse=True):
        after = after[:begin] + number + after[end:]
    changed = load_text(after, file).data
    wanted = {path: float(number) for path, number in numbers.items()}
    if _with(before.data, wanted) != _with(changed, wanted) or any(
        _value(changed, path) != number for path, number in wanted.items()
    ):
        raise ConfigError(f"cannot be changed as it is written; write {dotted(next(iter(numbers)))} by hand", file)
    return after


def replace_numbers(file: Path, numbers: Mapping[KeyPath, str]) -> None:
    """Write ``file`` again with ``numbers`` (see :func:`replaced`): wholly, or not at all. Raises ConfigError."""
    target = file.resolve()
    try:
        text = replaced(read_plain(target, MOST_BYTES).decode("utf-8"), numbers, str(file))
        write_whole(target, text.encode())
    except UnicodeDecodeError:
        raise ConfigError("is not a text file in UTF-8", str(file)) from None
    except OSError as failure:
        raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(file)) from None


def _node(root: yaml.Node | None, path: KeyPath) -> yaml.Node | None:
    node = root
    for key in path:
        if isinstance(node, yaml.MappingNode):
            node = next((value for name, value in node.value if name.value == str(key)), None)
        elif isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
            node = node.value[key]
        else:
            return None
    return node


def _value(data: Any, path: KeyPath) -> Any:
    for key in path:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _with(data: Any, numbers: Mapping[KeyPath, float], at: KeyPath = ()) -> Any:
    """``data`` with ``numbers`` in it; what is elsewhere must not differ."""
    if at in numbers:
        return numbers[at]
    if isinstance(data, dict):
        return {key: _with(value, numbers, (*at, key)) for key, value in data.items()}
    if isinstance(data, list):
        return [_with(value, numbers, (*at, index)) for index, value in enumerate(data)]
    return data

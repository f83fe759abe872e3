"""The Python client's records and operations, made of the descriptions of REST and of the live stream.

    make types     write clients/python/hbba_client/records.py and operations.py, too

A test compares the files with the descriptions.
"""

from __future__ import annotations

import keyword
import re
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from app.console import schema
from app.console.app import create_app
from app.console.live.messages import FROM_ROBOT
from tests.console.program import build, write_page

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "clients" / "python" / "hbba_client"
WIDTH = 120
BASE = "/api/v1"
WRITTEN = "Written by `make types` from the program's own description; change that, not this file."
#: Written by hand, for it does not fit into memory.
BY_HAND = frozenset({"download_recording"})
OPERATOR = "X-HBBA-Operator"

Schema = dict[str, Any]


def description() -> Schema:
    """The OpenAPI document of a console."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder)
        return create_app(build(made)[0], static_dir=write_page(made), early_view=False).openapi()


# --- Records -----------------------------------------------------------------------------------------------------


def records(document: Schema) -> str:
    """The text of ``records.py``: a Struct for each record of REST and the live stream."""
    declared = dict(document["components"]["schemas"])
    for name, live in schema.sent(message.record for message in FROM_ROBOT.values()).items():
        declared.setdefault(name, live)
    about = f"""What the program and its clients send each other.

{WRITTEN}
Stamps are the robot's clock, in seconds of the Unix epoch. Angles are radians, lengths metres.
"""
    parts = [
        f'"""{about}"""\n',
        "from __future__ import annotations\n",
        "from typing import Any, Literal\n",
        "from msgspec import UNSET, Struct, UnsetType\n",
    ]
    structs = {name: each for name, each in sorted(declared.items()) if "properties" in each}
    parts += [struct(name, each) for name, each in structs.items()]
    parts += [f"{name} = {python(each)}\n" for name, each in sorted(declared.items()) if name not in structs]
    lines = [f'    "{kind}": {message.record.__name__},' for kind, message in sorted(FROM_ROBOT.items())]
    table = ["#: The live stream's messages by type.", "LIVE: dict[str, type[Struct]] = {", *lines, "}\n"]
    parts.append("\n".join(table))
    return "\n\n".join(parts)


def struct(name: str, declared: Schema) -> str:
    """The declaration of the record ``name``: what may be left out comes last, and is left out by default."""
    needed = declared.get("required", ())
    members = sorted(declared["properties"].items(), key=lambda member: member[0] not in needed)
    renamed = {member: attribute for member, _ in members if (attribute := attribute_of(member)) != member}
    options = ["kw_only=True", "frozen=True"]
    if len(needed) < len(members):
        options.append("omit_defaults=True")
    if renamed:
        pairs = ", ".join(f'"{attribute}": "{member}"' for member, attribute in renamed.items())
        options.append(f"rename={{{pairs}}}")
    lines = [f"class {name}(Struct, {', '.join(options)}):", *docstring(declared.get("description", name), 4), ""]
    for member, value in members:
        kind = python(value)
        if member not in needed:
            kind = f"{_union([*kind.split(' | '), 'UnsetType'])} = UNSET"
        lines += [f"    {renamed.get(member, member)}: {kind}", *docstring(value.get("description", ""), 4)]
    return "\n".join(lines) + "\n"


def attribute_of(member: str) -> str:
    """``member`` as a name of Python."""
    return f"{member}_" if keyword.iskeyword(member) else member


def docstring(text: str, indent: int) -> list[str]:
    """``text`` as a docstring; no lines for none."""
    if not text.strip():
        return []
    space = " " * indent
    paragraphs = [
        textwrap.wrap(" ".join(paragraph.split()), WIDTH - indent - 6, break_long_words=False)
        for paragraph in re.split(r"\n\s*\n", text.strip().replace("\\", "\\\\").replace('"""', "'''"))
    ]
    lines = [line for index, paragraph in enumerate(paragraphs) for line in ([""] if index else []) + paragraph]
    if len(lines) == 1:
        return [f'{space}"""{lines[0]}"""']
    return [f'{space}"""{lines[0]}', *(f"{space}{line}" if line else "" for line in lines[1:]), f'{space}"""']


def python(value: Schema) -> str:
    """The type of a value. Raises TypeError where there is none for ``value``."""
    if "$ref" in value:
        return str(value["$ref"]).rpartition("/")[2]
    if "const" in value:
        return f"Literal[{value['const']!r}]"
    if "enum" in value:
        return f"Literal[{', '.join(map(repr, value['enum']))}]"
    if choices := value.get("anyOf") or value.get("oneOf"):
        return _union(python(each) for each in choices)
    match value.get("type"):
        case "string":
            return "bytes" if value.get("format") == "binary" else "str"
        case "boolean":
            return "bool"
        case "null":
            return "None"
        case "integer":
            return "int"
        case "number":
            return "float"
        case "array":
            return _list(value)
        case "object":
            return _mapping(value)
        case [*kinds]:
            return _union(python({"type": kind}) for kind in kinds)
        case None:
            return "Any"
    raise TypeError(f"no type of Python is known for {value}")


def _union(kinds: Iterable[str]) -> str:
    """Each once, None last."""
    return " | ".join(sorted(dict.fromkeys(kinds), key=lambda kind: kind == "None"))


def _list(value: Schema) -> str:
    places = value.get("prefixItems")
    if places is None and value.get("minItems") == value.get("maxItems") is not None:
        places = [value["items"]] * int(value["minItems"])
    if places is not None:
        return f"tuple[{', '.join(python(place) for place in places)}]"
    return f"list[{python(value.get('items', {}))}]"


def _mapping(value: Schema) -> str:
    if value.get("properties"):
        raise TypeError(f"an object within a record is a record itself, not {value}")
    values = value.get("additionalProperties")
    if keyed := value.get("patternProperties"):
        (values,) = keyed.values()
    return f"dict[str, {python(values) if isinstance(values, dict) else 'Any'}]"


# --- Operations --------------------------------------------------------------------------------------------------


def operations(document: Schema) -> str:
    """The text of ``operations.py``: a method for each operation, once to be called and once to be awaited."""
    found = found_operations(document)
    used = sorted({name for each in found for name in _names(each[3])} & set(document["components"]["schemas"]))
    parts = [
        f'"""The operations of REST.\n\n{WRITTEN}\n"""\n',
        "from __future__ import annotations\n",
        "from abc import ABC, abstractmethod\nfrom typing import Any, Literal\n",
        "from .records import (\n" + "".join(f"    {name},\n" for name in used) + ")\nfrom .request import Request\n",
        _class("Operations", found, awaited=False),
        _class("AsyncOperations", found, awaited=True),
    ]
    return "\n\n".join(parts)


def found_operations(document: Schema) -> list[tuple[str, str, str, Schema]]:
    """Name, method, path below ``/api/v1`` and description of each operation."""
    return sorted(
        (operation["operationId"], method.upper(), path.removeprefix(BASE), operation)
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
        if operation["operationId"] not in BY_HAND
    )


def _names(operation: Schema) -> Iterator[str]:
    """The records in what ``operation`` takes and gives."""
    for text in (_answer(operation), (_body(operation) or ([], ""))[1]):
        yield from re.findall(r"\w+", text)


def _class(name: str, found: list[tuple[str, str, str, Schema]], *, awaited: bool) -> str:
    word = "async def" if awaited else "def"
    lines = [
        f"class {name}(ABC):",
        '    """What the program can be asked for; each method says which role may."""',
        "",
        "    @abstractmethod",
        f"    {word} ask(self, request: Request) -> Any:",
        '        """The answer to ``request``. Raises Problem for a refusal."""',
    ]
    for each in found:
        lines += ["", *_method(*each, awaited=awaited)]
    return "\n".join(lines) + "\n"


def _method(name: str, method: str, path: str, operation: Schema, *, awaited: bool) -> list[str]:
    arguments, given = ["self"], [f'"{method}"', f'{"f" if "{" in path else ""}"{path}"', _answer(operation)]
    options: list[str] = []
    query: list[str] = []
    headers: list[str] = []
    for each in operation.get("parameters", ()):
        if each["name"] == OPERATOR:
            continue
        argument = attribute_of(each["name"].lower().replace("-", "_"))
        if each["in"] == "path":
            arguments.append(f"{argument}: {python(each['schema'])}")
            given[1] = given[1].replace(f"{{{each['name']}}}", f"{{Request.quoted({argument})}}")
            continue
        kind = python(each["schema"])
        options.append(f"{argument}: {kind if 'None' in kind else f'{kind} | None'} = None")
        (query if each["in"] == "query" else headers).append(f'"{each["name"]}": {argument}')
    if body := _body(operation):
        arguments.append(f"body: {body[1]}")
        given.append("body=body")
        first, *others = body[0]
        if others:
            options.append(f"media: Literal[{', '.join(map(repr, body[0]))}] = {first!r}")
            given.append("media=media")
        elif first != "application/json":
            given.append(f'media="{first}"')
    if query:
        given.append(f"query={{{', '.join(query)}}}")
    if headers:
        given.append(f"headers={{{', '.join(headers)}}}")
    answer = given[2]
    if answer != "None" and "204" in operation["responses"]:
        answer = f"{answer} | None"
    given[2] = answer
    shown = ", ".join([*arguments, *(["*", *options] if options else [])])
    about = f"{operation['summary']}.\n\n{operation.get('description', '')}\n\nRole: {operation.get('x-role', 'any')}."
    word, wait = ("async def", "await ") if awaited else ("def", "")
    return [
        f"    {word} {name}({shown}) -> {answer}:",
        *docstring(about, 8),
        f"        result: {answer} = {wait}self.ask(Request({', '.join(given)}))" if answer != "None" else "",
        "        return result" if answer != "None" else f"        {wait}self.ask(Request({', '.join(given)}))",
    ]


def answered_media(operation: Schema) -> str | None:
    """The media type of what is answered where nothing went wrong; None: nothing is."""
    for status, response in sorted(operation["responses"].items()):
        if status < "400" and (media := next(iter(response.get("content", {})), None)):
            return str(media)
    return None


def answered(operation: Schema) -> Schema:
    """The schema of what is answered where nothing went wrong."""
    for status, response in sorted(operation["responses"].items()):
        for content in response.get("content", {}).values() if status < "400" else ():
            return dict(content.get("schema", {}))
    return {}


def body_of(operation: Schema) -> tuple[list[str], Schema, bool] | None:
    """Media types and schema of what is sent, and whether it is needed."""
    content = operation.get("requestBody", {}).get("content", {})
    if not content:
        return None
    schemas = [each["schema"] for each in content.values()]
    value = schemas[0] if all(each == schemas[0] for each in schemas) else {"anyOf": schemas}
    return list(content), value, "None" not in python(value)


def _answer(operation: Schema) -> str:
    """The type of what is answered where nothing went wrong."""
    media = answered_media(operation)
    if media is None:
        return "None"
    kind = python(answered(operation))
    return kind if media == "application/json" or kind == "bytes" else "str"


def _body(operation: Schema) -> tuple[list[str], str] | None:
    """The media types and the type of what is sent."""
    if (body := body_of(operation)) is None:
        return None
    media, value, needed = body
    return media, python(value) if needed else f"{python(value)} = None"


def generate() -> dict[Path, str]:
    """The texts of the generated files, before they are formatted."""
    document = description()
    return {PACKAGE / "records.py": records(document), PACKAGE / "operations.py": operations(document)}


def formatted(text: str) -> str:
    """``text`` as ruff formats it."""
    ruff = Path(sys.executable).with_name("ruff")
    for task in (["check", "--select", "I", "--fix", "--quiet"], ["format"]):
        command = [str(ruff), *task, "--stdin-filename", str(PACKAGE / "records.py"), "-"]
        text = subprocess.run(command, input=text, capture_output=True, text=True, check=True, cwd=ROOT).stdout
    return text


def main() -> None:
    """Write the files, and say which changed."""
    for file, text in generate().items():
        text = formatted(text)
        changed = not file.exists() or file.read_text("utf-8") != text
        file.write_text(text, "utf-8")
        sys.stdout.write(f"{file.relative_to(ROOT)} {'changed' if changed else 'is as it was'}\n")


if __name__ == "__main__":
    main()

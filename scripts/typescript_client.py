"""The TypeScript client's records and operations, made of the descriptions of REST and of the live stream.

    make types     write clients/typescript/src/records.ts and operations.ts, too

A test compares the files with the descriptions.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import client_types
import page_types

from app.console import schema
from app.console.live.messages import FROM_ROBOT

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "clients" / "typescript" / "src"
WRITTEN = "Written by `make types` from the program's own description; change that, not this file."

Schema = dict[str, Any]


def plain(value: Any) -> Any:
    """``value`` with its references as names of types."""
    if isinstance(value, dict):
        return {
            key: each.rpartition("/")[2] if key == "$ref" else plain(each)
            for key, each in value.items()
            if key != "title"
        }
    return [plain(each) for each in value] if isinstance(value, list) else value


def records(document: Schema) -> str:
    """The text of ``records.ts``: an interface for each record of REST and the live stream."""
    declared: Schema = plain(document["components"]["schemas"])
    for name, live in schema.sent((message.record for message in FROM_ROBOT.values()), "{name}").items():
        declared.setdefault(name, plain(live))
    about = f"What the program and its clients send each other. {WRITTEN}"
    parts = [f"/**\n * {about}\n * Stamps are the robot's clock, in seconds.\n */\n"]
    for name, each in sorted(declared.items()):
        if "properties" in each:
            parts.append(page_types.interface(name, each))
        else:
            parts.append(f"export type {name} = {page_types.typescript(each)};\n")
    lines = [f"  {kind}: {message.record.__name__};" for kind, message in sorted(FROM_ROBOT.items())]
    parts.append(
        "\n".join(["/** The live stream's messages by `type`. */", "export interface LiveRecords {", *lines, "}\n"])
    )
    parts.append(
        "export type LiveMessage = { [T in keyof LiveRecords]: { type: T } & LiveRecords[T] }[keyof LiveRecords];\n"
    )
    return "\n".join(parts)


def operations(document: Schema) -> str:
    """The text of ``operations.ts``: a method for each operation."""
    found = client_types.found_operations(document)
    methods = [line for each in found for line in ["", *_method(*each)]]
    text = "\n".join(methods)
    used = sorted(name for name in document["components"]["schemas"] if re.search(rf"\b{name}\b", text))
    return "\n".join(
        [
            f"/** The operations of REST. {WRITTEN} */",
            "",
            'import type { Request } from "./request.js";',
            "import type {",
            *(f"  {name}," for name in used),
            '} from "./records.js";',
            "",
            "/** What the program can be asked for; each method says which role may. */",
            "export abstract class Operations {",
            "  /** The answer to `request`. Throws Problem for a refusal. */",
            "  protected abstract ask<T>(request: Request): Promise<T>;",
            *methods,
            "}\n",
        ]
    )


def _method(name: str, method: str, path: str, operation: Schema) -> list[str]:
    arguments: list[str] = []
    options: list[str] = []
    query: list[str] = []
    headers: list[str] = []
    for each in operation.get("parameters", ()):
        if each["name"] == client_types.OPERATOR:
            continue
        argument = camel(each["name"].lower().replace("-", "_"))
        kind = page_types.typescript(plain(each["schema"]))
        if each["in"] == "path":
            arguments.append(f"{argument}: {kind}")
            path = path.replace(f"{{{each['name']}}}", f"${{encodeURIComponent({argument})}}")
            continue
        options.append(f"{argument}?: {kind}")
        (query if each["in"] == "query" else headers).append(f'"{each["name"]}": options.{argument}')
    given = [f'method: "{method}"', f"path: `{path}`", f'answer: "{_form(operation)}"']
    if body := client_types.body_of(operation):
        (first, *others), value, needed = body
        arguments.append(f"body{'' if needed else '?'}: {sent(value)}")
        given.append("body")
        if others:
            options.append(f"media?: {' | '.join(map(json.dumps, [first, *others]))}")
            given.append(f'media: options.media ?? "{first}"')
        elif first != "application/json":
            given.append(f'media: "{first}"')
    if options:
        arguments.append(f"options: {{ {'; '.join(options)} }} = {{}}")
    for word, members in (("query", query), ("headers", headers)):
        if members:
            given.append(f"{word}: {{ {', '.join(members)} }}")
    answer = _answer(operation)
    about = " ".join(f"{operation['summary']}. {operation.get('description', '')}".split())
    return [
        *page_types.comment(f"{about} Role: {operation.get('x-role', 'any')}.", "  "),
        f"  {camel(name)}({', '.join(arguments)}): Promise<{answer}> {{",
        f"    return this.ask<{answer}>({{ {', '.join(given)} }});",
        "  }",
    ]


def sent(value: Schema) -> str:
    """The type of what is sent: text, the bytes of a file, or a record."""
    if choices := value.get("anyOf"):
        return " | ".join(dict.fromkeys(sent(each) for each in choices))
    return "ArrayBuffer" if value.get("format") == "binary" else page_types.typescript(plain(value))


def _form(operation: Schema) -> str:
    media = client_types.answered_media(operation)
    if media is None:
        return "nothing"
    if media == "application/json":
        return "json"
    return "text" if media in ("application/yaml", "text/csv") else "bytes"


def _answer(operation: Schema) -> str:
    form = _form(operation)
    if form == "json":
        kind = page_types.typescript(plain(client_types.answered(operation)))
        return f"{kind} | undefined" if "204" in operation["responses"] else kind
    return {"nothing": "void", "text": "string", "bytes": "ArrayBuffer"}[form]


def camel(name: str) -> str:
    """``snake_case`` as ``camelCase``."""
    first, *rest = name.split("_")
    return first + "".join(word.capitalize() for word in rest)


def generate() -> dict[Path, str]:
    """The texts of the generated files."""
    document = client_types.description()
    return {SOURCES / "records.ts": records(document), SOURCES / "operations.ts": operations(document)}


def main() -> None:
    """Write the files, and say which changed."""
    for file, text in generate().items():
        changed = not file.exists() or file.read_text("utf-8") != text
        file.write_text(text, "utf-8")
        sys.stdout.write(f"{file.relative_to(ROOT)} {'changed' if changed else 'is as it was'}\n")


if __name__ == "__main__":
    main()

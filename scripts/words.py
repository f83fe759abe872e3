"""Counts private words in the prose of the project. Standard library only.

A private word is one that a roboticist would not search for, or that puts a person in the place of a thread, a
subscriber or a process: ``told`` for published, ``whoever`` for a caller, ``anew`` for again. Prose is docstrings and
comments of Python files, and the text of Markdown files without code. Literals (``name``) are not prose.

    python scripts/words.py            # figures by room; status 1 above the limit, with file:line of each
    python scripts/words.py --list     # file:line of each in any case
    python scripts/words.py --quiet    # nothing unless above the limit
    python scripts/words.py FILE...    # these files alone
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: Private words that may be left among 10,000 of a group.
LIMIT = 5.0

PRIVATE = re.compile(
    r"\b(tells?|told|telling|heed(?:s|ed|ing)?|liv(?:es|ed)|anew|dear(?:er|est|ly)?|who(?:m)?ever|nobody|somebody|hands"
    r"|stands|begun|thereby|hence)\b",
    re.IGNORECASE,
)
#: Exceptions: the end of a file's path, the phrase, and the reason.
ALLOWED: tuple[tuple[str, str, str], ...] = ()

_WORD = re.compile(r"[A-Za-z']+")
_LITERAL = re.compile(r"``[^`]+``|`[^`]+`")
_FENCE = re.compile(r"\s*(```|~~~)")
_RELEASE = re.compile(r"## \[\d")

Line = tuple[int, str]


@dataclass(frozen=True)
class Finding:
    """A private ``word`` in line ``line`` of ``path``."""

    path: Path
    line: int
    word: str

    def __str__(self) -> str:
        return f"{shown(self.path)}:{self.line}: {self.word}"


def python_prose(source: str) -> Iterator[Line]:
    """Line number and text of each line of a docstring or comment. Raises SyntaxError for what is no Python."""
    lines = source.splitlines()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            for number in range(node.lineno, (node.end_lineno or node.lineno) + 1):
                yield number, lines[number - 1]
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def markdown_prose(text: str) -> Iterator[Line]:
    """Line number and text of each line outside of code; of a changelog, what belongs to no released version."""
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if _RELEASE.match(line):
            return
        if _FENCE.match(line):
            fenced = not fenced
        elif not fenced and not line.startswith("    "):
            yield number, line


def measured(path: Path) -> tuple[int, list[Finding]]:
    """Number of words of prose in ``path``, and the private ones among them."""
    text = path.read_text(encoding="utf-8")
    prose = python_prose(text) if path.suffix == ".py" else markdown_prose(text)
    words = 0
    findings: list[Finding] = []
    for number, line in prose:
        said = _LITERAL.sub("", line)
        for ending, phrase, _reason in ALLOWED:
            if path.as_posix().endswith(ending):
                said = said.replace(phrase, "")
        words += len(_WORD.findall(said))
        findings += [Finding(path, number, match.group()) for match in PRIVATE.finditer(said)]
    return words, findings


def groups(root: Path) -> dict[str, list[Path]]:
    """Files by group: each room of ``app/`` and of ``tests/``, the other Python, and the papers."""
    rooms: dict[str, list[Path]] = {}
    for top in ("app", "tests", "benchmarks", "scripts"):
        for path in sorted((root / top).rglob("*.py")):
            parts = path.relative_to(root).parts
            rooms.setdefault("/".join(parts[:2]) if len(parts) > 2 else top, []).append(path)
    papers = (root / f"{name}.md" for name in ("README", "ARCHITECTURE", "CONTRIBUTING", "CHANGELOG"))
    rooms["docs"] = [*sorted((root / "docs").glob("*.md")), *(paper for paper in papers if paper.is_file())]
    return rooms


def rate(words: int, findings: list[Finding]) -> float:
    """Private words among 10,000; 0.0 where there is no word."""
    return 1e4 * len(findings) / words if words else 0.0


def report(root: Path, *, listing: bool = False, quiet: bool = False) -> int:
    """Print the figures of all groups; returns 1 if the whole of ``app/`` or the papers are above the limit, else 0.

    ``listing``: print each private word; ``quiet``: print nothing below the limit.
    """
    whole: dict[str, tuple[int, list[Finding]]] = {"app": (0, []), "docs": (0, [])}
    for name, files in groups(root).items():
        if quiet and name.split("/")[0] not in whole:
            continue  # it is not printed, and decides nothing
        words, findings = total(files)
        if not quiet:
            print(f"{name:18} {words:7d} words  {len(findings):4d} private  {rate(words, findings):6.1f} per 10,000")
        part = name.split("/")[0]
        if part in whole:
            whole[part] = whole[part][0] + words, whole[part][1] + findings
        if listing:
            print(*(f"  {finding}" for finding in findings), sep="\n")
    status = 0
    for name, (words, findings) in whole.items():
        if rate(words, findings) > LIMIT:
            status = 1
            print(f"\n{name}: {rate(words, findings):.1f} private words among 10,000, at most {LIMIT:g} may be:")
            if not listing:
                print(*(f"  {finding}" for finding in findings), sep="\n")
    return status


def total(files: Iterable[Path]) -> tuple[int, list[Finding]]:
    """As :func:`measured`, for all ``files``."""
    words = 0
    findings: list[Finding] = []
    for path in files:
        more, found = measured(path)
        words, findings = words + more, findings + found
    return words, findings


def shown(path: Path) -> str:
    """``path`` as people read it: from the project's folder where it is in there."""
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else str(path)


def main() -> int:
    """Print the figures; the status is 1 where they are above the limit."""
    parser = argparse.ArgumentParser(prog="scripts/words.py", description="Private words in docstrings, comments, docs")
    parser.add_argument("files", nargs="*", type=Path, help="these alone: file:line of each private word")
    parser.add_argument("--list", action="store_true", help="file:line of each private word, below the limit too")
    parser.add_argument("--quiet", action="store_true", help="print nothing below the limit")
    args = parser.parse_args()
    if not args.files:
        return report(ROOT, listing=args.list, quiet=args.quiet)
    _words, findings = total(path.resolve() for path in args.files)
    for finding in findings:
        print(finding)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())

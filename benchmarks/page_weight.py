"""What a browser loads for the operator page: each file as the console sends it, and all, without viser's 3D view.

The files are those that the built ``index.html`` names, and those that they name in turn (workers, parts loaded later).
*Ours* is what comes with Brotli (https and localhost), the peer gzip (elsewhere); of all, the goal of 200 kB. A browser
loads the words of a language other than English when it is chosen.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

from app.base.paths import static_dir
from app.console.page import CODINGS
from benchmarks.report import Row, benchmark_main, row

GOAL_KB = 200.0
#: Pages of their own, to which the operator page links.
OTHER_PAGES = ("face", "rest", "visitor")
#: Parts that are loaded for one language, by the begin of their names.
LANGUAGES = {"fr-": "French"}


def loaded(static: Path, entry: str = "index.html") -> list[Path]:
    """The files under ``static`` that ``entry`` leads to, itself first. Raises SystemExit where it is not built."""
    first = static / entry
    if not first.is_file():
        raise SystemExit(
            f"page_weight: there is no {first}; `make run` builds the page, as does `npm run build` in web/"
        )
    there = {path.name: path for path in static.rglob("*") if path.suffix in (".js", ".css", ".svg")}
    found, left = [first], [first]
    while left:
        text = left.pop().read_text(encoding="utf-8")
        for name in re.findall(r"[\w.-]+\.(?:js|css|svg)\b", text):
            path = there.get(name)
            if path is not None and path not in found and not name.startswith(OTHER_PAGES):
                found.append(path)
                left.append(path)
    return found


def sent(path: Path, coding: str) -> int:
    """The bytes of a file as sent to a browser that takes ``coding``: packed, if the build packed it so."""
    packed = path.with_name(path.name + CODINGS[coding])
    return (packed if packed.is_file() else path).stat().st_size


def measure(static: Path) -> Sequence[Row]:
    """Each file of the page built in ``static``, and all of them in each language."""
    rows = []
    totals = {language: {"br": 0.0, "gzip": 0.0} for language in ("English", *LANGUAGES.values())}
    for path in loaded(static):
        # Without the hash of its content, which Vite puts behind the name.
        name = re.sub(r"-[\w-]{8}(?=\.\w+$)", "", path.name)
        sizes = {coding: 1e-3 * sent(path, coding) for coding in CODINGS}
        rows.append(row("page_weight", name, "Brotli", "kB", [sizes["br"]], [sizes["gzip"]], "gzip"))
        of = next((language for begin, language in LANGUAGES.items() if path.name.startswith(begin)), None)
        for language in totals if of is None else (of,):
            for coding, size in sizes.items():
                totals[language][coding] += size
    for language, total in totals.items():
        for coding, named in (("br", "Brotli"), ("gzip", "gzip")):
            rows.append(row("page_weight", f"all in {language}", named, "kB", [total[coding]], [GOAL_KB], "the goal"))
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(static_dir())))

"""What a browser loads for the operator page: each file as the console sends it, and all, without viser's 3D view.

The files are those that the built ``index.html`` names, and those that they name in turn. *Opening* is what comes
before the page is there: scripts and style, what these import, workers, and the words of the reader's language other
than English. *All* has the parts too that come when they are first shown: tours, load, graph, recordings, forms. *Ours*
is what comes with Brotli (https and localhost), the peer gzip (elsewhere); of sums, the goal of 200 kB.
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


#: A file that a script or page names in any way; and in one that a browser follows at once: not ``import(...)``.
NAMED = re.compile(r"([\w.-]+\.(?:js|css|svg))\b")
AT_ONCE = re.compile(
    r"""(?:src=|href=|from|import|new URL\()\s*["'`](?:[./]*assets/|\./)?([\w.-]+\.(?:js|css|svg))["'`]"""
)


def loaded(static: Path, names: re.Pattern[str] = NAMED, entry: str = "index.html") -> list[Path]:
    """The files under ``static`` that ``entry`` leads to by ``names``, itself first.

    Raises SystemExit where it is not built.
    """
    first = static / entry
    if not first.is_file():
        raise SystemExit(
            f"page_weight: there is no {first}; `make run` builds the page, as does `npm run build` in web/"
        )
    there = {path.name: path for path in static.rglob("*") if path.suffix in (".js", ".css", ".svg")}
    found, left = [first], [first]
    while left:
        text = left.pop().read_text(encoding="utf-8")
        for name in names.findall(text):
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
    """Each file of the page built in ``static``, and in each language those of the opening and all of them."""
    rows = []
    at_once = set(loaded(static, AT_ONCE))
    sums = {
        (which, language): dict.fromkeys(CODINGS, 0.0)
        for which in ("opening", "all")
        for language in ("English", *LANGUAGES.values())
    }
    for path in loaded(static):
        # Without the hash of its content, which Vite puts behind the name.
        name = re.sub(r"-[\w-]{8}(?=\.\w+$)", "", path.name)
        sizes = {coding: 1e-3 * sent(path, coding) for coding in CODINGS}
        rows.append(row("page_weight", name, "Brotli", "kB", [sizes["br"]], [sizes["gzip"]], "gzip"))
        of = next((language for begin, language in LANGUAGES.items() if path.name.startswith(begin)), None)
        for (which, language), total in sums.items():
            if of == language or (of is None and (which == "all" or path in at_once)):
                for coding, size in sizes.items():
                    total[coding] += size
    for (which, language), total in sums.items():
        for coding, named in (("br", "Brotli"), ("gzip", "gzip")):
            case = f"{which} in {language}"
            rows.append(row("page_weight", case, named, "kB", [total[coding]], [GOAL_KB], "the goal"))
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(static_dir())))

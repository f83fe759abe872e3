"""What counts as loaded for the operator page."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base.paths import static_dir
from benchmarks.page_weight import GOAL_KB, loaded, measure


def built(static: Path) -> None:
    """A page: a script that names a worker and links to another page, one file packed."""
    assets = static / "assets"
    assets.mkdir()
    (static / "index.html").write_text('<script src="./assets/index-0123abcd.js"></script>')
    (assets / "index-0123abcd.js").write_text(
        'import{a}from"./preact-0123abcd.js";new Worker(new URL("stop-0123abcd.js",import.meta.url));'
        '"./assets/face-0123abcd.js";import("./fr-0123abcd.js");import("./tours-0123abcd.js")'
    )
    (assets / "index-0123abcd.js.br").write_bytes(bytes(30))
    (assets / "index-0123abcd.js.gz").write_bytes(bytes(40))
    (assets / "stop-0123abcd.js").write_text("x" * 500)
    (assets / "preact-0123abcd.js").write_text("z" * 10)
    (assets / "tours-0123abcd.js").write_text('import{b}from"./index-0123abcd.js"'.ljust(1000))
    (assets / "fr-0123abcd.js").write_text("y" * 200)
    (assets / "face-0123abcd.js").write_text("of another page")
    (assets / "old-0123abcd.js").write_text("of nobody")


def test_what_the_page_names_is_weighed_as_it_is_sent(tmp_path: Path) -> None:
    built(tmp_path)
    html = (tmp_path / "index.html").stat().st_size
    rows = {(each.case, each.metric): each for each in measure(tmp_path)}
    assert [case for case, _ in rows] == [
        "index.html",
        "index.js",
        "preact.js",
        "stop.js",
        "fr.js",
        "tours.js",
        *("opening in English",) * 2,
        *("opening in French",) * 2,
        *("all in English",) * 2,
        *("all in French",) * 2,
    ]
    assert (rows["index.js", "Brotli"].ours, rows["index.js", "Brotli"].peer) == (0.03, 0.04)
    assert rows["stop.js", "Brotli"].ours == 0.5
    assert rows["all in English", "Brotli"].ours == pytest.approx(1e-3 * (html + 30 + 510 + 1000))
    assert rows["all in French", "Brotli"].ours == pytest.approx(1e-3 * (html + 30 + 200 + 510 + 1000))
    assert rows["all in English", "gzip"].ours == pytest.approx(1e-3 * (html + 40 + 510 + 1000))
    assert rows["opening in English", "Brotli"].ours == pytest.approx(1e-3 * (html + 30 + 510))
    assert rows["opening in French", "Brotli"].ours == pytest.approx(1e-3 * (html + 30 + 200 + 510))
    assert rows["all in English", "gzip"].peer == 200


def test_a_page_that_is_not_built_ends_it_in_words(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="builds the page"):
        loaded(tmp_path)


def test_the_page_that_is_built_opens_within_the_goal() -> None:
    if not (static_dir() / "index.html").is_file():
        pytest.skip("the page is not built: npm run build in web/")
    opening = {(each.case, each.metric): each.ours for each in measure(static_dir()) if each.case.startswith("opening")}
    assert len(opening) == 4
    assert {case: weight for case, weight in opening.items() if weight > GOAL_KB} == {}

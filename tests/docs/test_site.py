"""The documentation as a site: it builds with every link checked, and is read without a network."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(importlib.util.find_spec("mkdocs") is None, reason="the extra `docs` is not installed"),
]

#: What a browser fetches by itself.
FETCHED = re.compile(
    r'<(?:script|img|iframe)[^>]*\ssrc="?(?:https?:)?//|<link[^>]*stylesheet[^>]*href="?(?:https?:)?//'
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site of this checkout, built elsewhere by the script behind ``make docs``."""
    root = tmp_path_factory.mktemp("checkout")
    for entry in ROOT.iterdir():
        if entry.name != "build":
            (root / entry.name).symlink_to(entry)
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'scripts')!r}); import documentation; "
        f"from pathlib import Path; sys.exit(documentation.build(Path({str(root)!r})))"
    )
    # A proxy that is not there: a build that asks the network for something fails.
    nowhere = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")
    environment = {**os.environ, **nowhere}
    built = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr
    return root / "build" / "site"


def test_every_page_is_there(site: Path) -> None:
    assert (site / "index.html").is_file()
    for page in ROOT.glob("docs/*.md"):
        assert (site / "docs" / f"{page.stem}.html").is_file(), page


def test_the_reference_says_what_docstrings_say(site: Path) -> None:
    page = (site / "reference" / "runtime.html").read_text(encoding="utf-8")
    assert 'id="app.runtime.filter.RateFilter"' in page
    assert "Counts messages and lets one in" in page
    assert ":class:`" not in page


def test_nothing_is_fetched_while_reading(site: Path) -> None:
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 30
    assert [str(page) for page in pages if FETCHED.search(page.read_text(encoding="utf-8"))] == []
    assert (site / "search" / "search_index.js").is_file(), "from files, the search reads a script"

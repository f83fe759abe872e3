"""``make docs``: the documentation as a site in ``build/site``, readable from files and without a network.

The pages are the repository's own; the reference is made of docstrings (mkdocstrings), without importing what it reads.
A link that leads nowhere is an error.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGES = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")
#: What the reference describes: modules, and packages with all their public modules.
REFERENCE = ("messages", "link", "runtime", "attention", "maps", "tours", "logs", "program", "base")
_LINK = re.compile(r"\]\(([^)#\s:]+)(?:#[^)\s]*)?\)")


def gather(folder: Path, root: Path = ROOT) -> None:
    """Put into ``folder``, emptied first, all pages, the files that they link to, and the pages of the reference."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in PAGES:
        shutil.copy(root / name, folder / name)
    shutil.copytree(root / "docs", folder / "docs")
    for page in [*folder.glob("*.md"), *folder.glob("docs/*.md")]:
        for target in _LINK.findall(page.read_text(encoding="utf-8")):
            linked = (page.parent / target).resolve()
            source = root / linked.relative_to(folder.resolve())
            if source.is_file() and not linked.exists():
                linked.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, linked)
    (folder / "reference").mkdir()
    for name in REFERENCE:
        (folder / "reference" / f"{name}.md").write_text(reference(name, root), encoding="utf-8")


def reference(name: str, root: Path = ROOT) -> str:
    """The page of ``app.NAME``: mkdocstrings' directives for it and its public modules."""
    place = root / "app" / name
    files = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    modules = []
    for file in files:
        parts = file.relative_to(root).with_suffix("").parts
        if not any(part.startswith("_") for part in parts):
            modules.append(".".join(parts))
    package = f"::: app.{name}\n    options: {{members: false}}\n\n" if place.is_dir() else ""
    return f"# `app.{name}`\n\n" + package + "".join(f"::: {module}\n\n" for module in modules)


def build(root: Path = ROOT) -> int:
    """Build the site; the status of mkdocs."""
    gather(root / "build" / "documentation", root)
    command = [sys.executable, "-m", "mkdocs", "build", "--clean", "--config-file", str(root / "mkdocs.yml")]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}  # the theme's advertisement of its successor
    status = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, cwd=root, check=False).returncode
    if status == 0:
        sys.stdout.write("The documentation is in build/site/index.html\n")
    return status


if __name__ == "__main__":
    sys.exit(build())

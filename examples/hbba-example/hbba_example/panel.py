"""The panel of the page."""

from __future__ import annotations

from pathlib import Path

from app.console.panels import Panel

NEAR_THINGS = Panel("Near things", Path(__file__).with_name("panel.js"), ("channel/near_things",))

"""How long tests wait for an event: it comes, however busy the computer, or something is broken."""

from __future__ import annotations

#: Seconds. A test waits so long only where it is about to fail.
PATIENCE_S = 420.0
#: The same for a browser.
PATIENCE_MS = PATIENCE_S * 1e3

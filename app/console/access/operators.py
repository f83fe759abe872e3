"""Names of operators."""

from __future__ import annotations

from urllib.parse import unquote

LONGEST_NAME = 40


def operator_name(given: str | None) -> str:
    """The name of an operator: ``given``, percent-encoded, as far as it is printable and at most 40 characters;
    ``operator`` where nothing was said."""
    name = "".join(c for c in unquote(given or "") if c.isprintable()).strip()
    return name[:LONGEST_NAME] or "operator"

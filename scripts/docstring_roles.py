"""An extension of griffe, which reads docstrings for the documentation's site: roles of Sphinx become names as code."""

from __future__ import annotations

import re
from typing import Any

from griffe import Extension, Object

_ROLE = re.compile(r":(?:attr|class|data|exc|func|meth|mod):`~?([^`]+)`")


def as_code(docstring: str) -> str:
    """``docstring`` with the names that roles mark as code."""
    return _ROLE.sub(r"`\1`", docstring)


class Roles(Extension):
    """Applies :func:`as_code` to every docstring that is read."""

    def on_object(self, *, obj: Object, **_: Any) -> None:
        """griffe has read ``obj``."""
        if obj.docstring is not None:
            obj.docstring.value = as_code(obj.docstring.value)

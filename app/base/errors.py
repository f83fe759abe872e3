"""The exceptions that more than one room raises, by meaning."""

from __future__ import annotations


class ConfigError(Exception):
    """A mistake in a file of the user.

    ``message`` is one sentence that names the mistake and what is allowed; ``file`` the file as the user named it;
    ``line`` counts from 1 (0: the file as a whole); ``key`` is the dotted path of the value, "" for the whole file.
    """

    def __init__(self, message: str, file: str = "", line: int = 0, key: str = "") -> None:
        where = f"{file}:{line}: " if file and line else f"{file}: " if file else ""
        super().__init__(f"{where}{message}")
        self.message = message
        self.file = file
        self.line = line
        self.key = key

"""The program that the clients speak with."""

from tests.console.conftest import app, body, built, page, system, url

__all__ = ["app", "body", "built", "page", "system", "url"]

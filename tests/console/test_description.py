"""The description of an application outlives neither it nor its routes."""

from __future__ import annotations

import gc
import weakref

from fastapi import FastAPI

from app.console.description import describe


def test_an_application_that_is_described_is_not_kept_for_ever() -> None:
    app = FastAPI(openapi_url=None)
    describe(app, "/api")
    paths = [getattr(route, "path", "") for route in app.routes]
    kept = weakref.ref(app)
    del app
    gc.collect()
    assert "/api/openapi.json" in paths
    assert kept() is None, "FastAPI's caches hold endpoints, and these hold the application"

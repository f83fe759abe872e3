"""REST under ``/api/v1`` (docs/rest.md)."""

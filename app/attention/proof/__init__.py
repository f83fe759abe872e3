"""Certificates of proven selections: written beside the solver, checked without it (docs/certificates.md)."""

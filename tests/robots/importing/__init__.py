"""Tests of the import of robot models."""

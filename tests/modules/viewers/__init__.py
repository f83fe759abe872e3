"""Tests of the servers for viewers of others."""

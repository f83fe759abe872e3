"""Servers for viewers of others."""

"""Modules on other computers: what they are, what goes over the network, and who may run them (docs/nodes.md)."""

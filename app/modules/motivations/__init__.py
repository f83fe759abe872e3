"""Motivations: modules that post desires into the Intention Workspace."""

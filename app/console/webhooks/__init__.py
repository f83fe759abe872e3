"""Webhooks: events of the timeline posted to other programs, as Standard Webhooks says."""

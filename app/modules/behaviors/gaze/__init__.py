"""Behaviors that direct the head: what is looked at, and the joint positions for it."""

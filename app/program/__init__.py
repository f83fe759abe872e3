"""The program put together from its configuration, and what it publishes about itself."""

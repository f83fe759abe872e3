"""Access to the console: login, sessions, limits of requests and connections."""

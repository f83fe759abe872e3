"""Who may use the console: login, sessions, limits of requests and connections."""

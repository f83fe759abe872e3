"""Living a log again: the program put together on a recorded body, and what is measured on it."""

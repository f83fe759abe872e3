"""The pursuit study (thesis 3.4): an operator follows a person over a link with delay, with and without prediction."""

"""Maps that are kept: their folder, their files, and the one way to whoever makes them."""

"""Finding faces in images, placing them in space, and following them: pure functions and small classes on values."""

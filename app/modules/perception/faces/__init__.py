"""Detection, position and tracking of faces: pure functions and small classes on values."""

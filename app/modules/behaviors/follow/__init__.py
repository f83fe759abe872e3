"""Following a person at a polite distance, and approaching one from the front."""

"""What the body senses, put on channels: nothing is computed here."""

"""Bodies: links to simulated, replayed and real robots, each with the guard between the program and its motors."""

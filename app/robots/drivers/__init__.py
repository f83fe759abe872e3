"""A robot of parts: a base, a laser and a gamepad at ports of this computer, behind a process that holds the guard."""

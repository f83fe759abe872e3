"""All actuator groups at once: behaviors under attention command them, and the guard's figures are taken."""

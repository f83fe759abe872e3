"""The overload experiment: a computer too small for everything, without and with attention (thesis 4.4.2)."""
